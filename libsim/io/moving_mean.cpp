#include "libsim/io/moving_mean.hpp"

namespace subsoil::sim {

void MovingMean::add(double time, double duration, double value) {
  if (knots_.empty()) knots_.push_back({time - duration, 0.0});
  const double integral = knots_.back().integral + value * duration;
  constexpr double most = 16384;
  const std::size_t n = knots_.size();
  if (n > 2 && knots_[n - 1].time - knots_[n - 2].time < length_ / most)
    knots_.back() = {time, integral};
  else
    knots_.push_back({time, integral});
  // A step's end that sums up to the length but for rounding still counts as full.
  const double start = time - length_ * (1 - 1e-9);
  full_ = full_ || knots_.front().time <= start;
  while (knots_.size() > 2 && knots_[1].time <= start) knots_.pop_front();
}

double MovingMean::mean() const {
  const Knot &a = knots_[0], &b = knots_[1], &last = knots_.back();
  const double start = last.time - length_;
  const double share = b.time > a.time ? (start - a.time) / (b.time - a.time) : 0.0;
  return (last.integral - (a.integral + share * (b.integral - a.integral))) / length_;
}

}  // namespace subsoil::sim
