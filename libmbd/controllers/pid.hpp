#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "libmbd/base/function.hpp"
#include "libmbd/controllers/controller.hpp"

namespace subsoil::mbd {

/// PID controller in parallel form with a filter on D, saturation and anti-windup by back-calculation:
///   e = r(t) - y,   v = b(t) + K_p e + I + D,   u = min(max(v, `least`), `largest`)
///   I' = K_i e + (u - v)/T_t,   D = K_d (w - x_d)/T_f,   x_d' = (w - x_d)/T_f,   w = e, or -y
/// y measured value, through a sensor y_f' = (y - y_f)/T_s where it has a lag; r set point, b feed-forward (bias); T_f
/// filter time, T_t tracking time [s], K_p/K_i unless given. I, x_d, y_f are states of the equations of motion, so that
/// the methods keep their order; x_d starts at w and y_f at y: D and the sensor start at rest.
/// With a sample time T the controller looks at t_k = k T only,
///   I_k = I_{k-1} + T (K_i e_k + (u_k - v_k)/T_t),   D_k = (T_f D_{k-1} + K_d (w_k - w_{k-1}))/(T_f + T)
/// and holds u_k from t_k + delay until the next one comes. Integrators step onto these instants.
/// Valid for an input of accelerations, reactions or forces only with a sensor lag or a sample time: else the output
/// would be an instantaneous function of itself. Source: Astrom & Hagglund 1995, PID Controllers, sections 3.3 to 3.5.
struct PidController {
  static constexpr ControllerMembers has{.sampled = true, .error = true, .functions = true};
  std::string measure{};  ///< a measure's column, as a scenario has it
  std::string measured_unit = "1", output_unit = "1";
  std::shared_ptr<ControllerInput> input{};
  Function set_point = 0.0, bias = 0.0;
  double proportional = 0, integral = 0, derivative = 0;
  double filter_time = std::numeric_limits<double>::quiet_NaN();
  double tracking_time = std::numeric_limits<double>::quiet_NaN();
  double least = std::numeric_limits<double>::quiet_NaN(), largest = std::numeric_limits<double>::quiet_NaN();
  bool derivative_of_measurement = false;
  double sensor_lag = 0, sample_time = 0, delay = 0;
  // Set and kept by the system:
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("pid", "a PID controller of a measure, with filter, saturation and anti-windup");
    v.text("pid", measure, "the measure that it controls, a column of machine.measures: depth, or load.x");
    v.text("measured in", measured_unit, "SI unit of the measure: m, N, rad ...");
    v.text("output in", output_unit, "SI unit of what it drives: N, N m, V, or 1 for a valve");
    v.function("set point", set_point, measured_unit,
               "value that it holds the measure at, with the unit of `measured in`");
    v.quantity("proportional", proportional, per(output_unit, measured_unit), "(-inf, inf)",
               "gain K_p, with the unit of `output in` per that of `measured in`");
    v.quantity("integral", integral, per(output_unit, measured_unit) + "/s", "(-inf, inf)",
               "gain K_i, with the unit of K_p per s");
    v.quantity("derivative", derivative, "(" + per(output_unit, measured_unit) + ") s", "(-inf, inf)",
               "gain K_d, with the unit of K_p times s");
    v.optional_quantity("filter time", filter_time, "s", "(0, inf)",
                        "time constant of the first-order filter on D; needed with K_d unless sampled");
    v.choice("derivative of", derivative_of_measurement, {{"error", false}, {"measurement", true}},
             "measurement: D does not kick where the set point jumps");
    v.function("bias", bias, output_unit, "feed-forward that is added, with the unit of `output in`");
    v.optional_quantity("minimum", least, output_unit, "(-inf, inf)",
                        "the output is not below, with the unit of `output in`; left out: no bound");
    v.optional_quantity("maximum", largest, output_unit, "(-inf, inf)",
                        "the output is not above, with the unit of `output in`; left out: no bound");
    v.optional_quantity("tracking time", tracking_time, "s", "(0, inf)",
                        "with which I follows a saturated output (anti-windup); left out: K_p/K_i");
    v.quantity("sensor lag", sensor_lag, "s", "[0, inf)",
               "time constant of the sensor; needed for forces and accelerations unless sampled");
    v.quantity("sample time", sample_time, "s", "[0, inf)", "it looks at multiples of this time only; 0: always");
    v.quantity("delay", delay, "s", "[0, inf)", "from a sample to its output; needs a sample time");
  }

  void check() const;
  void check_inputs() const;
  bool sampled() const { return sample_time > 0; }
  bool saturates() const { return least == least || largest == largest; }

  ControllerInputs measured() const { return {&input, 1}; }
  std::size_t state_count() const { return 3; }  ///< I, x_d, y_f
  bool direct() const { return !(sensor_lag > 0) && !sampled(); }
  /// Output at t for the measured value and the states of a continuous one.
  double output(double t, const double* y, const double* x) const { return limited(unlimited(t, *y, x)); }
  double error(double t, const double* y, const double* x) const { return set_point.value(t) - seen(*y, x); }
  void rates(double t, const double* y, const double* x, double* out) const;
  void start(double t, const double* y, double* out) const;

 private:
  friend class Sampler;
  static std::string per(const std::string& unit, const std::string& other) {
    if (other == "1") return unit;
    return (unit == "1" ? unit : "(" + unit + ")") + "/(" + other + ")";
  }
  double seen(double measured, const double* x) const { return sensor_lag > 0 ? x[2] : measured; }
  double weighed(double t, double y) const { return derivative_of_measurement ? -y : set_point.value(t) - y; }
  double unlimited(double t, double measured, const double* x) const;
  double limited(double v) const;
  double tracking() const;
};

/// What a sampled controller remembers, and the instants at which it acts.
class Sampler {
 public:
  void start(double t);
  /// The next instant at which it looks or its output changes.
  double next(const PidController& c) const;
  /// At that instant (give or take `close`), with what is measured then; true
  /// where the output has changed.
  bool act(const PidController& c, double t, double close, double measured, const double* x);
  /// The output at t, not before what forget_before() left; where it changes at t the one from there on, or `before`.
  double held(double t, bool before = false) const;
  void forget_before();
  bool operator==(const Sampler&) const = default;
  /// After forget_before().
  template <class A>
  void archive(A& a) {
    a("origin", origin_)("samples", count_)("integral", integral_)("derivative", derivative_)("weighed", weighed_);
    a("held", held_)("pending", pending_);
  }

 private:
  double sample_at(const PidController& c) const { return origin_ + count_ * c.sample_time; }
  void sample(const PidController& c, double t, double y);

  double origin_ = 0, count_ = 0;
  double integral_ = 0, derivative_ = 0, weighed_ = 0;
  double held_ = 0;                                 ///< before the changes
  std::vector<std::pair<double, double>> changes_;  ///< time and output, of the last machine step
  std::deque<std::pair<double, double>> pending_;   ///< time and output
};

}  // namespace subsoil::mbd
