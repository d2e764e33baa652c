#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/controllers/controller.hpp"

namespace subsoil::mbd {

/// A formula of measures: u = f(y_1, y_2, ...), each measure by its name, in SI units.
/// What it drives is a force or torque as a formula of places, speeds and angles. The work that it does is that of the
/// force it drives. Valid for measures of the motion: accelerations, reactions and forces depend on u at that instant.
/// Whoever reads formulas makes the function; this library only calls it. Not finite values end the run.
struct FormulaController {
  static constexpr ControllerMembers has{};
  std::string text{};                ///< as a scenario has it
  std::vector<std::string> names{};  ///< of the measures in it
  std::string output_unit = "1";
  std::function<double(const double*)> value{};
  std::vector<std::shared_ptr<ControllerInput>> inputs{};
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("formula", "a formula of measures");
    v.text("formula", text,
           "of the names of measures with one column each, in SI units: -k*gap^2 + 3*speed; + - * / ^, pi, e, sin cos "
           "tan asin acos atan atan2 sinh cosh tanh exp log sqrt abs sign min max pow");
    v.text("output in", output_unit, "SI unit of what it drives: N, N m, V, or 1 for a valve");
  }

  void check() const {}
  void check_inputs() const {
    if (!value) throw std::invalid_argument("formula controller: has no function; a scenario's formula brings it");
  }
  ControllerInputs measured() const { return inputs; }
  std::size_t state_count() const { return 0; }
  bool direct() const { return true; }
  double output(double, const double* y, const double*) const {
    const double u = value(y);
    if (!(u - u == 0))
      throw std::runtime_error("the formula '" + text + "' of a controller has no finite value where the machine is");
    return u;
  }
  void rates(double, const double*, const double*, double*) const {}
  void start(double, const double*, double*) const {}
};

}  // namespace subsoil::mbd
