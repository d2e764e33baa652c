#include "apps/element/shatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace subsoil::app {
namespace {

/// What the pieces say: largest share, pieces of more than one grain, share of single grains.
std::vector<double> shares(const Pieces& pieces) {
  const double all = std::accumulate(pieces.mass.begin(), pieces.mass.end(), 0.0);
  double loose = 0, count = 0;
  for (std::size_t k = 0; k < pieces.mass.size(); ++k) pieces.size[k] == 1 ? loose += pieces.mass[k] : ++count;
  return {pieces.mass.front() / all, count, loose / all};
}

}  // namespace

Pieces pieces_of(std::span<const dem::Sphere> spheres, double reach) {
  const std::size_t n = spheres.size();
  std::vector<std::size_t> root(n);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  // All pairs: a clod has hundreds of grains, and is looked at twice.
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Vec3 off = spheres[i].x - spheres[k].x;
      const double far = spheres[i].r + spheres[k].r + reach;
      if (dem::dot(off, off) < far * far) root[find(i)] = find(k);
    }
  std::vector<double> mass(n, 0);
  std::vector<std::size_t> size(n, 0), order;
  for (std::size_t i = 0; i < n; ++i) mass[find(i)] += spheres[i].m, ++size[find(i)];
  for (std::size_t i = 0; i < n; ++i)
    if (size[i] > 0) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return mass[a] > mass[b]; });
  Pieces out;
  for (const std::size_t i : order) out.mass.push_back(mass[i]), out.size.push_back(size[i]);
  return out;
}

Outcome Shatter::run(const Sample& sample, std::size_t packing) const {
  const double d = sample.diameter, r = radius.value_or(4 * d), side = 2 * r + 2 * d;
  const dem::Law& law = sample.laws.laws[static_cast<std::size_t>(sample.laws.of(sample.grain, sample.grain))];
  const double reach = std::visit([](const auto& l) { return l.reach(); }, law);
  Specimen specimen(sample, speed);
  const Specimen::BoxWalls walls = specimen.box(side, side);
  specimen.fill({{}, {side, side, side}}, side, sample.seed + packing);
  const Vec3 middle{0.5 * side, 0.5 * side, 0.5 * side};
  specimen.bed().remove_if([&](const dem::Sphere& s) { return dem::norm(s.x - middle) > r; });
  for (const int wall : {walls.left, walls.right, walls.front, walls.back})
    specimen.bed().boundary(wall).active = false;
  specimen.bed().boundary(walls.floor).pose.position.y = -d;  // clear of a clod that spreads
  specimen.bed().surfaces_changed();
  specimen.bed().set_gravity({});
  specimen.bed().freeze();
  for (double t = 0; t < rest; t += specimen.dt()) specimen.step();
  specimen.bed().freeze();
  const double before = shares(pieces_of(specimen.bed().spheres(), reach))[0];
  const double end = (middle.y - r + d + 6 * r) / speed;
  Outcome out;
  out.curve.columns = {{"time", "s"}, {"force", "N"}};
  const long steps = std::max(1L, std::lround(end / 400 / specimen.dt()));
  for (double t = 0; t < end;) {
    double force = 0;
    for (long k = 0; k < steps; ++k, t += specimen.dt()) {
      specimen.step();
      force -= specimen.force(walls.floor).y;
      specimen.move(walls.floor, {0, speed, 0});
    }
    out.curve.rows.push_back({t, force / static_cast<double>(steps)});
  }
  out.values = shares(pieces_of(specimen.bed().spheres(), reach));
  out.values.push_back(before);
  return out;
}

Findings Shatter::findings(const Sample&, std::size_t packings, const std::vector<Outcome>& outcomes) const {
  Findings found;
  found.test = "shatter";
  found.numbers = numbers();
  Chart chart{.title = fmt::format("clod struck at {:g} m/s", speed),
              .x_label = "time [ms]",
              .y_label = "force on the floor [N]",
              .curves = {}};
  for (std::size_t p = 0; p < packings; ++p) {
    for (std::size_t k = 0; k < found.numbers.size(); ++k) found.numbers[k].values.push_back(outcomes[p].values[k]);
    found.curves.push_back(outcomes[p].curve);
    found.curves.back().name = fmt::format("packing-{}", p + 1);
    chart.curves.push_back({fmt::format("packing {}: largest {:.0f} %", p + 1, 100 * outcomes[p].values[0]),
                            outcomes[p].curve.column(0, 1e3), outcomes[p].curve.column(1), ChartCurve::Style::line,
                            static_cast<int>(p)});
  }
  if (found.numbers[3].mean() < 0.9)
    found.notes.push_back("the clod falls apart before it is struck: the material does not hold together");
  found.charts = {{"force", std::move(chart)}};
  return found;
}

}  // namespace subsoil::app
