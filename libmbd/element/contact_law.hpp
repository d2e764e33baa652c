#pragma once

#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/hunt_crossley.hpp"
#include "libmbd/element/stick_slip.hpp"

namespace subsoil::mbd {

/// Where two bodies touch or would touch: gap < 0 is the depth, `normal` points from body a into its free side.
struct ContactPoint {
  double gap = 0;
  Vec2 normal, at;
};

/// A place of contact of body b on body a.
struct ContactPlace {
  int body_a = -1, body_b = -1;
  ContactPoint point;
};

/// What a contact has begun with, since it closed.
struct Touch {
  bool closed = false;
  double damping = -1;  ///< b of the normal force; negative: none has begun
  StickSlip surfaces{};
};

/// A unilateral contact of body b on body a with Coulomb friction:
///   F_n = Hunt-Crossley of the depth -gap            along the normal on b, its opposite on a                   (N)
///   F_t = -mu F_n tanh(s / s_0)                      along the tangent (the normal turned clockwise) on b       (N)
/// s slip [m/s]: tangential velocity of b's material point against a's at the contact point; s_0 slip speed [m/s] that
/// rounds the corner of Coulomb's law. Friction is within 4e-9 of mu F_n above 10 s_0; nothing sticks: under a steady
/// tangential load T < mu F_n it creeps at s_0 atanh(T / (mu F_n)). A slip that friction alone slows under constant F_n
/// lies above that of Coulomb's law by 0 to s_0 asinh(1/2). With a stick stiffness the surfaces slide or stick
/// (StickSlip) with the limit mu F_n. Both forces act at one world point on both bodies.
/// Energy: stored and lost of Hunt-Crossley, lost rate -F_t s of friction; of surfaces that stick those of StickSlip.
struct ContactLaw {
  static constexpr std::array<ForceColumn, 4> columns{
      {{"normal force", "N"}, {"friction", "N"}, {"gap", "m"}, {"slip", "m/s"}}};
  HuntCrossleyForce normal{};
  double friction = 0;
  double slip_speed = 1e-3;
  double stick_stiffness = std::numeric_limits<double>::quiet_NaN();
  double stick_damping = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    normal.describe(v, "m", "N");
    v.quantity("friction", friction, "1", "[0, inf)", "coefficient of friction mu");
    v.quantity("slip speed", slip_speed, "m/s", "(0, inf)",
               "speed over which friction builds up, mu F tanh(slip / slip speed); nothing sticks, it creeps below it");
    v.optional_quantity("stick stiffness", stick_stiffness, "N/m", "(0, inf)",
                        "stiffness of the surfaces at rest on each other: they truly stick, without `slip speed`");
    v.optional_quantity("stick damping", stick_damping, "N s/m", "[0, inf)",
                        "force per speed while they stick; left out: critical for what moves along the surface");
  }
  void check() const {
    normal.check();
    if (!(friction >= 0 && slip_speed > 0))
      throw std::invalid_argument("friction must not be negative and the slip speed above 0; friction 0 is smooth");
    if (stick_stiffness <= 0 || std::isinf(stick_stiffness) || stick_damping < 0)
      throw std::invalid_argument(
          "stick stiffness must be above 0 and stick damping not negative; leave both out for regularised friction");
  }

  bool can_stick() const { return !std::isnan(stick_stiffness) && friction > 0; }
  /// Whether the force depends on how the contact has begun.
  bool remembers() const { return can_stick() || normal.gives_restitution(); }

  /// Along the normal turned clockwise (m/s).
  double slip(const Scene& scene, const ContactPlace& p) const { return dot(tangent(p), rate(scene, p)); }
  /// Along the normal, positive as the bodies approach (m/s).
  double approach(const Scene& scene, const ContactPlace& p) const { return -dot(p.point.normal, rate(scene, p)); }
  HuntCrossleyForce::Push push(const Scene& scene, const ContactPlace& p, const Touch& touch) const {
    const double b = touch.damping < 0 ? normal.damping_from(0) : touch.damping;
    return normal.at(-p.point.gap, approach(scene, p), b);
  }

  /// `way`: of surfaces that stick (m).
  ForcePower push(const Scene& scene, const ContactPlace& place, const Touch& touch, double way, Loads& loads,
                  ForceValues& values) const {
    const ContactPoint& c = place.point;
    values = {0, 0, c.gap, 0};
    if (!(c.gap < 0 || (can_stick() && touch.closed && touch.surfaces.sticks()))) return {};
    const HuntCrossleyForce::Push p = push(scene, place, touch);
    const double s = slip(scene, place);
    ForcePower power{p.stored, p.lost, 0};
    double drag = 0;
    if (!can_stick()) {
      drag = friction > 0 ? -friction * p.force * std::tanh(s / slip_speed) : 0.0;
      power.lost -= drag * s;
    } else if (touch.closed && touch.surfaces.sticks()) {
      drag = touch.surfaces.spring(stick_stiffness, way, s);
      power.stored += touch.surfaces.stored(stick_stiffness, way), power.lost += touch.surfaces.damping * s * s;
    } else if (touch.closed) {
      drag = -touch.surfaces.sliding * friction * p.force;
      power.lost -= drag * s;
    }
    add_pair(loads, scene, place.body_a, place.body_b, c.at, p.force * c.normal + drag * tangent(place));
    values = {p.force, drag, c.gap, s};
    return power;
  }

 private:
  static Vec2 tangent(const ContactPlace& p) { return {p.point.normal.y, -p.point.normal.x}; }
  static Vec2 rate(const Scene& scene, const ContactPlace& p) {
    return velocity_against(scene, p.body_a, p.body_b, p.point.at);
  }
};

}  // namespace subsoil::mbd
