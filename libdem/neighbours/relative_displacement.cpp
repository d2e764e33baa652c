#include "libdem/neighbours/relative_displacement.hpp"

#include <limits>

namespace subsoil::dem {

double RelativeDisplacement::include(const Bounds& of_cell, std::span<const Vec3> boundaries, Slab& found) {
  const double gone = of_cell.farthest(Vec3{});
  found.gone = std::max(found.gone, gone);
  for (std::size_t k = 0; k < boundaries.size(); ++k) {
    const Vec3& way = boundaries[k];
    const bool stays = way.x == 0 && way.y == 0 && way.z == 0;  // most do
    found.against[k] = std::max(found.against[k], stays ? gone : of_cell.farthest(way));
  }
  return gone;
}

RelativeDisplacement::Found RelativeDisplacement::of_all(std::size_t boundaries) {
  const std::span<double> against = of_slab(slabs_.size(), boundaries);
  std::fill(against.begin(), against.end(), 0.0);
  Found out{.parted = 0.5 * skin_, .gone = 0, .against = against};
  for (const Slab& slab : slabs_) {
    out.parted = std::max(out.parted, slab.parted), out.gone = std::max(out.gone, slab.gone);
    for (std::size_t k = 0; k < boundaries; ++k) against[k] = std::max(against[k], slab.against[k]);
  }
  // Of both ends of a way one is a float.
  Vec3 size{};
  for (int k = 0; k < 3; ++k) size[grid_.axis[k]] = grid_.cell * grid_.n[k];
  const double rounding = 2.0 * std::numeric_limits<float>::epsilon() * norm(size);
  out.parted += rounding, out.gone += rounding;
  for (double& x : against) x += rounding;
  return out;
}

}  // namespace subsoil::dem
