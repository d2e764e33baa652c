#include "libsim/studies/laboratory/shear.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "libdem/geometry/mesh_builders.hpp"
#include "libsim/studies/laboratory/degrees.hpp"

namespace subsoil::sim {
namespace {

constexpr int rows_of_shear = 200;
constexpr long steps_of_reading = 10;  // of all contacts, which costs some steps' time

/// The halves of the box as they stand before the path is gone.
struct Halves {
  double length, width, split, high, flange;

  dem::TriangleMesh end(double x, double from, double to) const {
    return dem::rectangle_mesh({x, from, -width}, {0, 0, 3 * width}, {0, to - from, 0});
  }
  dem::TriangleMesh shelf(double x) const {
    return dem::rectangle_mesh({x, split, -width}, {0, 0, 3 * width}, {flange, 0, 0});
  }
  std::vector<dem::TriangleMesh> lower() const {
    // Ends reach below the floor, which is a plane of its own.
    return {end(0, -0.1 * split, split), end(length, -0.1 * split, split), shelf(-flange)};
  }
  std::vector<dem::TriangleMesh> upper() const {
    return {end(0, split, high), end(length, split, high), shelf(length)};
  }
};

/// Stresses on the plane between the halves, and what moves them.
struct Rig {
  Specimen& specimen;
  Lid& lid;
  int floor, lower;
  double load, width, length, split;
  std::vector<dem::ContactRecord> contacts{};
  std::vector<char> above{};  ///< the plane, by id of the grain

  /// Force of the grains below the plane on those above it, N: tau A along x, sigma A along y.
  Vec3 across() {
    for (const dem::Sphere& s : specimen.bed().spheres()) {
      if (s.id >= above.size()) above.resize(s.id + 1);
      above[s.id] = specimen.height_of(s) > split;
    }
    Vec3 sum{};
    for (const dem::ContactRecord& c : contacts)
      if (!c.at_surface && above[c.i] != above[c.j]) sum += (above[c.i] != 0 ? 1.0 : -1.0) * c.force;
    return sum;
  }
  /// {tau, sigma} over so many steps of the lower half's speed.
  std::array<double, 2> over(long steps, double speed, double& path) {
    Vec3 sum{};
    double readings = 0;
    for (long k = 0; k < steps; ++k) {
      const bool read = k % steps_of_reading == 0;
      specimen.bed().step(specimen.dt(), {.contacts = read ? &contacts : nullptr});
      if (read) sum += across(), ++readings;
      lid.follow(load);
      for (const int part : {floor, lower}) specimen.move(part, {speed, 0, 0});
      path += speed * specimen.dt();
    }
    const double area = width * (length - path);
    return {sum.x / readings / area, sum.y / readings / area};
  }
};

/// Means of tau and sigma over rows begin..end.
std::array<double, 2> mean(const SpecimenCurve& curve, std::size_t begin, std::size_t end) {
  std::array<double, 2> sum{};
  for (std::size_t i = begin; i < end; ++i) sum[0] += curve.rows[i][1], sum[1] += curve.rows[i][2];
  const auto n = static_cast<double>(end - begin);
  return {sum[0] / n, sum[1] / n};
}

}  // namespace

Outcome Shear::run(const Sample& sample, std::size_t index) const {
  const std::size_t packing = index / loads.size();
  const double d = sample.diameter, along = length.value_or(20 * d), across = width.value_or(8 * d);
  const double deep = depth.value_or(10 * d), way = path.value_or(0.15 * along);
  const double v = speed.value_or(0.1 * sample.fall_speed());
  if (way > along - d)
    throw std::invalid_argument(fmt::format(
        "the path of {:.4g} m leaves less than a diameter of the {:.4g} m that the box is long; a shorter `path`", way,
        along));
  Specimen specimen(sample, v);
  const Halves halves{along, across, 0.5 * deep, 6 * deep + 40 * d, way + d};
  const int floor = specimen.plane("floor", {}, {0, 1, 0}, Wall::rough);
  specimen.plane("wall -z", {}, {0, 0, 1}, Wall::smooth);
  specimen.plane("wall +z", {0, 0, across}, {0, 0, -1}, Wall::smooth);
  const int lower = specimen.surface("lower half", halves.lower(), Wall::smooth);
  specimen.surface("upper half", halves.upper(), Wall::smooth);
  specimen.fill({{}, {along, deep, across}}, deep, sample.seed + packing);
  Lid lid(specimen, Wall::rough);
  const double load = loads[index % loads.size()] * along * across;
  lid.consolidate(load);
  specimen.cement();
  Rig rig{specimen, lid, floor, lower, load, across, along, halves.split};
  Outcome out;
  out.curve.columns = {{"path", "m"}, {"shear stress", "Pa"}, {"normal stress", "Pa"}, {"rise of the lid", "m"}};
  const double start = lid.height();
  double gone = 0;
  for (const long steps : specimen.steps_of_rows(way, v, rows_of_shear)) {
    const double before = gone;
    const auto [tau, sigma] = rig.over(steps, v, gone);
    out.curve.rows.push_back({0.5 * (before + gone), tau, sigma, lid.height() - start});
  }
  std::array<double, 2> peak{0, 1};
  constexpr std::size_t window = rows_of_shear / 20;
  for (std::size_t i = 0; i + window <= rows_of_shear; ++i) {
    const auto now = mean(out.curve, i, i + window);
    if (now[0] * peak[1] > peak[0] * now[1]) peak = now;
  }
  const auto final = mean(out.curve, rows_of_shear * 4 / 5, rows_of_shear);
  if (!(peak[0] > 0) || !(final[1] > 0))
    throw std::runtime_error(
        "the grains bear nothing across the plane: no strength; a shorter `path`, or a higher load");
  out.values = {peak[0], peak[1], final[0], final[1]};
  return out;
}

namespace {

/// By how much the ratio of shear to normal stress rises from the last fifth but one of the path to the last.
double rise_at_end(const SpecimenCurve& curve) {
  const auto ratio = [&](std::size_t from, std::size_t to) {
    const std::array<double, 2> m = mean(curve, from, to);
    return m[0] / m[1];
  };
  const double before = ratio(rows_of_shear * 3 / 5, rows_of_shear * 4 / 5);
  return before > 0 ? ratio(rows_of_shear * 4 / 5, rows_of_shear) / before - 1
                    : std::numeric_limits<double>::infinity();
}

}  // namespace

Findings Shear::findings(const Sample&, std::size_t packings, const std::vector<Outcome>& outcomes) const {
  Findings found;
  found.test = "shear";
  found.numbers = numbers();
  Chart course{.title = "direct shear", .x_label = "path [mm]", .y_label = "shear stress [kPa]", .curves = {}};
  Chart plane{.title = "strength at peak and at the end",
              .x_label = "normal stress [kPa]",
              .y_label = "shear stress [kPa]",
              .curves = {}};
  course.from_zero = plane.from_zero = true;
  for (std::size_t p = 0; p < packings; ++p) {
    std::array<std::vector<double>, 4> points;
    for (std::size_t k = 0; k < loads.size(); ++k) {
      const Outcome& one = outcomes[p * loads.size() + k];
      for (std::size_t i = 0; i < 4; ++i) points[i].push_back(one.values[i]);
      found.curves.push_back(one.curve);
      found.curves.back().name = fmt::format("packing-{}-load-{:g}kPa", p + 1, loads[k] * 1e-3);
      course.curves.push_back({p == 0 ? fmt::format("{:g} kPa", loads[k] * 1e-3) : "", one.curve.column(0, 1e3),
                               one.curve.column(1, 1e-3), ChartCurve::Style::line, static_cast<int>(k)});
    }
    double ratio = 0;
    for (std::size_t k = 0; k < loads.size(); ++k) ratio += points[2][k] / points[3][k];
    found.numbers[4].values.push_back(ratio / static_cast<double>(loads.size()));
    for (const std::size_t at : {0u, 2u}) {
      const Line line = fit_line(points[at + 1], points[at]);
      found.numbers[at].values.push_back(std::atan(line.b));
      found.numbers[at + 1].values.push_back(line.a);
    }
    for (const std::size_t at : {0u, 2u}) {
      ChartCurve dots{p == 0 ? (at == 0 ? "peak" : "final") : "", points[at + 1], points[at], ChartCurve::Style::dots,
                      at == 0 ? 0 : 1};
      for (double& x : dots.x) x *= 1e-3;
      for (double& y : dots.y) y *= 1e-3;
      plane.curves.push_back(std::move(dots));
    }
  }
  const double far = 1.15e-3 * *std::max_element(loads.begin(), loads.end());
  for (const std::size_t at : {0u, 2u}) {
    const double angle = found.numbers[at].mean(), c = found.numbers[at + 1].mean() * 1e-3;
    plane.curves.push_back({fmt::format("{:.1f} deg, {:.2f} kPa", angle * degrees, c),
                            {0, far},
                            {c, c + std::tan(angle) * far},
                            ChartCurve::Style::line,
                            at == 0 ? 0 : 1});
  }
  double rise = 0;
  for (const Outcome& one : outcomes) rise += rise_at_end(one.curve) / static_cast<double>(outcomes.size());
  constexpr double still_rises = 0.1;  // one packing scatters by some percent, a plateau stays within them
  if (rise > still_rises)
    found.diagnostics.push_back(
        "the shear stress still rises at the end of the path: the strength is not reached, and both angles are too "
        "low; "
        "give a longer `path`");
  found.charts = {{"path", std::move(course)}, {"mohr-coulomb", std::move(plane)}};
  return found;
}

}  // namespace subsoil::sim
