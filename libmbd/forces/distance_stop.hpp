#pragma once

#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/touch_memory.hpp"

namespace subsoil::mbd {

/// Stops on the distance L between a point of body a and a point of body b; with `largest` alone a rope or chain:
///   F = k d^n (1 + b d'), never below 0,  d = `least` - L or L - `largest`            (N)
/// in line with the two points, pushing them apart (positive) below `least`, together above `largest`. k [N/m^n],
/// b [s/m]. Refuses at L = 0 within `least`, where there is no direction. Law and energy: see HuntCrossleyForce.
struct DistanceStop {
  template <class Self>
  using Memory = StopMemory<Self>;
  static constexpr ForceMembers has{
      .check = true, .initialise_from_pose = true, .gap = true, .touch = true, .trace = true};
  static constexpr std::array<ForceColumn, 3> columns{{{"force", "N"}, {"distance", "m"}, {"gap", "m"}}};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  Limits limits{};
  double impact_damping = -1;  // see StopMemory

  template <class V>
  void describe(V& v) {
    v.card("distance stop", "stops at the minimum and maximum distance of two points; with the maximum alone a rope");
    v.bodies("distance stop", body_a, body_b, "the two bodies");
    v.end_points(body_a, p_a, body_b, p_b, "its two ends");
    limits.describe(v, "m", "N");
  }

  void check() const {
    limits.check();
    if (limits.largest <= 0) throw std::invalid_argument("maximum must be above 0; for a common point use a joint");
  }

  double gap(const Scene& scene) const { return limits.gap(line(scene).length); }
  double gap_speed(const Scene& scene) const {
    return speed_against(scene, body_a, body_b, std::hypot(p_b[0], p_b[1]));
  }

  double rate(const Scene& scene) const { return line(scene).rate; }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const LineOfAction l = line(scene);
    const Limits::Push p = limits.at(l.length, l.rate, remembering(*this).damping());
    if (p.force > 0 && !(l.length > 0))
      throw std::runtime_error("distance stop has length 0, so no direction; use a stiffer stop");
    const Vec2 on_b = p.force * l.e;
    loads.add(body_b, l.arm_b, on_b);
    loads.add(body_a, l.arm_a, -1.0 * on_b);
    values = {p.force, l.length, limits.gap(l.length), 0};
    return p.power;
  }

 private:
  LineOfAction line(const Scene& scene) const { return {body_of(scene, body_a), p_a, body_of(scene, body_b), p_b}; }
};

}  // namespace subsoil::mbd
