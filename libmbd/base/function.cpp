#include "libmbd/base/function.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "libmbd/base/fault.hpp"

namespace subsoil::mbd {

namespace {
constexpr double two_pi = 2 * std::numbers::pi;

template <class Kind, class Action>
double visit_set(const Kind& kind, Action action) {
  return std::visit(
      [&](const auto& f) -> double {
        if constexpr (std::is_same_v<std::decay_t<decltype(f)>, std::monostate>) {
          throw std::logic_error("a function of time was used before it was set");
        } else {
          return action(f);
        }
      },
      kind);
}
}  // namespace

double ConstantFunction::value(double) const { return value_; }
double ConstantFunction::first(double) const { return 0; }
double ConstantFunction::second(double) const { return 0; }
double ConstantFunction::integral(double t) const { return value_ * t; }
double ConstantFunction::double_integral(double t) const { return value_ * t * t / 2; }

double PolynomialFunction::value(double t) const {
  return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
}
double PolynomialFunction::first(double t) const {
  return c[1] + t * (2 * c[2] + t * (3 * c[3] + t * (4 * c[4] + t * 5 * c[5])));
}
double PolynomialFunction::second(double t) const {
  return 2 * c[2] + t * (6 * c[3] + t * (12 * c[4] + t * 20 * c[5]));
}
double PolynomialFunction::integral(double t) const {
  return t * (c[0] + t * (c[1] / 2 + t * (c[2] / 3 + t * (c[3] / 4 + t * (c[4] / 5 + t * c[5] / 6)))));
}
double PolynomialFunction::double_integral(double t) const {
  return t * t * (c[0] / 2 + t * (c[1] / 6 + t * (c[2] / 12 + t * (c[3] / 20 + t * (c[4] / 30 + t * c[5] / 42)))));
}

void HarmonicFunction::check() const {
  if (!(frequency > 0))
    throw std::invalid_argument("harmonic function: frequency must be above 0 Hz; for a constant use the value alone");
}
double HarmonicFunction::value(double t) const { return mean + amplitude * std::sin(two_pi * frequency * t + phase); }
double HarmonicFunction::first(double t) const {
  return amplitude * two_pi * frequency * std::cos(two_pi * frequency * t + phase);
}
double HarmonicFunction::second(double t) const {
  const double omega = two_pi * frequency;
  return -amplitude * omega * omega * std::sin(omega * t + phase);
}
double HarmonicFunction::integral(double t) const {
  const double omega = two_pi * frequency;
  return mean * t + amplitude * (std::cos(phase) - std::cos(omega * t + phase)) / omega;
}
double HarmonicFunction::double_integral(double t) const {
  const double omega = two_pi * frequency;
  const double swing = (std::sin(phase) - std::sin(omega * t + phase)) / omega + t * std::cos(phase);
  return mean * t * t / 2 + amplitude * swing / omega;
}

void Function::check_share(const char* key) const {
  const auto* constant = get_if<ConstantFunction>();
  if (constant != nullptr && !(std::abs(constant->value_) <= 1)) throw KeyFault(key, "must be from -1 to 1");
}

void RampFunction::check() const {
  if (!(end > begin))
    throw std::invalid_argument("ramp function: its end must come after its begin; for a jump use a short ramp");
  if (from == to) throw std::invalid_argument("ramp function: has no effect, `from` and `to` are equal; give `to`");
}
double RampFunction::value(double t) const {
  const double x = std::clamp((t - begin) / (end - begin), 0.0, 1.0);
  return from + (to - from) * x * x * x * (10 + x * (-15 + 6 * x));
}
double RampFunction::first(double t) const {
  const double x = std::clamp((t - begin) / (end - begin), 0.0, 1.0);
  return (to - from) / (end - begin) * 30 * x * x * (1 - x) * (1 - x);
}
double RampFunction::second(double t) const {
  const double x = std::clamp((t - begin) / (end - begin), 0.0, 1.0);
  return (to - from) / ((end - begin) * (end - begin)) * 60 * x * (1 - x) * (1 - 2 * x);
}
// Primitives that vanish at `begin`, once and twice; their differences start at t = 0 wherever the ramp lies.
double RampFunction::once(double t) const {
  const double span = end - begin;
  if (t <= begin) return from * (t - begin);
  const double x = std::min((t - begin) / span, 1.0);
  const double inside = from * x + (to - from) * x * x * x * x * (2.5 + x * (-3 + x));
  return span * inside + (t > end ? to * (t - end) : 0.0);
}
double RampFunction::twice(double t) const {
  const double span = end - begin;
  if (t <= begin) return from * (t - begin) * (t - begin) / 2;
  const double x = std::min((t - begin) / span, 1.0), x2 = x * x, beyond = std::max(t - end, 0.0);
  const double inside = from * x2 / 2 + (to - from) * x2 * x2 * x * (0.5 + x * (-0.5 + x / 7));
  return span * span * inside + once(end) * beyond + to * beyond * beyond / 2;
}
double RampFunction::integral(double t) const { return once(t) - once(0); }
double RampFunction::double_integral(double t) const { return twice(t) - twice(0) - t * once(0); }

PiecewiseCubic TableFunction::spline() const {
  try {
    return {times, values, periodic ? PiecewiseCubic::Ends::periodic : PiecewiseCubic::Ends::natural, "times", between};
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("table function: ") + error.what());
  }
}
void TableFunction::check() const { spline(); }
void TableFunction::prepare() { spline_ = spline(); }
PiecewiseCubic::Value TableFunction::at(double t) const {
  if (!periodic && t < times.front()) return {values.front(), 0, 0};
  if (!periodic && t > times.back()) return {values.back(), 0, 0};
  return spline_.at(t);
}
double TableFunction::value(double t) const { return at(t).value; }
double TableFunction::first(double t) const { return at(t).first; }
double TableFunction::second(double t) const { return at(t).second; }

TableFunction::Sums TableFunction::sums(double t) const {
  const double begin = times.front(), span = times.back() - begin;
  const double whole = spline_.integral(times.back()), whole_twice = spline_.double_integral(times.back());
  if (periodic) {  // n whole periods and the rest
    const double n = std::floor((t - begin) / span), rest = t - begin - n * span;
    const double once = spline_.integral(begin + rest), twice = spline_.double_integral(begin + rest);
    return {n * whole + once, n * (n - 1) / 2 * whole * span + n * whole_twice + n * whole * rest + twice};
  }
  const double before = std::min(t - begin, 0.0), beyond = std::max(t - times.back(), 0.0);
  if (before < 0) return {values.front() * before, values.front() * before * before / 2};
  if (beyond > 0)
    return {whole + values.back() * beyond, whole_twice + whole * beyond + values.back() * beyond * beyond / 2};
  return {spline_.integral(t), spline_.double_integral(t)};
}
double TableFunction::integral(double t) const { return sums(t).once - sums(0).once; }
double TableFunction::double_integral(double t) const {
  const Sums zero = sums(0), now = sums(t);
  return now.twice - zero.twice - t * zero.once;
}

void ExpressionFunction::check() const {
  if (!value_ || !first_ || !second_ || !integral_ || !double_integral_)
    throw std::invalid_argument(
        "expression function: needs its value, two derivatives and two integrals as callables; a scenario's formula "
        "brings them all");
}
double ExpressionFunction::value(double t) const { return value_(t); }
double ExpressionFunction::first(double t) const { return first_(t); }
double ExpressionFunction::second(double t) const { return second_(t); }
double ExpressionFunction::integral(double t) const { return integral_(t); }
double ExpressionFunction::double_integral(double t) const { return double_integral_(t); }

void SumFunction::check() const {
  for (const auto& term : terms)
    if (!term.is_set()) throw std::invalid_argument("sum function: every term must be given");
}
namespace {
template <class Part>
double sum_of(const std::vector<Function>& terms, Part part) {
  double sum = 0;
  for (const auto& f : terms) sum += part(f);
  return sum;
}
}  // namespace
double SumFunction::value(double t) const {
  return sum_of(terms, [t](const Function& f) { return f.value(t); });
}
double SumFunction::first(double t) const {
  return sum_of(terms, [t](const Function& f) { return f.first(t); });
}
double SumFunction::second(double t) const {
  return sum_of(terms, [t](const Function& f) { return f.second(t); });
}
double SumFunction::integral(double t) const {
  return sum_of(terms, [t](const Function& f) { return f.integral(t); });
}
double SumFunction::double_integral(double t) const {
  return sum_of(terms, [t](const Function& f) { return f.double_integral(t); });
}

double Function::value(double t) const {
  return visit_set(kind_, [t](const auto& f) { return f.value(t); });
}
double Function::first(double t) const {
  return visit_set(kind_, [t](const auto& f) { return f.first(t); });
}
double Function::second(double t) const {
  return visit_set(kind_, [t](const auto& f) { return f.second(t); });
}
double Function::integral(double t) const {
  return visit_set(kind_, [t](const auto& f) { return f.integral(t); });
}
double Function::double_integral(double t) const {
  return visit_set(kind_, [t](const auto& f) { return f.double_integral(t); });
}

bool Function::has_corners() const {
  if (const auto* sum = get_if<SumFunction>())
    return std::any_of(sum->terms.begin(), sum->terms.end(), [](const Function& f) { return f.has_corners(); });
  const auto* table = get_if<TableFunction>();
  return table != nullptr && table->between == Between::linear;
}

}  // namespace subsoil::mbd
