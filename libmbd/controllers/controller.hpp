#pragma once

#include <concepts>
#include <memory>
#include <span>
#include <string>

#include "libmbd/element/any_element.hpp"

namespace subsoil::mbd {

class System;
struct Observation;

/// What a controller measures: a number of the machine at an instant.
class ControllerInput {
 public:
  virtual ~ControllerInput() = default;
  /// Finds what it names; throws std::invalid_argument.
  virtual void attach(const System& system) = 0;
  virtual double value(const Observation& at) const = 0;
  /// Whether it depends on accelerations, reactions or forces, and so on the controller's own output at that instant.
  virtual bool of_solution() const = 0;
};
using ControllerInputs = std::span<const std::shared_ptr<ControllerInput>>;

/// What a controller has beside what IsController asks for, as its `static constexpr ControllerMembers has{...}`.
struct ControllerMembers {
  bool sampled = false;    ///< sampled(): whether it acts from instant to instant, by a Sampler
  bool error = false;      ///< error(t, y, x): set point less measured value, a column
  bool functions = false;  ///< set_point, bias: functions of time
};

/// A controller makes an output u of numbers y that it measures, of states x of its own, and of the time:
///   u = output(t, y, x),   x' = rates(t, y, x)
/// check() refuses parameters by std::invalid_argument, check_inputs() what it measures, once that is known; measured()
/// are its inputs, in the order of y; start(t, y, x) gives the states at the start; direct(): whether u depends on
/// y at that very instant. `first_state` is set by the system, `output_unit` names what it drives in SI.
template <class C>
concept IsController = requires(C c, const C k, double t, const double* y, const double* x, double* out) {
  { C::has } -> std::same_as<const ControllerMembers&>;
  k.check();
  k.check_inputs();
  { k.measured() } -> std::same_as<ControllerInputs>;
  { k.state_count() } -> std::same_as<std::size_t>;
  { k.output(t, y, x) } -> std::same_as<double>;
  k.rates(t, y, x, out);
  k.start(t, y, out);
  { k.direct() } -> std::same_as<bool>;
  c.first_state = std::size_t{0};
  c.output_unit.c_str();
}
&&C::has.sampled == requires(const C k) { k.sampled(); }
&&C::has.error == requires(const C k, double t, const double* y, const double* x) { k.error(t, y, x); }
&&C::has.functions == requires(C c) { c.set_point, c.bias; };

struct ControllerFamily {
  template <class C>
  static constexpr bool takes = IsController<C>;
};
using AnyController = AnyElement<ControllerFamily>;

}  // namespace subsoil::mbd
