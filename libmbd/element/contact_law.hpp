#pragma once

#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/hunt_crossley.hpp"

namespace subsoil::mbd {

/// Where two bodies touch or would touch: gap < 0 is the depth, `normal` points from body a into its free side.
struct ContactPoint {
  double gap = 0;
  Vec2 normal, at;
};

/// A unilateral contact of body b on body a with Coulomb friction:
///   F_n = Hunt-Crossley of the depth -gap            along the normal on b, its opposite on a                   (N)
///   F_t = -mu F_n tanh(s / s_0)                      along the tangent (the normal turned clockwise) on b       (N)
/// s slip [m/s]: tangential velocity of b's material point against a's at the contact point; s_0 slip speed [m/s] that
/// rounds the corner of Coulomb's law. Friction is within 4e-9 of mu F_n above 10 s_0; nothing sticks: under a steady
/// tangential load T < mu F_n it creeps at s_0 atanh(T / (mu F_n)). A slip that friction alone slows under constant F_n
/// lies above that of Coulomb's law by 0 to s_0 asinh(1/2). Both forces act at one world point on both bodies.
/// Energy: stored and lost of Hunt-Crossley, and lost rate -F_t s of friction.
struct ContactLaw {
  static constexpr std::array<ForceColumn, 4> columns{
      {{"normal force", "N"}, {"friction", "N"}, {"gap", "m"}, {"slip", "m/s"}}};
  HuntCrossleyForce normal{};
  double friction = 0;
  double slip_speed = 1e-3;

  template <class V>
  void describe(V& v) {
    normal.describe(v, "m", "N");
    v.quantity("friction", friction, "1", "[0, inf)", "coefficient of friction mu");
    v.quantity("slip speed", slip_speed, "m/s", "(0, inf)",
               "speed over which friction builds up, mu F tanh(slip / slip speed); nothing sticks, it creeps below it");
  }
  void check() const {
    normal.check();
    if (!(friction >= 0 && slip_speed > 0))
      throw std::invalid_argument("friction must not be negative and the slip speed above 0; friction 0 is smooth");
  }

  ForcePower push(const Scene& scene, int body_a, int body_b, const ContactPoint& c, Loads& loads,
                  ForceValues& values) const {
    values = {0, 0, c.gap, 0};
    if (!(c.gap < 0)) return {};
    const Vec2 tangent{c.normal.y, -c.normal.x}, rate = velocity_against(scene, body_a, body_b, c.at);
    const HuntCrossleyForce::Push p = normal.at(-c.gap, -dot(c.normal, rate));
    const double slip = dot(tangent, rate);
    const double drag = friction > 0 ? -friction * p.force * std::tanh(slip / slip_speed) : 0.0;
    add_pair(loads, scene, body_a, body_b, c.at, p.force * c.normal + drag * tangent);
    values = {p.force, drag, c.gap, slip};
    return {p.stored, p.lost - drag * slip, 0};
  }
};

}  // namespace subsoil::mbd
