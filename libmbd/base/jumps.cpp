#include "libmbd/base/jumps.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <vector>

namespace subsoil::mbd {

namespace {

/// f, f' and f'' at a time. NaN: no value; a derivative that is not finite foretells nothing.
struct SampleOfMotion {
  double t = 0, value = 0, rate = 0, second = 0;
};

template <class Part>
double finite_or(double otherwise, Part part) {
  try {
    const double x = part();
    return std::isfinite(x) ? x : otherwise;
  } catch (const std::exception&) {
    return otherwise;
  }
}

class JumpSearch {
 public:
  JumpSearch(const Function& f, Smooth wanted, double from, double until)
      : f_(f),
        rates_(wanted == Smooth::value_and_rate),
        from_(from),
        until_(until),
        shortest_(1e-9 * std::min(1.0, until - from)) {}

  std::optional<Jump> first() {
    const double count = std::clamp(std::ceil((until_ - from_) / spacing), least_samples, most_samples);
    std::vector<SampleOfMotion> samples;
    samples.reserve(static_cast<std::size_t>(count) + 1);
    for (double k = 0; k <= count; ++k) samples.push_back(at(from_ + (until_ - from_) * (k / count)));
    for (std::size_t k = 0; k + 1 < samples.size(); ++k)
      if (jumps(samples[k], samples[k + 1]))
        if (const auto jump = within(samples[k], samples[k + 1])) return jump;
    return std::nullopt;
  }

 private:
  static constexpr double spacing = 2.5e-4;          // s, of samples; that of Inputs
  static constexpr double most_samples = 4e5;        // 100 s
  static constexpr double least_samples = 1000;      // of a motion of milliseconds
  static constexpr double share_of_position = 1e-6;  // of the range: formulas in pieces, with constants of six digits
  static constexpr double share_of_velocity = 1e-4;  // of the maximum: 1e-8 of the kinetic energy
  static constexpr double rounding = 1e-12;          // of the maximum |f|

  /// What a finer sample finds to be larger, a steep pulse between two of the others, counts too.
  SampleOfMotion at(double t) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    SampleOfMotion s{.t = t, .value = finite_or(none, [&] { return f_.value(t); })};
    s.rate = finite_or(0, [&] { return f_.first(t); });
    if (rates_) s.second = finite_or(0, [&] { return f_.second(t); });
    if (!std::isnan(s.value)) see(s);
    return s;
  }

  void see(const SampleOfMotion& s) {
    least_ = std::min(least_, s.value), most_ = std::max(most_, s.value),
    fastest_ = std::max(fastest_, std::abs(s.rate));
    const double size = std::max(std::abs(least_), std::abs(most_));
    value_ = std::max(rounding * size, rates_ ? share_of_position * (most_ - least_) : share_of_velocity * size);
    rate_ = std::max(share_of_velocity * fastest_, 1e4 * rounding * size / (until_ - from_));
  }

  // Of what the derivative foretells; NaN, a formula without a value, is no jump.
  bool value_jumps(const SampleOfMotion& a, const SampleOfMotion& b) const {
    return std::abs(b.value - a.value - 0.5 * (b.t - a.t) * (a.rate + b.rate)) > value_;
  }
  bool rate_jumps(const SampleOfMotion& a, const SampleOfMotion& b) const {
    return rates_ && std::abs(b.rate - a.rate - 0.5 * (b.t - a.t) * (a.second + b.second)) > rate_;
  }
  bool jumps(const SampleOfMotion& a, const SampleOfMotion& b) const { return value_jumps(a, b) || rate_jumps(a, b); }

  std::optional<Jump> within(const SampleOfMotion& a, const SampleOfMotion& b) {
    const double middle = 0.5 * (a.t + b.t);
    if (b.t - a.t <= shortest_ || middle <= a.t || middle >= b.t) return between(a, b);
    const SampleOfMotion m = at(middle);
    if (jumps(a, m))
      if (const auto jump = within(a, m)) return jump;
    if (jumps(m, b)) return within(m, b);
    return std::nullopt;
  }

  /// A function has values of its own at the jump: those beside it count, but at the start the one that it has there.
  std::optional<Jump> between(const SampleOfMotion& a, const SampleOfMotion& b) {
    const SampleOfMotion left = a.t <= from_ ? a : at(std::max(from_, a.t - shortest_)),
                         right = b.t >= until_ ? b : at(b.t + shortest_);
    // A root that begins has an infinite slope and no jump, nor has a ramp of microseconds: what the slope beside it
    // explains is none.
    const double slope = std::max(std::abs(left.rate), std::abs(right.rate)), width = right.t - left.t;
    const bool steep = std::abs(right.value - left.value) < 4 * width * slope;
    const double time = a.t <= from_ ? from_ : b.t;
    if (!steep && value_jumps(left, right)) return Jump{.time = time, .before = left.value, .after = right.value};
    if (rate_jumps(left, right)) return Jump{.time = time, .before = left.rate, .after = right.rate, .of_rate = true};
    return std::nullopt;
  }

  const Function& f_;
  bool rates_;
  double from_, until_;
  double shortest_;  // s; no body moves in it: a nanosecond, or its share of a motion of less than a second
  double least_ = std::numeric_limits<double>::infinity(), most_ = -least_, fastest_ = 0;  // of f, |f'|
  double value_ = 0, rate_ = 0;  // what rounding and constants of a formula leave
};

}  // namespace

std::optional<Jump> first_jump(const Function& f, Smooth wanted, double from, double until) {
  if (!f.is_set() || !(until > from)) return std::nullopt;
  return JumpSearch(f, wanted, from, until).first();
}

}  // namespace subsoil::mbd
