#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "libmbd/element/force.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"

namespace subsoil::mbd {

/// Dry and viscous friction in a revolute or translational joint, from the joint's own reaction:
///   F = -mu(|v|) N tanh(v/v_reg) - c v,   mu(v) = mu_k + (mu_s - mu_k) exp(-(v/v_s)^2)                  (N)
///   revolute       v = radius (spin_b - spin_a),  N = |reaction|;  torque radius F on b, its opposite on a
///   translational  v = speed of b along the line,  N = |N_1| + |N_2| = max(|F_n|, 2 |M|/guide);  F along the line on b
/// N_1, N_2: forces on the two ends of a guide of the given length about the joint's point that carry the normal force
/// F_n and the moment M. radius, guide [m] > 0; mu_s >= mu_k >= 0 [1]; v_s Stribeck speed, v_reg regularisation
/// speed [m/s] > 0; c [N s/m] >= 0, of the sliding speed.
/// Without a stick stiffness there is no sticking: below v_reg the joint creeps, v ~ v_reg F/(mu_s N), which the
/// reported sliding speed shows. With one, k [N/m], the joint either slides or sticks:
///   slides (sigma = +-1, the sense of v)  F = -sigma mu(|v|) N - c v          until v = 0, where it sticks
///   sticks (at s_0, the way s at that instant)  F = -k (s - s_0) - d v - c v   until |k (s - s_0) + d v| = mu_s N
/// Both ends are events, located in time. d [N s/m] >= 0 damps the joint's swinging on k. It holds for any time within
/// mu_s N/k of s_0. As it begins to slide, k (s - s_0)^2/2 turns to heat at once.
/// Validity: the reaction depends on the friction and the friction on the reaction: both are solved together (see
/// Partition::accelerate), which has no answer where the joint locks itself, and the run then stops.
/// Energy: sliding: lost rate = -F v >= 0, nothing is stored; sticking: stored = k (s - s_0)^2/2, lost rate (c + d)
/// v^2. Source: Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083, eq. 6, with tanh for the sign;
/// sticking: Karnopp 1985, J. Dyn. Sys. Meas. Control 107, 100, with a spring in place of his exact rest.
struct JointFriction {
  static constexpr ForceMembers has{
      .check = true, .initialise_from_pose = true, .stick = true, .trace = true, .joint = true};
  static constexpr std::array<ForceColumn, 5> columns{
      {{"force", "N"}, {"torque", "N m"}, {"sliding speed", "m/s"}, {"normal force", "N"}, {"sticking", "1"}}};
  std::string joint{};  ///< its name; the bodies are the joint's
  double radius = std::numeric_limits<double>::quiet_NaN();
  double guide = std::numeric_limits<double>::quiet_NaN();
  double mu_s = std::numeric_limits<double>::quiet_NaN();
  double mu_k = std::numeric_limits<double>::quiet_NaN();
  double stribeck_speed = 0.01;
  double regularisation_speed = 1e-3;
  double viscous = 0;
  double stick_stiffness = std::numeric_limits<double>::quiet_NaN();
  double stick_damping = 0;
  // Set by the system from the joint:
  int body_a = -1, body_b = -1, row = -1;  ///< row: its first equation
  bool slides = false;
  std::array<double, 2> p_b{0, 0};
  double angle_a = 0;
  // What it remembers where it can stick:
  int sliding = 0;      ///< 0 sticks, else the sense in which it slides
  double stuck_at = 0;  ///< the way at which it came to stick (m)

  template <class V>
  void describe(V& v) {
    v.card("joint friction", "Stribeck friction in a pin or slide, from the joint's reaction");
    v.joint("joint friction", joint, "the revolute or translational joint that it acts in");
    v.optional_quantity("radius", radius, "m", "(0, inf)", "radius of the pin, for a revolute joint");
    v.optional_quantity("guide", guide, "m", "(0, inf)", "length of the guide, for a translational joint");
    v.quantity("mu_s", mu_s, "1", "[0, inf)", "coefficient of friction near rest");
    v.quantity("mu_k", mu_k, "1", "[0, inf)", "coefficient of friction in fast sliding, at most mu_s");
    v.quantity("Stribeck speed", stribeck_speed, "m/s", "(0, inf)", "speed over which it falls from mu_s to mu_k");
    v.quantity("regularisation speed", regularisation_speed, "m/s", "(0, inf)",
               "speed below which the friction fades: the joint creeps instead of sticking");
    v.quantity("viscous", viscous, "N s/m", "[0, inf)", "further force per sliding speed");
    v.optional_quantity(
        "stick stiffness", stick_stiffness, "N/m", "(0, inf)",
        "stiffness of the surfaces at rest on each other: the joint truly sticks, without regularisation");
    v.quantity("stick damping", stick_damping, "N s/m", "[0, inf)", "force per speed while it sticks");
  }

  void check() const {
    if (!(mu_s >= mu_k && mu_k >= 0 && std::isfinite(mu_s)))
      throw std::invalid_argument(
          "mu_s and mu_k must be given, mu_k not negative and at most mu_s; equal values are Coulomb's friction");
    if (!(stribeck_speed > 0 && regularisation_speed > 0 && viscous >= 0 && stick_damping >= 0))
      throw std::invalid_argument(
          "Stribeck and regularisation speed must be above 0, viscous and stick damping not negative");
    if (!std::isnan(stick_stiffness) && !(stick_stiffness > 0 && std::isfinite(stick_stiffness)))
      throw std::invalid_argument("stick stiffness must be above 0; leave it out for regularised friction");
  }

  /// Takes what it needs from the joint that it names.
  template <class Joint>
  void attach([[maybe_unused]] const Joint& j, [[maybe_unused]] int first_row) {
    if constexpr (std::is_same_v<Joint, Revolute> || std::is_same_v<Joint, Translational>) {
      slides = std::is_same_v<Joint, Translational>;
      if (slides && !(guide > 0))
        throw std::invalid_argument("joint '" + joint + "' is a slide: give the length of its guide");
      if (!slides && !(radius > 0)) throw std::invalid_argument("joint '" + joint + "' is a pin: give its radius");
      if constexpr (std::is_same_v<Joint, Translational>) angle_a = j.angle_a;
      body_a = j.body_a, body_b = j.body_b, p_b = j.p_b, row = first_row;
    } else {
      throw std::invalid_argument("joint '" + joint + "' is neither revolute nor translational; name one that is");
    }
  }

  bool can_stick() const { return !std::isnan(stick_stiffness); }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const Contact c = contact(scene);
    const double f = force(c);
    const bool sticks = can_stick() ? sliding == 0 : std::abs(c.v) < regularisation_speed;
    if (slides) {
      loads.add(body_b, c.arm_b, f * c.e);
      loads.add(body_a, c.arm_a, -f * c.e);
      values = {f, 0, c.v, c.normal, sticks ? 1.0 : 0.0};
    } else {
      loads.add_wrench(body_b, 0, 0, radius * f);
      loads.add_wrench(body_a, 0, 0, -radius * f);
      values = {0, radius * f, c.v, c.normal, sticks ? 1.0 : 0.0};
    }
    if (!can_stick() || sliding != 0) return {0, -f * c.v, 0};
    return {stored(c), (viscous + stick_damping) * c.v * c.v, 0};
  }

  /// Falls through 0 where it changes between sliding and sticking.
  double hold(const Scene& scene) const {
    if (!can_stick()) return 1;
    const Contact c = contact(scene);
    // A speed of rounding's size, as it begins to slide, is not the end of sliding.
    return sliding == 0 ? mu_s * c.normal - std::abs(spring(c)) : sliding * c.v + 1e-12;
  }
  Changeover pass_event(const Scene& scene) {
    const Contact c = contact(scene);
    if (sliding != 0) {
      sliding = 0, stuck_at = c.s;
      return {};
    }
    sliding = (c.v != 0 ? c.v : -spring(c)) > 0 ? 1 : -1;
    return {stored(c), true};
  }
  void initialise_from_pose(const Scene& scene) { begin_trace(scene); }
  /// Slides if it moves, else sticks where it is.
  void begin_trace(const Scene& scene) {
    const Contact c = contact(scene);
    sliding = std::abs(c.v) < 1e-9 ? 0 : c.v > 0 ? 1 : -1;
    stuck_at = c.s;
  }
  std::array<double, 2> memory() const { return {static_cast<double>(sliding), stuck_at}; }
  void set_memory(const std::array<double, 2>& m) { sliding = static_cast<int>(m[0]), stuck_at = m[1]; }

 private:
  /// Of the surfaces: way and speed of b's on a's, force that presses them; of a slide also moment arms and direction.
  struct Contact {
    double s, v, normal;
    Vec2 arm_a{}, arm_b{}, e{};
  };
  Contact contact(const Scene& scene) const {
    const BodyState &a = scene.bodies[static_cast<std::size_t>(body_a)],
                    &b = scene.bodies[static_cast<std::size_t>(body_b)];
    const double first = scene.lambda[static_cast<std::size_t>(row)],
                 second = scene.lambda[static_cast<std::size_t>(row) + 1];
    if (!slides) return {radius * (b.angle - a.angle), radius * (b.omega - a.omega), std::hypot(first, second)};
    const Vec2 arm_b = b.vector_in_world(p_b), arm_a = b.r + arm_b - a.r;
    const Vec2 e{std::cos(a.angle + angle_a), std::sin(a.angle + angle_a)};
    return {dot(e, arm_a),
            dot(e, b.velocity_at(arm_b) - a.velocity_at(arm_a)),
            std::max(std::abs(first), 2 * std::abs(second) / guide),
            arm_a,
            arm_b,
            e};
  }
  double spring(const Contact& c) const { return -stick_stiffness * (c.s - stuck_at) - stick_damping * c.v; }
  double stored(const Contact& c) const { return 0.5 * stick_stiffness * (c.s - stuck_at) * (c.s - stuck_at); }
  double force(const Contact& c) const {
    if (can_stick() && sliding == 0) return spring(c) - viscous * c.v;
    const double x = c.v / stribeck_speed, mu = mu_k + (mu_s - mu_k) * std::exp(-x * x);
    const double sense = can_stick() ? sliding : std::tanh(c.v / regularisation_speed);
    return -mu * c.normal * sense - viscous * c.v;
  }
};

}  // namespace subsoil::mbd
