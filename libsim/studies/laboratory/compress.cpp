#include "libsim/studies/laboratory/compress.hpp"

#include <fmt/format.h>

#include <cmath>

namespace subsoil::sim {
namespace {

constexpr double seating = 0.02;
constexpr int rows_of_way = 2000;  // while a diameter is passed
constexpr std::size_t fewest_rows = 4;

/// Slope of stress over strain of the rows begin..end whose stress is at least `least`. Throws std::runtime_error for
/// fewer rows than make a slope. @param fast the lid passes more than a row in a step
double modulus(const SpecimenCurve& curve, std::size_t begin, std::size_t end, double least, bool fast) {
  std::vector<double> strain, stress;
  for (std::size_t i = begin; i < end; ++i)
    if (curve.rows[i][1] >= least) strain.push_back(curve.rows[i][0]), stress.push_back(curve.rows[i][1]);
  if (strain.size() < fewest_rows)
    throw std::runtime_error(fmt::format(
        "the upper half of the stress is passed in {} rows of the curve, which make no slope: {}", strain.size(),
        fast ? "the lid moves that far in a few steps; a lower `speed`"
             : "the contacts are stiff for it; a higher `stress`"));
  return fit_line(strain, stress).b;
}

struct Stresses {
  double lid = 0, floor = 0, sides = 0;
};

/// Means over so many steps; the lid goes on at its speed.
struct Press {
  Specimen& specimen;
  Lid& lid;
  const Specimen::BoxWalls& walls;
  double area, sides_area_per_height;

  Stresses over(long steps, double speed) {
    Stresses sum;
    for (long k = 0; k < steps; ++k) {
      specimen.step();
      sum.lid += lid.force();
      sum.floor -= specimen.force(walls.floor).y;
      sum.sides += specimen.force(walls.right).x - specimen.force(walls.left).x + specimen.force(walls.back).z -
                   specimen.force(walls.front).z;
      lid.drive(speed);
    }
    const auto n = static_cast<double>(steps);
    return {sum.lid / n / area, sum.floor / n / area, sum.sides / n / (sides_area_per_height * lid.height())};
  }
};

}  // namespace

Outcome Compress::press(Specimen& specimen, const Specimen::BoxWalls& walls, double area) const {
  const Sample& sample = specimen.sample();
  const double v = speed.value_or(sample.fall_speed() / 20);
  Lid lid(specimen, Wall::rough);
  Press press{specimen, lid, walls, area, 4 * std::sqrt(area)};
  const double steps_of_row = sample.diameter / rows_of_way / (v * specimen.dt());
  const long steps = std::max(1L, std::lround(steps_of_row));
  const bool fast = steps_of_row < 1;
  Outcome out;
  out.curve.columns = {{"strain", "1"}, {"stress", "Pa"}, {"stress on the floor", "Pa"}, {"stress on the walls", "Pa"}};
  double begin = 0;
  Stresses now;
  const auto row = [&] { out.curve.rows.push_back({(begin - lid.height()) / begin, now.lid, now.floor, now.sides}); };
  while (now.lid < stress) {
    now = press.over(steps, -v);
    if (begin == 0 && now.lid >= seating * stress) begin = lid.height();
    if (begin > 0) row();
    if (lid.height() < 2 * sample.diameter || lid.height() < 0.5 * begin)
      throw std::runtime_error(fmt::format(
          "the lid has gone half way down and bears only {:.4g} Pa of {:.4g} Pa; a lower `stress`", now.lid, stress));
  }
  const Stresses peak = now;
  const std::size_t turn = out.curve.rows.size();
  const double deepest = out.curve.rows.back()[0];
  // Turning round at once would send a wave through the packing.
  press.over(std::lround(sample.fall_time() / specimen.dt()), 0);
  while (now.lid > seating * stress) now = press.over(steps, v), row();
  const auto& rows = out.curve.rows;
  out.values = {modulus(out.curve, 0, turn, 0.5 * stress, fast),
                modulus(out.curve, turn, rows.size(), 0.5 * stress, fast), peak.sides / (0.5 * (peak.lid + peak.floor)),
                rows.back()[0] / deepest};
  return out;
}

Outcome Compress::run(const Sample& sample, std::size_t packing) const {
  const double d = sample.diameter, side = length.value_or(10 * d), high = depth.value_or(10 * d);
  Specimen specimen(sample);
  const Specimen::BoxWalls walls = specimen.box(side, side);
  specimen.fill({{}, {side, high, side}}, high, sample.seed + packing);
  specimen.cement();
  return press(specimen, walls, side * side);
}

Findings Compress::findings(const Sample&, std::size_t packings, const std::vector<Outcome>& outcomes) const {
  Findings found;
  found.test = "compress";
  found.numbers = numbers();
  Chart chart{.title = "uniaxial compression", .x_label = "strain [%]", .y_label = "stress [kPa]", .curves = {}};
  chart.from_zero = true;
  for (std::size_t p = 0; p < packings; ++p) {
    for (std::size_t k = 0; k < found.numbers.size(); ++k) found.numbers[k].values.push_back(outcomes[p].values[k]);
    const SpecimenCurve& curve = outcomes[p].curve;
    found.curves.push_back(curve);
    found.curves.back().name = fmt::format("packing-{}", p + 1);
    chart.curves.push_back({fmt::format("packing {}", p + 1), curve.column(0, 1e2), curve.column(1, 1e-3),
                            ChartCurve::Style::line, static_cast<int>(p)});
    chart.curves.push_back({p == 0 ? "on the walls" : "", curve.column(0, 1e2), curve.column(3, 1e-3),
                            ChartCurve::Style::dashed, static_cast<int>(p)});
  }
  found.charts = {{"stress-strain", std::move(chart)}};
  return found;
}

}  // namespace subsoil::sim
