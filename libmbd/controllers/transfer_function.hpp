#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/controllers/controller.hpp"

namespace subsoil::mbd {

/// A linear transfer function of a measure y,
///   U(s) = (b_m s^m + ... + b_0)/(a_n s^n + ... + a_0) Y(s),   m <= n
/// in controllable canonical form, n states z:
///   z_1' = z_2, ..., z_n' = (y - a_0 z_1 - ... - a_{n-1} z_n)/a_n,   u = sum_i (b_i - d a_i) z_{i+1} + d y,  d =
///   b_n/a_n
/// Coefficients are in SI units and seconds, highest power first. It starts in its steady state of the measured value,
/// z_1 = y/a_0; with a_0 = 0 (an integral in it) at z = 0. Valid for an input of accelerations, reactions or forces
/// only where m < n. Source: Franklin, Powell & Emami-Naeini 2015, Feedback Control of Dynamic Systems, section 7.4.
struct TransferFunction {
  static constexpr ControllerMembers has{};
  std::string measure{};  ///< a measure's column, as a scenario has it
  std::string measured_unit = "1", output_unit = "1";
  std::vector<double> numerator{}, denominator{};
  std::shared_ptr<ControllerInput> input{};
  std::size_t first_state = 0;

  template <class V>
  void describe(V& v) {
    v.card("transfer function", "a linear transfer function of a measure");
    v.text("transfer function", measure, "the measure that it takes, a column of machine.measures: depth, or load.x");
    v.text("measured in", measured_unit, "SI unit of the measure: m, N, rad ...");
    v.text("output in", output_unit, "SI unit of what it drives: N, N m, V, or 1 for a valve");
    v.quantities("numerator", numerator, "1", "(-inf, inf)",
                 "coefficients of s, highest power first, in SI units: 2 0");
    v.quantities("denominator", denominator, "1", "(-inf, inf)",
                 "the same, of the numerator's power at least, first one not 0: 0.01 0.2 1");
  }

  void check() const {
    const auto refuse = [](const char* text) { throw std::invalid_argument(text); };
    if (numerator.empty() || denominator.empty()) refuse("needs a numerator and a denominator");
    if (!(std::abs(denominator.front()) > 0)) refuse("the denominator's first coefficient must not be 0");
    if (numerator.size() > denominator.size())
      refuse("the numerator has a higher power of s than the denominator: that is a derivative; add a lag below");
  }
  void check_inputs() const {
    if (!input) throw std::invalid_argument("measures nothing; give it a measure");
  }
  ControllerInputs measured() const { return {&input, 1}; }
  std::size_t state_count() const { return denominator.size() - 1; }
  bool direct() const { return through() != 0; }
  double output(double, const double* y, const double* x) const {
    const double d = through();
    double u = d * y[0];
    for (std::size_t i = 0; i < state_count(); ++i) u += (above(i) - d * below(i)) * x[i];
    return u;
  }
  void rates(double, const double* y, const double* x, double* out) const {
    const std::size_t n = state_count();
    if (n == 0) return;
    double top = y[0];
    for (std::size_t i = 0; i < n; ++i) top -= below(i) * x[i];
    for (std::size_t i = 0; i + 1 < n; ++i) out[i] = x[i + 1];
    out[n - 1] = top / denominator.front();
  }
  void start(double, const double* y, double* out) const {
    for (std::size_t i = 0; i < state_count(); ++i) out[i] = 0;
    if (state_count() > 0 && below(0) != 0) out[0] = y[0] / below(0);
  }

 private:
  /// Coefficients of s^i.
  double below(std::size_t i) const { return denominator[denominator.size() - 1 - i]; }
  double above(std::size_t i) const { return i < numerator.size() ? numerator[numerator.size() - 1 - i] : 0; }
  double through() const { return above(denominator.size() - 1) / denominator.front(); }
};

}  // namespace subsoil::mbd
