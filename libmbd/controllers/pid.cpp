#include "libmbd/controllers/pid.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace subsoil::mbd {

void PidController::check() const {
  const auto refuse = [](const char* text) { throw std::invalid_argument(text); };
  if (derivative != 0 && !sampled() && !(filter_time > 0))
    refuse("a derivative gain needs a filter time above 0: a tenth of K_d/K_p is usual");
  if (least >= largest) refuse("minimum must be below maximum");
  if (delay > 0 && !sampled()) refuse("a delay needs a sample time: it is from a sample to its output");
  if (integral != 0 && saturates() && !(tracking() > 0))
    refuse("an output with bounds and integral gain needs a tracking time above 0 where K_p/K_i is not");
}

void PidController::check_inputs() const {
  if (!input) throw std::invalid_argument("measures nothing; give it a measure");
}

double PidController::tracking() const {
  return tracking_time == tracking_time ? tracking_time : proportional / integral;
}

double PidController::limited(double v) const {
  if (v < least) return least;  // NaN: no bound
  return v > largest ? largest : v;
}

double PidController::unlimited(double t, double measured, const double* x) const {
  const double y = seen(measured, x);
  double v = bias.value(t) + proportional * (set_point.value(t) - y) + x[0];
  if (derivative != 0) v += derivative * (weighed(t, y) - x[1]) / filter_time;
  return v;
}

void PidController::rates(double t, const double* measured, const double* x, double* out) const {
  const double y = seen(*measured, x);
  out[0] = out[1] = 0;
  out[2] = sensor_lag > 0 ? (*measured - x[2]) / sensor_lag : 0;
  if (sampled()) return;
  out[0] = integral * (set_point.value(t) - y);
  if (integral != 0 && saturates()) {
    const double v = unlimited(t, *measured, x);
    out[0] += (limited(v) - v) / tracking();
  }
  if (derivative != 0) out[1] = (weighed(t, y) - x[1]) / filter_time;
}

void PidController::start(double t, const double* measured, double* out) const {
  out[0] = 0, out[1] = derivative != 0 ? weighed(t, *measured) : 0, out[2] = sensor_lag > 0 ? *measured : 0;
}

void Sampler::start(double t) {
  *this = Sampler{};
  origin_ = t;
}

double Sampler::next(const PidController& c) const {
  const double sample = sample_at(c);
  return pending_.empty() ? sample : std::min(sample, pending_.front().first);
}

void Sampler::sample(const PidController& c, double t, double y) {
  const double e = c.set_point.value(t) - y, w = c.weighed(t, y);
  const double filter = c.filter_time > 0 ? c.filter_time : 0;
  const bool first = count_ == 0;
  if (!first) derivative_ = (filter * derivative_ + c.derivative * (w - weighed_)) / (filter + c.sample_time);
  weighed_ = w;
  if (!first) integral_ += c.sample_time * c.integral * e;
  const double v = c.bias.value(t) + c.proportional * e + integral_ + derivative_, u = c.limited(v);
  if (c.integral != 0 && c.saturates()) integral_ += std::min(1.0, c.sample_time / c.tracking()) * (u - v);
  pending_.emplace_back(t + c.delay, u);
}

bool Sampler::act(const PidController& c, double t, double close, double measured, const double* x) {
  if (sample_at(c) <= t + close) {
    sample(c, sample_at(c), c.seen(measured, x));  // t differs by rounding, beside which a set point may jump
    ++count_;
  }
  const double before = held(t);
  while (!pending_.empty() && pending_.front().first <= t + close) {
    changes_.emplace_back(t, pending_.front().second);
    pending_.pop_front();
  }
  return held(t) != before;
}

double Sampler::held(double t, bool before) const {
  double u = held_;
  for (const auto& [from, value] : changes_)
    if (before ? from < t : from <= t) u = value;
  return u;
}

void Sampler::forget_before() {
  if (!changes_.empty()) held_ = changes_.back().second;
  changes_.clear();
}

}  // namespace subsoil::mbd
