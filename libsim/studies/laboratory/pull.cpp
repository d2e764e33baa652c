#include "libsim/studies/laboratory/pull.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::sim {
namespace {

constexpr int rows_of_pull = 250;
constexpr std::size_t window = rows_of_pull / 50;
constexpr double flare = 0.25;  // of the neck, on each side

/// Two walls that stand across x, symmetric about the neck's middle, from (x1, y1) to (x2, y2) and its mirror image.
struct Mould {
  double neck, width;

  dem::TriangleMesh wall(double x1, double y1, double x2, double y2) const {
    return dem::rectangle_mesh({x1, y1, -width}, {0, 0, 3 * width}, {x2 - x1, y2 - y1, 0});
  }
  void add_pair(std::vector<dem::TriangleMesh>& walls, double out1, double y1, double out2, double y2) const {
    walls.push_back(wall(-out1, y1, -out2, y2));
    walls.push_back(wall(neck + out1, y1, neck + out2, y2));
  }
};

}  // namespace

Outcome Pull::run(const Sample& sample, std::size_t packing) const {
  const double d = sample.diameter, along = neck.value_or(8 * d), across = width.value_or(6 * d);
  const double deep = depth.value_or(10 * d), way = path.value_or(2 * d), v = speed.value_or(sample.fall_speed() / 20);
  const double split = 0.5 * deep, wide = flare * along;
  const Mould mould{along, across};
  Specimen specimen(sample, v);
  specimen.plane("floor", {}, {0, 1, 0}, Wall::rough);
  specimen.plane("wall -z", {}, {0, 0, 1}, Wall::smooth);
  specimen.plane("wall +z", {0, 0, across}, {0, 0, -1}, Wall::smooth);
  std::vector<dem::TriangleMesh> lower, upper;
  mould.add_pair(lower, wide, -d, wide, 0);
  mould.add_pair(lower, wide, 0, 0, split);
  mould.add_pair(upper, 0, split, wide, deep);
  mould.add_pair(upper, wide, deep, wide, 6 * deep + 40 * d);
  specimen.surface("lower half", lower, Wall::rough);
  const int top = specimen.surface("upper half", upper, Wall::rough);
  specimen.fill({{}, {along, deep, across}}, deep, sample.seed + packing);
  {
    Lid lid(specimen, Wall::smooth);
    lid.consolidate(load * (along + 2 * wide) * across);
    specimen.bed().boundary(lid.boundary()).active = false;
    specimen.bed().surfaces_changed();
    specimen.rest();
  }
  specimen.cement();
  double weight = 0;
  for (const dem::Sphere& s : specimen.bed().spheres())
    if (specimen.height_of(s) > split) weight += s.m * sample.gravity;
  Outcome out;
  out.curve.columns = {{"path", "m"}, {"tension", "Pa"}};
  double work = 0, gone = 0;
  for (const long steps : specimen.steps_of_rows(way, v, rows_of_pull)) {
    double force = 0;
    for (long k = 0; k < steps; ++k) {
      specimen.step();
      force += specimen.force(top).y;
      specimen.move(top, {0, v, 0});
    }
    const double tension = -(weight + force / static_cast<double>(steps)) / (along * across);
    const double piece = v * specimen.dt() * static_cast<double>(steps);
    work += std::max(0.0, tension) * piece;
    out.curve.rows.push_back({gone + 0.5 * piece, tension});
    gone += piece;
  }
  // Grains that bear no tension stay behind; what is left of the equation is their weight on the grains below.
  double strength = 0, at = 0;
  for (std::size_t i = 0; i + window <= out.curve.rows.size(); ++i) {
    double mean = 0;
    for (std::size_t k = i; k < i + window; ++k) mean += out.curve.rows[k][1] / static_cast<double>(window);
    if (mean > strength) strength = mean, at = out.curve.rows[i + window / 2][0];
  }
  out.values = {strength, at, work};
  return out;
}

Findings Pull::findings(const Sample&, std::size_t packings, const std::vector<Outcome>& outcomes) const {
  Findings found;
  found.test = "pull";
  found.numbers = numbers();
  Chart chart{.title = "direct tension", .x_label = "path [mm]", .y_label = "tension [kPa]", .curves = {}};
  for (std::size_t p = 0; p < packings; ++p) {
    for (std::size_t k = 0; k < found.numbers.size(); ++k) found.numbers[k].values.push_back(outcomes[p].values[k]);
    found.curves.push_back(outcomes[p].curve);
    found.curves.back().name = fmt::format("packing-{}", p + 1);
    chart.curves.push_back({fmt::format("packing {}", p + 1), outcomes[p].curve.column(0, 1e3),
                            outcomes[p].curve.column(1, 1e-3), ChartCurve::Style::line, static_cast<int>(p)});
  }
  found.charts = {{"path", std::move(chart)}};
  const auto& strengths = found.numbers[0].values;
  if (const auto none = std::count(strengths.begin(), strengths.end(), 0.0); none > 0)
    found.diagnostics.push_back(fmt::format("{} of {} packings bear no tension at all", none, packings));
  return found;
}

}  // namespace subsoil::sim
