#pragma once

#include "libmbd/element/touch_memory.hpp"

namespace subsoil::mbd {

/// Contact of a point or disk of body b with a straight side of body a (a half plane; the ground, a wall, a ramp):
///   gap = n . (C - Q) - R,  n = k x e                                                 (m)
/// Q: a point of the line and e its direction at angle_a [rad] from body a's x axis; the free side is on the left of e.
/// C: centre of the disk on b, R >= 0 its radius [m], 0 for a point. Forces act at C - R n, the disk's lowest point:
/// the moment arm of friction is R exactly, at any depth. The line has no ends. Law and energy: see ContactLaw.
struct LineContact {
  template <class Self>
  using Memory = ContactMemory<Self>;
  static constexpr ForceMembers has = contact_members(false);
  static constexpr auto columns = ContactLaw::columns;
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double angle_a = 0;
  double radius = 0;
  ContactLaw law{};
  std::vector<Touch> touches{};  // see ContactMemory
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("line contact", "a point or disk of the second body meets a straight side of the first, which only pushes");
    v.bodies("line contact", body_a, body_b, "the body with the side, and the body with the point or disk");
    v.end_points(body_a, p_a, body_b, p_b, "a point of the side, and the point or the disk's centre");
    v.axis("along", body_a, angle_a, "direction of the side in the start pose, its free side on the left");
    v.quantity("radius", radius, "m", "[0, inf)", "radius of the disk; 0: a point");
    law.describe(v);
  }

  void check() const {
    law.check();
    if (!(radius >= 0)) throw std::invalid_argument("radius must not be negative; 0 is a point");
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
    const BodyState &a = body_of(scene, body_a), &b = body_of(scene, body_b);
    const Vec2 normal{-std::sin(a.angle + angle_a), std::cos(a.angle + angle_a)}, centre = b.point_in_world(p_b);
    return {dot(normal, centre - a.r - a.vector_in_world(p_a)) - radius, normal, centre - radius * normal};
  }
};

}  // namespace subsoil::mbd
