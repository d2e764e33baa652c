#pragma once

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "libmbd/base/fault.hpp"
#include "libmbd/base/function.hpp"
#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/hunt_crossley.hpp"

namespace subsoil::mbd {

/// Double-acting hydraulic cylinder between a point of body a and a point of body b at the distance L, with a
/// proportional directional valve or a given flow. x = L - closed length, in [0, stroke]; A: cap side, B: rod side.
///   F = p_A A_A - p_B A_B - c x' + stops       pushes the points apart;  A_A = pi D^2/4, A_B = pi (D^2 - d^2)/4   (N)
///   p_A' = (beta/V_A)(Q_A - A_A x' - q),  p_B' = (beta/V_B)(Q_B + A_B x' + q),  q = k (p_A - p_B)              (Pa/s)
///   V_A = V_0 + A_A x,  V_B = V_0 + A_B (stroke - x)                                                            (m^3)
/// Valve opening u = f(t) + controller, limited to -1 and 1: above 0 supply to A and B to tank, below 0 the other way
/// round. Every edge lets Q = u K phi(dp) through, K = rated flow/sqrt(rated drop), phi(dp) = dp/(dp^2 + dp_0^2)^(1/4):
/// the square root of an orifice above dp_0 = 1/20 of the rated drop, laminar below. From the tank a check valve of
/// the size of the open valve feeds a chamber that falls below tank pressure (anti-cavitation), to the tank one opens
/// above the relief pressure. With a given flow Q(t) into A instead, B is open to the tank and has its pressure, while
/// A keeps both valves. Their rated flow is then, unless it is given, what fills the cap side's stroke in 0.1 s: where
/// Q_v goes through one of them the pressure is beyond by dp, phi(dp) = Q_v/K: 0.08 MPa at a stroke per second, faster
/// by the square of the speed.
/// D bore, d rod [m], beta bulk modulus [Pa], V_0 dead volume of a chamber with its hose [m^3], k leakage [m^3/(s Pa)],
/// c viscous friction [N s/m]. States: p_A, p_B. Stops: Hunt & Crossley of exponent 1 beyond 0 and the stroke.
/// Energy: stored = sum of V p^2/(2 beta) and stops; lost = throttling at all edges + leakage + friction + stops; work
/// = p_S Q_S - p_T Q_T at pump and tank, and the compression p^2/(2 beta) of the oil that fills or leaves the volume
/// swept, a share p/(2 beta) of p dV. Source: Jelali & Kroll 2003, Hydraulic Servo-systems, sections 3.2 to 4.2.
struct HydraulicCylinder {
  static constexpr ForceMembers has{.check = true, .gap = true, .states = true, .controlled = true};
  static constexpr std::array<ForceColumn, 6> columns{
      {{"force", "N"}, {"length", "m"}, {"pressure a", "Pa"}, {"pressure b", "Pa"}, {"flow", "m^3/s"}, {"valve", "1"}}};
  static constexpr std::size_t state_count = 2;
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double bore = std::numeric_limits<double>::quiet_NaN(), rod = 0;
  double closed = std::numeric_limits<double>::quiet_NaN(), stroke = std::numeric_limits<double>::quiet_NaN();
  double supply = std::numeric_limits<double>::quiet_NaN(), tank = 0;
  Function valve{}, flow{};
  double rated_flow = std::numeric_limits<double>::quiet_NaN(), rated_drop = 3.5e6;
  double relief = std::numeric_limits<double>::quiet_NaN();
  double bulk = 1.4e9, dead = std::numeric_limits<double>::quiet_NaN(), leakage = 0, friction = 0;
  double start_a = std::numeric_limits<double>::quiet_NaN(), start_b = std::numeric_limits<double>::quiet_NaN();
  double stop_stiffness = 1e8, stop_damping = 1;
  std::string controller{};
  // Set by the system:
  int signal = -1;
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("hydraulic cylinder", "a cylinder with compressible oil, moved by a valve or by a given flow");
    v.bodies("hydraulic cylinder", body_a, body_b, "the two bodies that it joins");
    v.end_points(body_a, p_a, body_b, p_b, "its two ends");
    v.quantity("bore", bore, "m", "(0, inf)", "diameter of the piston");
    v.quantity("rod", rod, "m", "[0, inf)", "diameter of the rod, below the bore");
    v.quantity("closed length", closed, "m", "[0, inf)", "distance of the ends when the piston is at the cap");
    v.quantity("stroke", stroke, "m", "(0, inf)", "travel of the piston");
    v.optional_quantity("supply pressure", supply, "Pa", "(0, inf)", "of the pump; needed with a valve");
    v.quantity("tank pressure", tank, "Pa", "[0, inf)",
               "of the return line, to which the rod side is open with a given flow");
    v.optional_function("valve", valve, "1",
                        "opening of the valve from -1 to 1, above 0 extends; the controller's output is added, and the "
                        "sum is limited to that range; left out without a controller: a given flow");
    v.text("controller", controller, "name of the controller that moves the valve; left out: none");
    v.optional_function("flow given", flow, "m^3/s",
                        "flow into the cap side in place of valve and supply; the rod side is open to the tank");
    v.optional_quantity("rated flow", rated_flow, "m^3/s", "(0, inf)",
                        "through an edge of the open valve, the relief valve and the feed from the tank at the rated "
                        "drop; needed with a valve; left out with a given flow: fills the stroke in 0.1 s");
    v.quantity("rated drop", rated_drop, "Pa", "(0, inf)", "pressure drop of an edge at which the flow is rated");
    v.optional_quantity("relief pressure", relief, "Pa", "(0, inf)",
                        "at which a chamber opens to the tank, through an orifice of the rated flow; left out: never");
    v.quantity("bulk modulus", bulk, "Pa", "(0, inf)", "of the oil with the air in it");
    v.optional_quantity("dead volume", dead, "m^3", "(0, inf)",
                        "of each chamber with its hose when the piston stands at its end; left out: a tenth of the "
                        "swept volume of the cap side");
    v.quantity("leakage", leakage, "m^3/(s Pa)", "[0, inf)", "across the piston, flow per pressure difference");
    v.quantity("friction", friction, "N s/m", "[0, inf)", "viscous, force per speed");
    v.optional_quantity("start pressure a", start_a, "Pa", "[0, inf)", "of the cap side; left out: the tank's");
    v.optional_quantity("start pressure b", start_b, "Pa", "[0, inf)",
                        "of the rod side; left out: the tank's, which it always is with a given flow");
    v.quantity("stop stiffness", stop_stiffness, "N/m", "(0, inf)", "of the end stops");
    v.quantity("stop damping", stop_damping, "s/m", "[0, inf)", "of the end stops, see distance stop");
  }

  void check() const {
    const auto refuse = [](const char* text) { throw std::invalid_argument(text); };
    if (!(bore > 0 && stroke > 0 && closed >= 0 && bulk > 0))
      refuse("bore, closed length and stroke must be given, bore, stroke and bulk modulus above 0");
    if (!(rod >= 0 && rod < bore)) throw KeyFault("rod", "must be thinner than the bore");
    if (flow.is_set() == has_valve()) refuse("needs either `flow given`, or `valve` or `controller`");
    valve.check_share("valve");
    if (has_valve() && !(supply > tank && rated_flow > 0))
      refuse("a valve needs its rated flow and a supply pressure above the tank's");
    if (relief <= tank)
      throw KeyFault("relief pressure",
                     "must be above the tank's: at or below it the valve, which opens to the tank, is open at rest");
    if (flow.is_set() && start_b >= 0)
      throw KeyFault("start pressure b",
                     "has no effect with `flow given`: the rod side is open to the tank then and has its pressure; "
                     "leave it out, and give `tank pressure` instead");
  }

  bool has_valve() const { return valve.is_set() || !controller.empty(); }
  double cap_area() const { return std::numbers::pi / 4 * bore * bore; }
  double rod_area() const { return std::numbers::pi / 4 * (bore * bore - rod * rod); }

  std::array<double, 2> start_states(const Scene&) const {
    return {start_a >= 0 ? start_a : tank, start_b >= 0 ? start_b : tank};
  }
  std::array<double, 2> state_scales() const { return {1e5, 1e5}; }
  std::array<double, 2> state_rates(const Scene& scene) const {
    const Chambers c = chambers(scene, line(scene));
    return {c.a.rate, c.b.rate};
  }

  double gap(const Scene& scene) const {
    const double x = line(scene).length - closed;
    return std::min(x, stroke - x);
  }
  double gap_speed(const Scene& scene) const {
    return speed_against(scene, body_a, body_b, std::hypot(p_b[0], p_b[1]));
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const LineOfAction l = line(scene);
    if (!(l.length > 0)) throw std::runtime_error("hydraulic cylinder has length 0, so no direction");
    const Chambers c = chambers(scene, l);
    const HuntCrossleyForce law{1, stop_stiffness, stop_damping};
    const auto low = law.at(closed - l.length, -l.rate), high = law.at(l.length - closed - stroke, l.rate);
    const double force = c.a.p * cap_area() - c.b.p * rod_area() - friction * l.rate + low.force - high.force;
    const Vec2 on_b = force * l.e;
    loads.add(body_b, l.arm_b, on_b);
    loads.add(body_a, l.arm_a, -1.0 * on_b);
    values = {force, l.length, c.a.p, c.b.p, c.from_pump, c.opening};
    ForcePower power;
    power.stored = c.a.stored(bulk) + c.b.stored(bulk) + low.stored + high.stored;
    power.lost =
        c.throttled + leakage * (c.a.p - c.b.p) * (c.a.p - c.b.p) + friction * l.rate * l.rate + low.lost + high.lost;
    power.work = c.pumped + c.a.carried(bulk) + c.b.carried(bulk);
    return power;
  }

 private:
  struct Chamber {
    double p = 0, volume = 0, growth = 0;  ///< growth: of the volume, m^3/s
    double swept = 0;                      ///< by the piston, m^3/s
    double in = 0;                         ///< through its port, m^3/s
    double rate = 0;                       ///< Pa/s
    double stored(double beta) const { return volume * p * p / (2 * beta); }
    double carried(double beta) const { return growth * p * p / (2 * beta); }
  };
  struct Chambers {
    Chamber a, b;
    double opening = 0, from_pump = 0;
    double pumped = 0, throttled = 0;  ///< W
  };

  LineOfAction line(const Scene& scene) const { return {body_of(scene, body_a), p_a, body_of(scene, body_b), p_b}; }

  double rated() const { return rated_flow > 0 ? rated_flow : cap_area() * stroke / 0.1; }
  double orifice(double drop) const {
    const double laminar = rated_drop / 20;
    return rated() / std::sqrt(rated_drop) * drop / std::sqrt(std::hypot(drop, laminar));
  }
  double dead_volume() const { return dead > 0 ? dead : 0.1 * cap_area() * stroke; }

  Chamber chamber(double p, double area, double room, double rate) const {
    Chamber c{.p = p, .swept = area * rate};
    // Beyond its end by what the stop gives way; a tenth of the dead volume is always there.
    c.volume = dead_volume() + area * room, c.growth = c.swept;
    if (c.volume < 0.1 * dead_volume()) c.volume = 0.1 * dead_volume(), c.growth = 0;
    return c;
  }

  /// Through the edge from a line at `pressure` into the chamber.
  void feed(Chambers& c, Chamber& into, double pressure, double q) const {
    into.in += q;
    c.pumped += pressure * q;
    c.throttled += (pressure - into.p) * q;
  }

  Chambers chambers(const Scene& scene, const LineOfAction& l) const {
    const double x = l.length - closed;
    Chambers c;
    c.a = chamber(scene.states[first_state], cap_area(), x, l.rate);
    c.b = chamber(scene.states[first_state + 1], rod_area(), stroke - x, -l.rate);
    if (flow.is_set()) {
      c.from_pump = flow.value(scene.t);
      c.a.in = c.from_pump, c.pumped = c.a.p * c.a.in;
      guard(c, c.a);
      // Open to the tank: what comes through the piston and what is swept goes out at the tank's pressure.
      const double q = leakage * (c.a.p - c.b.p);
      c.a.rate = bulk / c.a.volume * (c.a.in - c.a.swept - q);
      c.b.in = c.b.swept - q, c.pumped += c.b.p * c.b.in;
      return c;
    }
    double u = valve.is_set() ? valve.value(scene.t) : 0;
    if (signal >= 0) u += scene.signals[static_cast<std::size_t>(signal)];
    c.opening = u = std::clamp(u, -1.0, 1.0);
    Chamber &driven = u > 0 ? c.a : c.b, &other = u > 0 ? c.b : c.a;
    c.from_pump = std::abs(u) * orifice(supply - driven.p);
    feed(c, driven, supply, c.from_pump);
    feed(c, other, tank, std::abs(u) * orifice(tank - other.p));
    guard(c, c.a), guard(c, c.b);
    const double q = leakage * (c.a.p - c.b.p);
    c.a.rate = bulk / c.a.volume * (c.a.in - c.a.swept - q);
    c.b.rate = bulk / c.b.volume * (c.b.in - c.b.swept + q);
    return c;
  }

  /// Feeds a chamber below the tank's pressure. The relief valve opens by the excess and drops the whole pressure to
  /// the tank's.
  void guard(Chambers& c, Chamber& of) const {
    if (of.p < tank) feed(c, of, tank, orifice(tank - of.p));
    if (of.p > relief) feed(c, of, tank, -orifice(of.p - relief));
  }
};

}  // namespace subsoil::mbd
