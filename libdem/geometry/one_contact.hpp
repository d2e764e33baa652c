#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "libdem/geometry/bounds.hpp"
#include "libdem/geometry/surface_contact.hpp"
#include "libdem/geometry/triangle_mesh.hpp"

/// What shapes of a formula share.
namespace subsoil::dem {

/// A shape that a sphere touches in one point at most: it has contacts(c, cutoff, out, max), and is its own only
/// candidate, 0.
template <class S>
class OneContact {
 public:
  size_t contacts(const Vec3& c, double cutoff, std::span<const uint32_t> candidates, SurfaceContact* out,
                  size_t max) const {
    return candidates.empty() ? 0 : self().contacts(c, cutoff, out, max);
  }
  void candidates(const Vec3& c, double cutoff, std::vector<uint32_t>& out) const {
    SurfaceContact any;
    if (self().contacts(c, cutoff, &any, 1) > 0) out.push_back(0);
  }
  std::optional<FlatFace> flat_face(const Vec3&, double, std::span<const uint32_t>) const { return {}; }

 private:
  const S& self() const { return static_cast<const S&>(*this); }
};

inline Vec3 unit_vector(const Vec3& v, const char* what) {
  const double length = norm(v);
  if (!(length > 0) || !std::isfinite(length))
    throw std::invalid_argument(std::string(what) + " has no direction; give a vector of any length above 0");
  return (1 / length) * v;
}

/// Any unit vector square to the unit vector a.
inline Vec3 square_to(const Vec3& a) {
  return normalized(cross(a, std::abs(a.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
}

}  // namespace subsoil::dem
