#pragma once

#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/touch_memory.hpp"

namespace subsoil::mbd {

/// Stops on the way of body b along a line of body a, as the ends of a slide or cylinder:
///   s = e . (P_b - P_a)                                                               (m)
///   F = k d^n (1 + b d'), never below 0,  d = `least` - s or s - `largest`            (N)
/// e: unit vector at angle_a [rad] from body a's x axis; the force on b is along e at P_b, its opposite on a acts in
/// the same place. k [N/m^n], b [s/m]. Law and energy: see HuntCrossleyForce.
struct SlideStop {
  template <class Self>
  using Memory = StopMemory<Self>;
  static constexpr ForceMembers has{
      .check = true, .initialise_from_pose = true, .gap = true, .touch = true, .trace = true};
  static constexpr std::array<ForceColumn, 3> columns{{{"force", "N"}, {"slide", "m"}, {"gap", "m"}}};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double angle_a = 0;
  Limits limits{};
  double impact_damping = -1;  // see StopMemory

  template <class V>
  void describe(V& v) {
    v.card("slide stop", "stops at the ends of the second body's way along a line of the first");
    v.bodies("slide stop", body_a, body_b, "the two bodies; way and force are reported of the second");
    v.joint_point(body_a, p_a, body_b, p_b, "the point from and to which the way along the line counts");
    v.axis("along", body_a, angle_a, "direction of the line in the start pose");
    limits.describe(v, "m", "N");
  }

  void check() const { limits.check(); }

  double gap(const Scene& scene) const {
    return limits.gap(dot(direction(body_of(scene, body_a)), span(body_of(scene, body_a), body_of(scene, body_b))));
  }
  double gap_speed(const Scene& scene) const {
    return speed_against(scene, body_a, body_b, std::hypot(p_b[0], p_b[1]));
  }

  double rate(const Scene& scene) const {
    return dot(direction(body_of(scene, body_a)),
               velocity_against(scene, body_a, body_b, body_of(scene, body_b).point_in_world(p_b)));
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const BodyState &a = body_of(scene, body_a), &b = body_of(scene, body_b);
    const Vec2 e = direction(a), at = b.point_in_world(p_b);
    const double s = dot(e, span(a, b));
    const Limits::Push p = limits.at(s, rate(scene), remembering(*this).damping());
    add_pair(loads, scene, body_a, body_b, at, p.force * e);
    values = {p.force, s, limits.gap(s), 0};
    return p.power;
  }

 private:
  Vec2 direction(const BodyState& a) const { return {std::cos(a.angle + angle_a), std::sin(a.angle + angle_a)}; }
  Vec2 span(const BodyState& a, const BodyState& b) const {
    return b.point_in_world(p_b) - a.r - a.vector_in_world(p_a);
  }
};

}  // namespace subsoil::mbd
