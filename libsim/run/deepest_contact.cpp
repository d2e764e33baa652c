#include "libsim/run/deepest_contact.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libdem/geometry/world_box.hpp"
#include "libdem/particles/fixed.hpp"

namespace subsoil::sim {
namespace {

/// m_eff of two spheres, kg: of the bodies that they move, of which a fixed one does not yield.
double effective_mass(const dem::Sphere& a, const dem::Sphere& b, const dem::Bed& bed) {
  const double m_a = bed.mass_of_body(a), m_b = bed.mass_of_body(b);
  return dem::is_fixed(a) ? m_b : dem::is_fixed(b) ? m_a : m_a * m_b / (m_a + m_b);
}

}  // namespace

DeepestContact deepest_contact(const dem::Sphere& s, const World& world) {
  DeepestContact out;
  for (const dem::Sphere& p : world.bed->spheres()) {
    const double d = s.r + p.r - dem::norm(s.x - p.x);
    if (p.id == s.id || !(d > 0) || (dem::is_fixed(s) && dem::is_fixed(p))) continue;
    out.contacts += 1;
    if (!(d > out.overlap)) continue;
    out = {.contacts = out.contacts,
           .overlap = d,
           .approach = dem::dot(p.v - s.v, dem::normalized(s.x - p.x)),
           .smaller_radius = std::min(s.r, p.r),
           .r_eff = s.r * p.r / (s.r + p.r),
           .m_eff = effective_mass(s, p, *world.bed),
           .material = p.material,
           .other = fmt::format("sphere {}", p.id)};
  }
  for (int i = 0; i < world.bed->boundary_count(); ++i) {
    const dem::Boundary& b = world.bed->boundary(i);
    if (!b.active || (dem::is_fixed(s) && !b.meets_fixed)) continue;
    const Vec3 c = b.pose.to_local(s.x);
    std::vector<std::uint32_t> near;
    dem::candidates(b.shape, c, 2 * s.r, near);
    dem::SurfaceContact touch[1];
    if (near.empty() || dem::contacts(b.shape, c, 2 * s.r, near, touch, 1) == 0) continue;
    const double d = s.r - touch[0].distance;
    if (!(d > 0)) continue;
    out.contacts += 1;
    if (!(d > out.overlap)) continue;
    const Vec3 arm = b.pose.to_world(touch[0].point) - b.pose.position;
    const Vec3 surface = b.velocity + dem::cross(b.angular_velocity, arm);
    out = {.contacts = out.contacts,
           .overlap = d,
           .approach = dem::dot(surface - s.v, b.pose.attitude.rotate(touch[0].normal)),
           .smaller_radius = s.r,
           .r_eff = s.r,
           .m_eff = world.bed->mass_of_body(s),
           .material = b.material,
           .at_surface = true,
           .other = "`" + b.name + "`"};
  }
  return out;
}

}  // namespace subsoil::sim
