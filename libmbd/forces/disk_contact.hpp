#pragma once

#include "libmbd/element/touch_memory.hpp"

namespace subsoil::mbd {

/// Where the second disk is against the first.
enum class DiskSide { outside, inside };

/// Contact of a disk of body b with a disk of body a, or with the bore of a ring on a; L distance of the centres:
///   outside: gap = L - (R_a + R_b)        inside: gap = (R_a - R_b) - L               (m)
/// R_a > 0, R_b >= 0 radii [m], 0 for a point; inside R_b < R_a. Forces act in the middle between both circles, on the
/// line of centres.
/// Outside the direction is lost at L = 0, where one disk has passed into the other's centre: the force refuses.
/// Law and energy: see ContactLaw.
struct DiskContact {
  template <class Self>
  using Memory = ContactMemory<Self>;
  static constexpr ForceMembers has = contact_members(false);
  static constexpr auto columns = ContactLaw::columns;
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double radius_a = std::numeric_limits<double>::quiet_NaN();
  double radius_b = std::numeric_limits<double>::quiet_NaN();
  DiskSide side = DiskSide::outside;
  ContactLaw law{};
  std::vector<Touch> touches{};  // see ContactMemory
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("disk contact", "a disk meets another disk or the bore of a ring, which only push");
    v.bodies("disk contact", body_a, body_b, "the bodies of the first and the second disk");
    v.end_points(body_a, p_a, body_b, p_b, "centres of the two disks");
    v.quantity("first radius", radius_a, "m", "(0, inf)", "radius of the first body's disk or bore");
    v.quantity("second radius", radius_b, "m", "[0, inf)", "radius of the second body's disk; 0: a point");
    v.choice("side", side, {{"outside", DiskSide::outside}, {"inside", DiskSide::inside}},
             "whether the second disk is beside the first or runs inside it, in a bore");
    law.describe(v);
  }

  void check() const {
    law.check();
    if (!(radius_a > 0 && radius_b >= 0))
      throw std::invalid_argument("both radii must be given, the first above 0 and the second not negative");
    if (side == DiskSide::inside && !(radius_b < radius_a))
      throw std::invalid_argument("the second radius must be less than the first for a disk inside a bore");
  }

  double gap(const Scene& scene) const { return point(scene).gap; }
  std::size_t gap_count() const { return 1; }
  ContactPlace place(const Scene& scene, std::size_t) const { return {body_a, body_b, point(scene)}; }
  double gap_speed(const Scene& scene) const {
    return speed_against(scene, body_a, body_b, std::hypot(p_b[0], p_b[1]));
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    return remembering(*this).push(scene, 0, place(scene, 0), loads, values);
  }

 private:
  ContactPoint point(const Scene& scene) const {
    const BodyState& b = body_of(scene, body_b);
    const LineOfAction l(body_of(scene, body_a), p_a, b, p_b);
    const bool inside = side == DiskSide::inside;
    if (!inside && !(l.length > 0))
      throw std::runtime_error("disk contact has coinciding centres, so no direction; use a stiffer contact");
    const Vec2 normal = inside ? -1.0 * l.e : l.e;
    const double gap = inside ? radius_a - radius_b - l.length : l.length - radius_a - radius_b;
    return {gap, normal, b.r + l.arm_b - (radius_b + 0.5 * gap) * normal};
  }
};

}  // namespace subsoil::mbd
