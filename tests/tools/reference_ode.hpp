#pragma once

// Reference solutions of small ordinary differential equations for tests: Runge-Kutta-Fehlberg 7(8) of boost::odeint,
// a code that shares nothing with the product.

#include <boost/numeric/odeint.hpp>
#include <vector>

namespace subsoil::test {

using OdeState = std::vector<double>;

/// y(t_end) of y' = f(y, t), y(t_begin) = y; local error below `tolerance` (absolute and relative).
template <class Right>
OdeState solve_ode(Right right, OdeState y, double t_begin, double t_end, double tolerance = 1e-13) {
  using namespace boost::numeric::odeint;
  const auto stepper = make_controlled<runge_kutta_fehlberg78<OdeState>>(tolerance, tolerance);
  integrate_adaptive(
      stepper, [&](const OdeState& s, OdeState& d, double t) { right(s, d, t); }, y, t_begin, t_end,
      1e-3 * (t_end - t_begin));
  return y;
}

}  // namespace subsoil::test
