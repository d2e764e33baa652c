#include "libmbd/function.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

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

void RampFunction::check() const {
  if (!(end > begin))
    throw std::invalid_argument("ramp function: its end must come after its begin; for a jump use a short ramp");
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
double RampFunction::integral(double t) const {
  // Primitive with P(begin) = 0; the difference makes it start at t = 0 wherever the ramp lies.
  const auto primitive = [this](double u) {
    const double span = end - begin;
    if (u <= begin) return from * (u - begin);
    const double x = std::min((u - begin) / span, 1.0);
    const double inside = from * x + (to - from) * x * x * x * x * (2.5 + x * (-3 + x));
    return span * inside + (u > end ? to * (u - end) : 0.0);
  };
  return primitive(t) - primitive(0);
}

void TableFunction::check() const {
  if (times.size() != values.size() || times.empty())
    throw std::invalid_argument("table function: needs as many values as times, and at least one point");
  for (std::size_t i = 1; i < times.size(); ++i)
    if (!(times[i] > times[i - 1]))
      throw std::invalid_argument("table function: times must increase; point " + std::to_string(i + 1) +
                                  " does not come after the one before");
}
void TableFunction::prepare() {
  check();
  const std::size_t n = times.size();
  bend_.assign(n, 0.0);
  // Thomas algorithm for the natural spline's second derivatives.
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double left = times[i] - times[i - 1], right = times[i + 1] - times[i];
    const double slope_change = (values[i + 1] - values[i]) / right - (values[i] - values[i - 1]) / left;
    const double pivot = 2 * (left + right) - left * upper[i - 1];
    upper[i] = right / pivot;
    bend_[i] = (6 * slope_change - left * bend_[i - 1]) / pivot;
  }
  for (std::size_t i = n; i-- > 1;) {
    if (i + 1 < n) bend_[i] -= upper[i] * bend_[i + 1];
  }
  if (n > 0) bend_[0] = 0;
  sum_.assign(n, 0.0);
  for (std::size_t i = 0; i + 1 < n; ++i) sum_[i + 1] = sum_[i] + within(i, times[i + 1]);
}
std::size_t TableFunction::interval(double t) const {
  const auto above = std::upper_bound(times.begin(), times.end(), t);
  return std::min(static_cast<std::size_t>(above - times.begin()) - 1, times.size() - 2);
}
double TableFunction::value(double t) const {
  if (t <= times.front()) return values.front();
  if (t >= times.back()) return values.back();
  const std::size_t i = interval(t);
  const double h = times[i + 1] - times[i], b = (t - times[i]) / h, a = 1 - b;
  return a * values[i] + b * values[i + 1] + ((a * a * a - a) * bend_[i] + (b * b * b - b) * bend_[i + 1]) * h * h / 6;
}
double TableFunction::first(double t) const {
  if (t < times.front() || t > times.back() || times.size() < 2) return 0;
  const std::size_t i = interval(t);
  const double h = times[i + 1] - times[i], b = (t - times[i]) / h, a = 1 - b;
  return (values[i + 1] - values[i]) / h + ((1 - 3 * a * a) * bend_[i] + (3 * b * b - 1) * bend_[i + 1]) * h / 6;
}
double TableFunction::second(double t) const {
  if (t < times.front() || t > times.back() || times.size() < 2) return 0;
  const std::size_t i = interval(t);
  const double b = (t - times[i]) / (times[i + 1] - times[i]);
  return (1 - b) * bend_[i] + b * bend_[i + 1];
}
double TableFunction::within(std::size_t i, double t) const {
  const double h = times[i + 1] - times[i], b = (t - times[i]) / h, a = 1 - b;
  const double linear = values[i] * (b - b * b / 2) + values[i + 1] * b * b / 2;
  const double left = -(a * a * a * a - 1) / 4 + (a * a - 1) / 2;  // integral of a^3 - a over b from 0
  const double right = b * b * b * b / 4 - b * b / 2;
  return h * linear + h * h * h / 6 * (left * bend_[i] + right * bend_[i + 1]);
}
double TableFunction::integral(double t) const {
  const auto primitive = [this](double u) {
    if (u <= times.front()) return values.front() * (u - times.front());
    if (u >= times.back()) return sum_.back() + values.back() * (u - times.back());
    const std::size_t i = interval(u);
    return sum_[i] + within(i, u);
  };
  return primitive(t) - primitive(0);
}

void SumFunction::check() const {
  for (const auto& term : terms)
    if (!term.is_set()) throw std::invalid_argument("sum function: every term must be given");
}
double SumFunction::value(double t) const {
  double sum = 0;
  for (const auto& f : terms) sum += f.value(t);
  return sum;
}
double SumFunction::first(double t) const {
  double sum = 0;
  for (const auto& f : terms) sum += f.first(t);
  return sum;
}
double SumFunction::second(double t) const {
  double sum = 0;
  for (const auto& f : terms) sum += f.second(t);
  return sum;
}
double SumFunction::integral(double t) const {
  double sum = 0;
  for (const auto& f : terms) sum += f.integral(t);
  return sum;
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

}  // namespace subsoil::mbd
