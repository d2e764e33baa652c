#pragma once

#include <stdexcept>

#include "libmbd/base/function.hpp"
#include "libmbd/element/force_geometry.hpp"

namespace subsoil::mbd {

/// Direct-current motor with a gear between two bodies, w = angle_b' - angle_a' at its output:
///   L i' = u(t) - R i - K n w,   T = n K i - n^2 b w          torque on b, its opposite on a         (V, A, N m)
/// u voltage: f(t) + controller; K torque constant [N m/A], which is that of the back EMF [V s/rad]; R resistance
/// [ohm] > 0; L inductance [H], 0: i = (u - K n w)/R at once; n gear ratio, turns of the rotor per turn of the output;
/// b viscous friction of the rotor [N m s/rad]. State: i. The rotor's inertia J is that of a body: at the output n^2 J.
/// Energy: stored = L i^2/2, lost rate = R i^2 + n^2 b w^2, work rate = u i.
/// Source: Franklin, Powell & Emami-Naeini 2015, Feedback Control of Dynamic Systems, section 2.3.
struct ElectricMotor {
  static constexpr ForceMembers has{.check = true, .states = true, .controlled = true};
  static constexpr std::array<ForceColumn, 4> columns{
      {{"torque", "N m"}, {"current", "A"}, {"voltage", "V"}, {"power", "W"}}};
  static constexpr std::size_t state_count = 1;
  int body_a = -1, body_b = -1;
  double torque_constant = std::numeric_limits<double>::quiet_NaN();
  double resistance = std::numeric_limits<double>::quiet_NaN();
  double inductance = 0, ratio = 1, friction = 0;
  double start_current = 0;
  Function voltage{};
  std::string controller{};
  // Set by the system:
  int signal = -1;
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("electric motor", "a direct-current motor with a gear that turns the second body against the first");
    v.bodies("electric motor", body_a, body_b, "the two bodies; the torque is reported on the second");
    v.quantity("torque constant", torque_constant, "N m/A", "(0, inf)", "torque per current, and back EMF per speed");
    v.quantity("resistance", resistance, "ohm", "(0, inf)", "of the winding");
    v.quantity("inductance", inductance, "H", "[0, inf)", "of the winding; 0: the current follows at once");
    v.quantity("gear ratio", ratio, "1", "(0, inf)", "turns of the rotor per turn of the output");
    v.quantity("friction", friction, "N m s/rad", "[0, inf)", "viscous, of the rotor");
    v.quantity("start current", start_current, "A", "(-inf, inf)", "at the start, with an inductance");
    v.optional_function("voltage", voltage, "V", "voltage; the controller's output is added");
    v.text("controller", controller, "name of the controller that gives the voltage; left out: none");
  }

  void check() const {
    if (!(torque_constant > 0 && resistance > 0 && inductance >= 0 && ratio > 0))
      throw std::invalid_argument("torque constant, resistance and gear ratio must be above 0");
    if (!voltage.is_set() && controller.empty()) throw std::invalid_argument("needs a voltage or a controller");
  }

  std::array<double, 1> start_states(const Scene&) const { return {inductance > 0 ? start_current : 0}; }
  std::array<double, 1> state_scales() const { return {1}; }
  std::array<double, 1> state_rates(const Scene& scene) const {
    if (!(inductance > 0)) return {0};
    const double i = scene.states[first_state];
    return {(supplied(scene) - resistance * i - torque_constant * ratio * speed(scene)) / inductance};
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const double w = speed(scene), u = supplied(scene);
    const double i = inductance > 0 ? scene.states[first_state] : (u - torque_constant * ratio * w) / resistance;
    const double drag = ratio * ratio * friction * w, torque = ratio * torque_constant * i - drag;
    loads.add_wrench(body_b, 0, 0, torque);
    loads.add_wrench(body_a, 0, 0, -torque);
    values = {torque, i, u, u * i};
    return {0.5 * inductance * i * i, resistance * i * i + drag * w, u * i};
  }

 private:
  double speed(const Scene& scene) const { return body_of(scene, body_b).omega - body_of(scene, body_a).omega; }
  double supplied(const Scene& scene) const {
    const double given = voltage.is_set() ? voltage.value(scene.t) : 0;
    return signal < 0 ? given : given + scene.signals[static_cast<std::size_t>(signal)];
  }
};

}  // namespace subsoil::mbd
