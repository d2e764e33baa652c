#include "libmbd/integrators/singular_passage.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>

#include "libmbd/assembly/assembly.hpp"

namespace subsoil::mbd {

namespace {
constexpr int most_attempts = 40;
constexpr double first_travel = 0.05;     // rad
constexpr double travel_of_probe = 1e-3;  // rad, over which the approach is measured
constexpr double longest_over = 0.3;      // rad
constexpr double out_of_sight = 0.6;      // rad, from where nothing is known of a configuration ahead
constexpr double stop_short = 0.5;  // share of the way to the configuration that a step takes which does not pass it
constexpr double off_centre = 0.1;  // share of a step by which the configuration may lie off its middle
// Nearer than this no step stops short of the configuration: rounding of its begin is not smaller than what is left.
constexpr double at_hand = 2e-3;
// From so near a step over it errs by less than its rounding, some 1e-9, unless forces change within it.
constexpr double core_of_passage = 0.02, error_in_core = 1e-9;
}  // namespace

SingularPassage::SingularPassage(const System& system, Partition& partition)
    : system_(system),
      partition_(partition),
      gauss_(system, partition),
      scale_(coordinate_scale(system)),
      length_(system.length_scale()) {}

double SingularPassage::rate() const {
  double most = 0;
  for (int i = 1; i < system_.bodies(); ++i) {
    const BodyState& b = system_.body(i);
    most = std::max({most, std::abs(b.v.x) / length_, std::abs(b.v.y) / length_, std::abs(b.omega)});
  }
  return most;
}

double SingularPassage::rate_of(const MotionState& m) const {
  return m.velocity.cwiseProduct(scale_).cwiseAbs().maxCoeff() / length_;
}

bool SingularPassage::in_sight(double approach) const {
  return 2 * partition_.distance_from_singular() * rate() < longest_over * approach;
}

void SingularPassage::measure_approach(const MotionState& now) {
  const double rate = rate_of(now);
  MotionState ahead = now;
  partition_.evaluate_nearest(ahead);
  distance_ = partition_.distance_from_singular(), approach_ = 0;
  if (!(rate > 0)) return;
  const double dt = travel_of_probe / rate;
  ahead.t += dt;
  ahead.q += dt * (now.velocity + 0.5 * dt * now.acceleration);
  ahead.velocity += dt * now.acceleration;
  try {
    partition_.evaluate_nearest(ahead);
    approach_ = (distance_ - partition_.distance_from_singular()) / dt;
  } catch (const std::runtime_error&) {
  }
}

bool SingularPassage::attempt(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows) {
  if (!gauss_.step(now, h, next, flows)) return false;
  // Far too long a step leads to numbers beyond all bounds, whose error compares with nothing.
  if (!next.q.allFinite() || !next.velocity.allFinite() || !std::isfinite(gauss_.error())) return false;
  if (!gauss_.landed()) partition_.refuse_other_branch(next);
  return true;
}

void SingularPassage::step(const MotionState& now, double latest, double tolerance, MotionState& next,
                           Eigen::VectorXd& flows) {
  const double most = latest - now.t;
  const double rate = rate_of(now);
  if (!begun_) {
    begun_ = true;
    step_ = first_travel / std::max(rate, 1.0);
    measure_approach(now);
  }
  const double reach = approach_ > 0 ? distance_ / approach_ : std::numeric_limits<double>::infinity();
  const double short_of_it = distance_ > at_hand ? stop_short * reach : std::numeric_limits<double>::infinity();
  bool over = 2 * reach <= most && 2 * reach * rate <= longest_over, centred = false;
  double h = std::min(over ? 2 * reach : std::min(step_, short_of_it), most);
  const double allowed = std::max(tolerance * std::max(1.0, rate * length_),
                                  distance_ < core_of_passage ? error_in_core * rate * length_ : 0);
  const Eigen::VectorXd flows_before = flows;
  std::exception_ptr failure;
  for (int attempts = 0;; ++attempts) {
    flows = flows_before;
    bool made = false;
    try {
      made = attempt(now, h, next, flows);
    } catch (const std::runtime_error&) {
      failure = std::current_exception();
    }
    if (made && over && !centred) {
      const double middle = distance_ / (distance_ + gauss_.distance());
      centred = true;
      if (std::abs(middle - 0.5) > off_centre && 2 * middle * h <= most) {
        h *= 2 * middle;
        continue;
      }
    }
    if (made && !(gauss_.error() > allowed)) break;
    if (attempts == most_attempts) {
      if (failure) std::rethrow_exception(failure);
      throw MotionFault(now.t,
                        "no step is short enough beside a singular configuration of " + partition_.singular_owner());
    }
    h *= made ? std::clamp(0.9 * std::pow(allowed / gauss_.error(), 1. / 8), 0.2, 0.8) : 0.5;
    h = std::min(h, short_of_it);
    over = false;
  }
  mode_ = over ? Mode::over : Mode::near;
  const double change = 0.9 * std::pow(allowed / std::max(gauss_.error(), 1e-300), 1. / 8);
  if (h < most || h >= step_) step_ = h * std::clamp(change, 0.2, 2.0);
}

void SingularPassage::repeat(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows) {
  if (!attempt(now, h, next, flows))
    throw MotionFault(now.t, "the step to an event beside a singular configuration does not converge");
  mode_ = Mode::near;
}

void SingularPassage::accept() {
  distance_ = gauss_.distance(), approach_ = gauss_.approach();
  const bool passed = mode_ == Mode::over && !partition_.near_singular();
  const bool ahead = approach_ > 0 && distance_ < out_of_sight;
  mode_ = passed || (!(distance_ < far_enough) && !ahead) ? Mode::away : Mode::near;
}

}  // namespace subsoil::mbd
