#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "libmbd/base/fault.hpp"
#include "libmbd/element/force.hpp"
#include "libmbd/element/stick_slip.hpp"
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
/// reported sliding speed shows. The maximum friction is then not mu_s N: at the default speeds 0.963 of it with mu_k =
/// 0.6 mu_s, and none of mu_s is left where v_s is below v_reg (largest_mu()). With one, k [N/m], the joint either
/// slides or sticks (StickSlip), -c v beside either:
///   slides (sigma = +-1, the sense of v)  F = -sigma mu(|v|) N - c v
///   sticks                                F = -k (s - s_0) - d v - c v   until |k (s - s_0) + d v| = mu_s N
/// A load that jumps by D has the bristle carry up to (1 + e^-2) D. It holds for any time within mu_s N/k of s_0. The
/// strain k (s - s_0)^2/2 is of the heat of sliding: taken from it as the joint begins to stick, given back as it
/// slides.
/// Validity: the reaction depends on the friction and the friction on the reaction: both are solved together (see
/// Partition::accelerate), which has no answer where the joint locks itself, and the run then stops.
/// Energy: sliding: lost rate = -F v >= 0, nothing is stored; sticking: stored = k (s - s_0)^2/2, lost rate (c + d)
/// v^2. Source: Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083, eq. 6, with tanh for the sign;
/// sticking: Karnopp 1985, J. Dyn. Sys. Meas. Control 107, 100, with a spring in place of his exact rest.
struct JointFriction {
  static constexpr ForceMembers has{
      .check = true, .initialise_from_pose = true, .stick = true, .trace = true, .joint = true, .profiles = true};
  static constexpr std::array<ForceColumn, 5> columns{
      {{"force", "N"}, {"torque", "N m"}, {"sliding speed", "m/s"}, {"normal force", "N"}, {"sticking", "1", true}}};
  std::string joint{};  ///< its name; the bodies are the joint's
  double radius = std::numeric_limits<double>::quiet_NaN();
  double guide = std::numeric_limits<double>::quiet_NaN();
  double mu_s = std::numeric_limits<double>::quiet_NaN();
  double mu_k = std::numeric_limits<double>::quiet_NaN();
  double stribeck_speed = 0.01;
  double regularisation_speed = 1e-3;
  double viscous = 0;
  double stick_stiffness = std::numeric_limits<double>::quiet_NaN();
  double stick_damping = std::numeric_limits<double>::quiet_NaN();
  // Set by the system from the joint:
  int body_a = -1, body_b = -1, row = -1;  ///< row: its first equation
  bool slides = false;
  std::array<double, 2> p_b{0, 0};
  double angle_a = 0;
  StickSlip surfaces{};  ///< where it can stick

  template <class V>
  void describe(V& v) {
    v.card("joint friction", "Stribeck friction in a pin or slide, from the joint's reaction");
    v.joint("joint friction", joint, "the revolute or translational joint that it acts in");
    v.optional_quantity("radius", radius, "m", "(0, inf)", "radius of the pin, for a revolute joint");
    v.optional_quantity(
        "guide", guide, "m", "(0, inf)",
        "length of the guide, for a translational joint; its middle is the joint's point, which travels "
        "with the second body, so that this point decides the normal forces");
    v.quantity("mu_s", mu_s, "1", "[0, inf)", "coefficient of friction near rest");
    v.quantity("mu_k", mu_k, "1", "[0, inf)", "coefficient of friction in fast sliding, at most mu_s");
    v.quantity("Stribeck speed", stribeck_speed, "m/s", "(0, inf)", "speed over which it falls from mu_s to mu_k");
    v.quantity("regularisation speed", regularisation_speed, "m/s", "(0, inf)",
               "speed below which the friction fades: the joint creeps instead of sticking");
    v.quantity("viscous", viscous, "N s/m", "[0, inf)", "further force per sliding speed");
    v.optional_quantity(
        "stick stiffness", stick_stiffness, "N/m", "(0, inf)",
        "stiffness of the surfaces at rest on each other: the joint truly sticks, without regularisation");
    v.optional_quantity("stick damping", stick_damping, "N s/m", "[0, inf)",
                        "force per speed while it sticks; left out: critical for what moves along the joint");
  }

  void check() const {
    if (!(mu_s >= 0 && std::isfinite(mu_s))) throw KeyFault("mu_s", "must be given and not negative");
    if (!(mu_k >= 0 && mu_k <= mu_s))
      throw KeyFault("mu_k", "must be given, not negative and at most mu_s; equal values are Coulomb's friction");
    if (!(stribeck_speed > 0 && regularisation_speed > 0 && viscous >= 0 && !(stick_damping < 0)))
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

  /// max mu(v) tanh(v/v_reg): the coefficient of the maximum friction.
  double largest_mu() const {
    if (can_stick()) return mu_s;
    double most = mu_k;
    constexpr int points = 2000;
    for (int i = 1; i <= points; ++i) {
      const double x = 4.0 * i / points;  // v/v_s
      most = std::max(most,
                      (mu_k + (mu_s - mu_k) * std::exp(-x * x)) * std::tanh(x * stribeck_speed / regularisation_speed));
    }
    return most;
  }

  bool can_stick() const { return !std::isnan(stick_stiffness); }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const Contact c = contact(scene);
    const double f = force(c);
    const bool sticks = can_stick() ? surfaces.sticks() : std::abs(c.v) < regularisation_speed;
    if (slides) {
      loads.add(body_b, c.arm_b, f * c.e);
      loads.add(body_a, c.arm_a, -f * c.e);
      values = {f, 0, c.v, c.normal, sticks ? 1.0 : 0.0};
    } else {
      loads.add_wrench(body_b, 0, 0, radius * f);
      loads.add_wrench(body_a, 0, 0, -radius * f);
      values = {0, radius * f, c.v, c.normal, sticks ? 1.0 : 0.0};
    }
    if (!can_stick() || !surfaces.sticks()) return {0, -f * c.v, 0};
    return {surfaces.stored(stick_stiffness, c.s), (viscous + surfaces.damping) * c.v * c.v, 0};
  }

  // mu over v: beyond 3 v_s nothing is left of what it has more at rest (1.2e-4), and a step across sees none of it.
  std::size_t profile_count() const { return mu_s > mu_k ? 1 : 0; }
  void profile_arguments(const Scene& scene, std::span<double> out) const {
    if (!out.empty()) out[0] = contact(scene).v;
  }
  double profile_value(std::size_t, double v) const { return mu(v); }
  std::vector<double> profile_nodes(std::size_t) const {
    std::vector<double> nodes;
    for (int i = -12; i <= 12; ++i) nodes.push_back(0.25 * i * stribeck_speed);
    return nodes;
  }

  bool remembers() const { return can_stick(); }
  std::size_t stick_count() const { return can_stick(); }
  bool sticks(std::size_t) const { return can_stick() && surfaces.sticks(); }
  bool creeps() const { return !can_stick() && mu_s > 0; }
  double held(const Scene& scene, std::size_t) const { return surfaces.spring(stick_stiffness, contact(scene).s, 0); }
  double grip_limit(const Scene& scene, std::size_t) const { return mu_s * contact(scene).normal; }
  double slip_acceleration(const Scene& scene, std::size_t, std::span<const double> accelerations, double) const {
    const auto of = [&](int body) {
      std::array<double, 3> of_body{};
      for (int k = 0; body > 0 && k < 3; ++k)
        of_body[static_cast<std::size_t>(k)] = accelerations[static_cast<std::size_t>(3 * (body - 1) + k)];
      return of_body;
    };
    const auto a = of(body_a), b = of(body_b);
    if (!slides) return radius * (b[2] - a[2]);
    const Contact c = contact(scene);
    const double omega_a = scene.bodies[static_cast<std::size_t>(body_a)].omega,
                 omega_b = scene.bodies[static_cast<std::size_t>(body_b)].omega;
    return dot(c.e, Vec2{b[0] - a[0], b[1] - a[1]}) + b[2] * cross(c.arm_b, c.e) - a[2] * cross(c.arm_a, c.e) +
           omega_a * omega_a * dot(c.e, c.arm_a) - omega_b * omega_b * dot(c.e, c.arm_b);
  }
  double grip(const Scene& scene, std::size_t, double force, double mass) {
    const Contact c = contact(scene);
    return surfaces.grip(stick_stiffness, c.s, c.v, force, mass, stick_damping);
  }

  void damp(std::size_t, double mass) { surfaces.damp(stick_stiffness, mass, stick_damping); }
  void slide(std::size_t, int sense) { surfaces.slide(sense); }
  int sense(std::size_t) const { return surfaces.sliding; }
  double slip_speed(const Scene& scene, std::size_t) const { return contact(scene).v; }

  double hold(const Scene& scene, std::size_t) const {
    const Contact c = contact(scene);
    return surfaces.hold(stick_stiffness, c.s, c.v, mu_s * c.normal);
  }
  Changeover pass_event(const Scene& scene, std::size_t) {
    const Contact c = contact(scene);
    return surfaces.pass_event(stick_stiffness, c.s, c.v);
  }
  void initialise_from_pose(const Scene& scene) { begin_trace(scene); }
  void begin_trace(const Scene& scene) {
    const Contact c = contact(scene);
    surfaces.begin(c.s, c.v, stick_damping);
  }
  std::array<double, 3> memory() const { return surfaces.memory(); }
  void set_memory(const std::array<double, 3>& m) { surfaces.set_memory(m); }

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
  double mu(double v) const {
    const double x = v / stribeck_speed;
    return mu_k + (mu_s - mu_k) * std::exp(-x * x);
  }
  double force(const Contact& c) const {
    if (can_stick() && surfaces.sticks()) return surfaces.spring(stick_stiffness, c.s, c.v) - viscous * c.v;
    const double sense = can_stick() ? surfaces.sliding : std::tanh(c.v / regularisation_speed);
    return -mu(c.v) * c.normal * sense - viscous * c.v;
  }
};

}  // namespace subsoil::mbd
