#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// Box whose opposite sides are one and the same in some directions: what leaves through one side comes in through the
/// other, and spheres on both sides of it are neighbours (Allen and Tildesley, Computer Simulation of Liquids, 2nd ed.,
/// 2017, section 1.6.2).
struct PeriodicCell {
  Vec3 low;     ///< corner of minimum coordinates, m
  Vec3 length;  ///< the period in each direction, m; 0: the direction is not periodic

  bool any() const { return length.x > 0 || length.y > 0 || length.z > 0; }
  /// The same place in the cell: low <= x < low + length where it is periodic. Of one that is there already the same
  /// bits.
  Vec3 wrapped(Vec3 x) const {
    for (int d = 0; d < 3; ++d) {
      const double period = length[d], high = low[d] + period;
      if (period == 0 || (x[d] >= low[d] && x[d] < high)) continue;
      x[d] -= period * std::floor((x[d] - low[d]) / period);
      if (x[d] < low[d] || x[d] >= high) x[d] = low[d];  // rounding has put it onto a side
    }
    return x;
  }
  /// The whole periods of which a way nearly consists, m.
  Vec3 periods(const Vec3& way) const {
    Vec3 out;
    for (int d = 0; d < 3; ++d)
      if (length[d] > 0) out[d] = length[d] * std::round(way[d] / length[d]);
    return out;
  }
  /// The shortest of the ways, m, that lead to the same place as this one.
  Vec3 shortest(const Vec3& way) const { return way - periods(way); }
};

/// Images of spheres near a periodic side, beyond the opposite one: second particles of the pairs across it. Their
/// records lie behind those of the spheres (ParticleStore), so that contacts find them by an index like any other; they
/// are renewed before each step, and never moved by forces. What an image gets goes to its sphere.
///
/// Written by rebuilds (`add_pairs_across`, neighbours/periodic_search.hpp).
struct PeriodicImages {
  std::uint32_t spheres = ~std::uint32_t{0};  ///< indices from here on are images
  std::vector<std::uint32_t> of;              ///< index of the sphere of each
  std::vector<Vec3> shift;                    ///< from it to the image, m

  bool empty() const { return of.empty(); }
  std::size_t size() const { return of.size(); }
  /// Of an image its sphere; other indices stay what they are.
  std::uint32_t sphere(std::uint32_t index) const { return index < spheres ? index : of[index - spheres]; }
};

}  // namespace subsoil::dem
