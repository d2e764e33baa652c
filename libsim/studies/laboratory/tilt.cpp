#include "libsim/studies/laboratory/tilt.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "libsim/studies/laboratory/degrees.hpp"

namespace subsoil::sim {
namespace {

constexpr long steps_of_row = 50;

double middle_x(const Specimen& specimen) {
  double sum = 0, mass = 0;
  for (const dem::Sphere& s : specimen.bed().spheres()) sum += s.m * s.x.x, mass += s.m;
  return sum / mass;
}

}  // namespace

Outcome Tilt::tilt(Specimen& specimen) const {
  const double g = specimen.sample().gravity, far = slip.value_or(0.05 * specimen.sample().diameter);
  const double start = middle_x(specimen);
  Outcome out;
  out.curve.columns = {{"angle", "rad"}, {"path", "m"}};
  for (double angle = 0; angle < until;) {
    for (long k = 0; k < steps_of_row; ++k) {
      angle += (angle < from ? 10 * rate : rate) * specimen.dt();
      specimen.bed().set_gravity({g * std::sin(angle), -g * std::cos(angle), 0});
      specimen.step();
    }
    const double path = middle_x(specimen) - start;
    out.curve.rows.push_back({angle, path});
    if (path < far) continue;
    if (angle < from)
      throw std::runtime_error(fmt::format(
          "slides at {:.3g} deg already, while it is tilted quickly; lower `test.tilt.from`", angle * degrees));
    out.values = {angle};
    return out;
  }
  throw std::runtime_error(
      fmt::format("nothing slides up to {:.3g} deg; tilt farther with `test.tilt.until`, or less "
                  "`slip` counts",
                  until * degrees));
}

Outcome Tilt::run(const Sample& sample, std::size_t packing) const {
  const double d = sample.diameter, along = length.value_or(16 * d), across = width.value_or(6 * d);
  const double deep = depth.value_or(4 * d);
  Specimen specimen(sample);
  specimen.box(along, across);
  specimen.fill({{}, {along, deep, across}}, deep, sample.seed + packing);
  specimen.cement();
  return tilt(specimen);
}

Findings Tilt::findings(const Sample&, std::size_t packings, const std::vector<Outcome>& outcomes) const {
  Findings found;
  found.test = "tilt";
  found.numbers = numbers();
  Chart chart{.title = "tilted box", .x_label = "angle [deg]", .y_label = "mean path [mm]", .curves = {}};
  for (std::size_t p = 0; p < packings; ++p) {
    found.numbers[0].values.push_back(outcomes[p].values[0]);
    found.curves.push_back(outcomes[p].curve);
    found.curves.back().name = fmt::format("packing-{}", p + 1);
    chart.curves.push_back({fmt::format("packing {}: {:.1f} deg", p + 1, outcomes[p].values[0] * degrees),
                            outcomes[p].curve.column(0, degrees), outcomes[p].curve.column(1, 1e3),
                            ChartCurve::Style::line, static_cast<int>(p)});
  }
  found.charts = {{"path", std::move(chart)}};
  return found;
}

}  // namespace subsoil::sim
