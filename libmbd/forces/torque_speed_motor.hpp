#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>

#include "libmbd/base/characteristic.hpp"
#include "libmbd/base/function.hpp"
#include "libmbd/element/force_geometry.hpp"

namespace subsoil::mbd {

/// Motor given by its torque over its speed, with a gear, between two bodies, w = angle_b' - angle_a' at its output:
///   T = n a f(n w)          torque on b, its opposite on a                                                   (N m)
/// f torque of the shaft over its speed [N m over rad/s]: an engine's or an induction motor's curve; n gear ratio,
/// turns of the shaft per turn of the output; a share of the torque [1], the accelerator: g(t) + controller, held
/// within the bounds -1 and 1. Where f falls below 0 (beyond the idle speed) the motor brakes. Quasi-static: the torque
/// follows at once. The shaft's inertia J is that of a body: at the output n^2 J. Energy: work rate = T w, negative
/// where it brakes.
struct TorqueSpeedMotor {
  static constexpr ForceMembers has{.check = true, .profiles = true, .controlled = true};
  static constexpr std::array<ForceColumn, 4> columns{
      {{"torque", "N m"}, {"speed", "rad/s"}, {"share", "1"}, {"power", "W"}}};
  int body_a = -1, body_b = -1;
  Characteristic curve{};
  double ratio = 1;
  Function share{};
  std::string controller{};
  int signal = -1;  ///< set by the system

  template <class V>
  void describe(V& v) {
    v.card("torque-speed motor", "a motor or engine given by its torque over its speed, with a gear");
    v.bodies("torque-speed motor", body_a, body_b, "the two bodies; the torque is reported on the second");
    v.optional_characteristic("torque curve", curve, "rad/s", "N m",
                              "torque of the shaft over its speed; needed; constant beyond a table's ends");
    v.quantity("gear ratio", ratio, "1", "(0, inf)", "turns of the shaft per turn of the output");
    v.optional_function("share", share, "1",
                        "of the torque, from -1 to 1; the controller's output is added, and the sum is limited to that "
                        "range; left out without a controller: 1");
    v.text("controller", controller, "name of the controller that gives the share; left out: none");
  }

  void check() const {
    if (!curve.is_set()) throw std::invalid_argument("needs a torque curve");
    share.check_share("share");
    if (!(ratio > 0)) throw std::invalid_argument("the gear ratio must be above 0");
  }

  std::size_t profile_count() const { return curve.nodes().empty() ? 0 : 1; }
  void profile_arguments(const Scene& scene, std::span<double> out) const {
    if (!out.empty()) out[0] = ratio * speed(scene);
  }
  double profile_value(std::size_t, double x) const { return curve.value(x); }
  std::vector<double> profile_nodes(std::size_t) const { return {curve.nodes().begin(), curve.nodes().end()}; }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const double w = speed(scene), a = given(scene), torque = ratio * a * curve.value(ratio * w);
    loads.add_wrench(body_b, 0, 0, torque);
    loads.add_wrench(body_a, 0, 0, -torque);
    values = {torque, ratio * w, a, torque * w};
    return {0, 0, torque * w};
  }

 private:
  double speed(const Scene& scene) const { return body_of(scene, body_b).omega - body_of(scene, body_a).omega; }
  double given(const Scene& scene) const {
    double a = share.is_set() ? share.value(scene.t) : controller.empty() ? 1 : 0;
    if (signal >= 0) a += scene.signals[static_cast<std::size_t>(signal)];
    return std::clamp(a, -1.0, 1.0);
  }
};

}  // namespace subsoil::mbd
