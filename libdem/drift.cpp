#include "libdem/drift.hpp"

#include <limits>

namespace subsoil::dem {
/// Of a cell and those up to two away from it. Spheres of cells that are farther apart were more than two cells from
/// each other: they touch only when they have come nearer by a sphere's diameter and the skin twice over, which none
/// does that is within the skin of its place.
double Drift::parted_around(const std::vector<Bounds>& ways, int a, int b, int c) const {
  const Bounds& own = ways[grid_.index(a, b, c)];
  const auto from = [](int k) { return std::max(k - 2, 0); };
  const auto to = [&](int k, int axis) { return std::min(k + 2, grid_.n[axis] - 1); };
  double parted = 0;
  for (int i = from(a); i <= to(a, 0); ++i)
    for (int j = from(b); j <= to(b, 1); ++j)
      for (int k = from(c); k <= to(c, 2); ++k)
        if (const Bounds& other = ways[grid_.index(i, j, k)]; !other.empty())
          parted = std::max(parted, own.farthest(other));
  return parted;
}

Drift::Found Drift::compare(const std::vector<Bounds>& ways, const std::vector<Vec3>& boundaries, int threads) const {
  // Of two spheres that parted by more than half the skin one went more than a quarter of it: few cells have such.
  const double far = 0.25 * skin_;
  std::vector<Found> slabs(static_cast<std::size_t>(grid_.n[0]));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int a = 0; a < grid_.n[0]; ++a) {
    Found& slab = slabs[static_cast<std::size_t>(a)];
    slab.parted = 2 * far;
    slab.against.assign(boundaries.size(), 0);
    for (int b = 0; b < grid_.n[1]; ++b)
      for (int c = 0; c < grid_.n[2]; ++c) {
        const Bounds& of_cell = ways[grid_.index(a, b, c)];
        if (of_cell.empty()) continue;
        const double gone = of_cell.farthest(Vec3{});
        slab.gone = std::max(slab.gone, gone);
        for (std::size_t k = 0; k < boundaries.size(); ++k)
          slab.against[k] = std::max(slab.against[k], of_cell.farthest(boundaries[k]));
        if (gone > far) slab.parted = std::max(slab.parted, parted_around(ways, a, b, c));
      }
  }
  Found out{.parted = 2 * far, .gone = 0, .against = std::vector<double>(boundaries.size(), 0)};
  for (const Found& slab : slabs) {
    out.parted = std::max(out.parted, slab.parted), out.gone = std::max(out.gone, slab.gone);
    for (std::size_t k = 0; k < boundaries.size(); ++k) out.against[k] = std::max(out.against[k], slab.against[k]);
  }
  // Of both ends of a way one is a float.
  Vec3 size{};
  for (int k = 0; k < 3; ++k) size[grid_.axis[k]] = grid_.cell * grid_.n[k];
  const double rounding = 2.0 * std::numeric_limits<float>::epsilon() * norm(size);
  out.parted += rounding, out.gone += rounding;
  for (double& x : out.against) x += rounding;
  return out;
}

}  // namespace subsoil::dem
