#pragma once

#include <stdexcept>

#include "libmbd/force.hpp"

namespace subsoil::mbd {

/// Translational spring-damper between a point of body a and a point of body b, distance L:
///   F = preload + k (L_0 - L) - c L'        compression positive: it pushes the points apart   (N)
/// k stiffness [N/m] >= 0, L_0 free length [m], c damping [N s/m] >= 0, preload [N]. Without a free length L_0 is the
/// length in the start pose, and the preload then is the force there. Valid for L > 0: at L = 0 the line of action is
/// not defined and the force refuses.
/// Energy: stored = k (L_0 - L)^2 / 2 - preload (L - L_0), lost rate = c L'^2.
struct SpringDamper {
  static constexpr std::array<ForceColumn, 3> columns{{{"force", "N"}, {"length", "m"}, {"damper force", "N"}}};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double stiffness = std::numeric_limits<double>::quiet_NaN();
  double free_length = std::numeric_limits<double>::quiet_NaN();
  double preload = 0;
  double damping = 0;

  template <class V>
  void describe(V& v) {
    v.card("spring-damper", "a spring and a damper in line between a point of each body; compression is positive");
    v.bodies("spring-damper", body_a, body_b, "the two bodies that it joins");
    v.end_points(body_a, p_a, body_b, p_b, "its two ends");
    v.quantity("stiffness", stiffness, "N/m", "[0, inf)", "force per shortening");
    v.optional_quantity("free length", free_length, "m", "[0, inf)",
                        "length without spring force; left out: the length in the start pose");
    v.quantity("preload", preload, "N", "(-inf, inf)", "constant force on top, compression positive");
    v.quantity("damping", damping, "N s/m", "[0, inf)", "force per rate of shortening");
  }

  void check() const {
    if (!(stiffness >= 0 && damping >= 0))
      throw std::invalid_argument(
          "stiffness and damping must be given and not negative; stiffness 0 is a damper alone");
  }

  void settle_start(const Scene& scene) {
    if (std::isnan(free_length)) free_length = line(scene).length;
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const Line l = line(scene);
    if (!(l.length > 0)) throw std::runtime_error("spring-damper has length 0, so no direction; move its ends apart");
    const double elastic = preload + stiffness * (free_length - l.length), viscous = -damping * l.rate;
    const Vec2 on_b = (elastic + viscous) * l.e;
    loads.add(body_b, l.arm_b, on_b);
    loads.add(body_a, l.arm_a, -1.0 * on_b);
    values = {elastic + viscous, l.length, viscous, 0};
    const double longer = l.length - free_length;
    return {0.5 * stiffness * longer * longer - preload * longer, damping * l.rate * l.rate, 0};
  }

 private:
  struct Line {
    Vec2 arm_a, arm_b, e;
    double length, rate;
  };
  Line line(const Scene& scene) const {
    const BodyState &a = scene.bodies[static_cast<std::size_t>(body_a)],
                    &b = scene.bodies[static_cast<std::size_t>(body_b)];
    const Vec2 arm_a = a.world(p_a), arm_b = b.world(p_b), d = b.r + arm_b - a.r - arm_a;
    const double l = mbd::length(d);
    const Vec2 e = l > 0 ? (1 / l) * d : Vec2{};
    return {arm_a, arm_b, e, l, dot(e, b.velocity_at(arm_b) - a.velocity_at(arm_a))};
  }
};

}  // namespace subsoil::mbd
