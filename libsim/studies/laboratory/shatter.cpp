#include "libsim/studies/laboratory/shatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace subsoil::sim {
namespace {

/// What the pieces say: largest share, pieces of more than one grain, share of single grains.
std::vector<double> shares(const Pieces& pieces) {
  const double all = std::accumulate(pieces.mass.begin(), pieces.mass.end(), 0.0);
  double loose = 0, count = 0;
  for (std::size_t k = 0; k < pieces.mass.size(); ++k) pieces.size[k] == 1 ? loose += pieces.mass[k] : ++count;
  return {pieces.mass.front() / all, count, loose / all};
}

/// Sets of spheres, by their places in a list.
class Sets {
 public:
  explicit Sets(std::size_t n) : root_(n) { std::iota(root_.begin(), root_.end(), std::size_t{0}); }
  void join(std::size_t i, std::size_t k) { root_[find(i)] = find(k); }

  Pieces pieces(std::span<const dem::Sphere> spheres) {
    const std::size_t n = spheres.size();
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

 private:
  std::size_t find(std::size_t i) {
    while (root_[i] != i) i = root_[i] = root_[root_[i]];
    return i;
  }
  std::vector<std::size_t> root_;
};

Pieces pieces_in(const dem::Bed& bed, const dem::Law& law) {
  if (law->bond() != nullptr) return pieces_of(bed.spheres(), bed.bonded_pairs());
  double largest = 0;
  for (const dem::Sphere& s : bed.spheres()) largest = std::max(largest, s.r);
  return pieces_of(bed.spheres(), law->cutoff(0.5 * largest));
}

}  // namespace

Pieces pieces_of(std::span<const dem::Sphere> spheres, double reach) {
  Sets sets(spheres.size());
  // All pairs: a clod has hundreds of grains, and is looked at twice.
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Vec3 off = spheres[i].x - spheres[k].x;
      const double far = spheres[i].r + spheres[k].r + reach;
      if (dem::dot(off, off) < far * far) sets.join(i, k);
    }
  return sets.pieces(spheres);
}

Pieces pieces_of(std::span<const dem::Sphere> spheres, std::span<const std::array<std::uint32_t, 2>> joined) {
  std::map<std::uint32_t, std::size_t> place;
  for (std::size_t i = 0; i < spheres.size(); ++i) place[spheres[i].id] = i;
  Sets sets(spheres.size());
  for (const auto& [a, b] : joined) sets.join(place.at(a), place.at(b));
  return sets.pieces(spheres);
}

Outcome Shatter::run(const Sample& sample, std::size_t packing) const {
  if (!sample.clumps.empty())
    throw std::invalid_argument(
        "counts pieces of spheres, and the grains are clumps; give the `test.radius` of spheres");
  const double d = sample.diameter, r = radius.value_or(4 * d), side = 2 * r + 2 * d;
  const dem::Law& law = sample.laws.laws[static_cast<std::size_t>(sample.laws.of(sample.grain, sample.grain))];
  Specimen specimen(sample, speed);
  const Specimen::BoxWalls walls = specimen.box(side, side);
  specimen.fill({{}, {side, side, side}}, side, sample.seed + packing);
  specimen.cement();
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
  const double before = shares(pieces_in(specimen.bed(), law))[0];
  const dem::BondCount whole = specimen.bed().bonds();
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
  out.values = shares(pieces_in(specimen.bed(), law));
  out.values.push_back(before);
  const auto broken = static_cast<double>(specimen.bed().bonds().broken() - whole.broken());
  out.values.push_back(whole.intact() > 0 ? broken / static_cast<double>(whole.intact()) : 0);
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
    found.diagnostics.push_back("the clod falls apart before it is struck: the material does not hold together");
  found.charts = {{"force", std::move(chart)}};
  return found;
}

}  // namespace subsoil::sim
