#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// Axis-aligned box from `low` to `high`; the default one is empty.
struct Bounds {
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};

  void include(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void include(const Bounds& b) { include(b.low), include(b.high); }
  bool empty() const { return low.x > high.x; }
  double diagonal() const { return empty() ? 0 : norm(high - low); }
  Vec3 centre() const { return 0.5 * (low + high); }
  /// From p to the farthest corner.
  double farthest(const Vec3& p) const { return farthest({p, p}); }
  /// Longest way from a point of this box to one of another.
  double farthest(const Bounds& b) const { return std::sqrt(farthest_squared(b)); }
  double farthest_squared(const Bounds& b) const {
    Vec3 far;
    for (int d = 0; d < 3; ++d) far[d] = std::max(std::abs(high[d] - b.low[d]), std::abs(b.high[d] - low[d]));
    return dot(far, far);
  }
  /// Square of the distance from p to the box, 0 inside.
  double distance_squared(const Vec3& p) const {
    const Vec3 out{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                   std::max({low.z - p.z, 0.0, p.z - high.z})};
    return dot(out, out);
  }
};

}  // namespace subsoil::dem
