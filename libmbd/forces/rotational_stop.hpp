#pragma once

#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/touch_memory.hpp"

namespace subsoil::mbd {

/// Stops on the angle between two bodies, theta = angle_b - angle_a [rad], counted over full turns:
///   T = k d^n (1 + b d'), never below 0,  d = `least` - theta or theta - `largest`    (N m)
/// on b, back towards the free range, its opposite on a. k [N m/rad^n], b [s/rad]. Law and energy: see
/// HuntCrossleyForce.
struct RotationalStop {
  template <class Self>
  using Memory = StopMemory<Self>;
  static constexpr ForceMembers has{
      .check = true, .initialise_from_pose = true, .gap = true, .touch = true, .trace = true};
  static constexpr std::array<ForceColumn, 3> columns{{{"torque", "N m"}, {"angle", "rad"}, {"gap", "rad"}}};
  int body_a = -1, body_b = -1;
  Limits limits{};
  double impact_damping = -1;  // see StopMemory

  template <class V>
  void describe(V& v) {
    v.card("rotational stop", "stops at the ends of the angle of the second body against the first");
    v.bodies("rotational stop", body_a, body_b, "the two bodies; angle and torque are reported of the second");
    limits.describe(v, "rad", "N m");
  }

  void check() const { limits.check(); }

  double gap(const Scene& scene) const { return limits.gap(angle(scene)); }
  double gap_speed(const Scene& scene) const {
    return std::abs(body_of(scene, body_b).omega - body_of(scene, body_a).omega);
  }

  double rate(const Scene& scene) const { return body_of(scene, body_b).omega - body_of(scene, body_a).omega; }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const double theta = angle(scene);
    const Limits::Push p = limits.at(theta, rate(scene), remembering(*this).damping());
    loads.add_wrench(body_b, 0, 0, p.force);
    loads.add_wrench(body_a, 0, 0, -p.force);
    values = {p.force, theta, limits.gap(theta), 0};
    return p.power;
  }

 private:
  double angle(const Scene& scene) const { return body_of(scene, body_b).angle - body_of(scene, body_a).angle; }
};

}  // namespace subsoil::mbd
