#include "libmbd/integrators/adaptive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/integrators/between.hpp"

namespace subsoil::mbd {

namespace {
// Within one advance(). More means that steps have become so short that the end is out of reach.
constexpr long most_steps = 2'000'000;
// So many steps tell how many would be needed: ten times the most are out of reach, however they may grow.
constexpr long looked_back_on = 20'000;
// From a singular pose, in rad, for the method to begin anew; and for its failure to have another reason: multipliers
// and what ida extrapolates them from grow with one over it.
constexpr double far_enough = 0.15, other_reason = 0.5;
// Motion in a step (rad) that is none; the first one of ida is of some 1e-5.
constexpr double least_motion = 1e-8;
// From a singular pose, where one step leads over it; and what that step may err by.
constexpr double step_over = 0.03, most_of_crossing = 1e-9;
// Of a state at which a method gave up: the body most accelerated, the constraint nearest to losing its rank.
std::string standing_out(const System& system, const Partition& partition, const MotionState& m) {
  Eigen::Index most = 0;
  const double largest = m.acceleration.cwiseProduct(coordinate_scale(system)).cwiseAbs().maxCoeff(&most);
  char text[160];
  std::snprintf(text, sizeof text, "; at t = %.9g s body '%.60s' is the most accelerated, %.2e m/s^2", m.t,
                system.body_name(static_cast<int>(most / 3) + 1).c_str(), largest);
  std::string all = text;
  const double distance = partition.distance_from_singular();
  if (distance > other_reason) return all;
  std::snprintf(text, sizeof text, ", and %.80s is some %.2g rad from a dead point", partition.singular_owner().c_str(),
                distance);
  return all + text;
}

}  // namespace

Adaptive::Adaptive(System& system)
    : Integrator(system),
      inputs_(system.model()),
      profiles_(system),
      directions_(switches_.count(), 0),
      walker_(system, partition_),
      before_crossing_(now_),
      after_crossing_(now_),
      next_(now_),
      gaps_(switches_.count(), 0),
      gaps_before_(gaps_) {
  event_gaps_.fill(gaps_);
}

void Adaptive::on_start() {
  clock_.restart();
  // Events of joints are looked for in steps no longer than those asked for.
  remembers_ = remembers(system_.model());
  coupled_ = remembers_ || system_.has_instants() || system_.has_joint_events();
  rows_ = partition_.used_rows();
  build();
  restart();
}

void Adaptive::restart() {
  wrench_changes_ = system_.wrench_changes();
  crossing_ = false;
  partition_.evaluate(now_);
  if (watches_switches()) fire_due(), release_friction();  // what begins beyond its zero has no root any more
  if (partition_.used_rows() != rows_) {                   // redundant constraints: others carry the multipliers now
    rows_ = partition_.used_rows();
    build();
  }
  begin();
  front_ = now_.t, root_ = false, cut_ = false, has_past_ = false, hidden_here_ = {}, failure_ = nullptr;
  walking_ = false, beside_singular_ = partition_.near_singular();
}

void Adaptive::read_consistent(double t) {
  read(t);
  now_.t = t;
  follows_partition() ? partition_.evaluate(now_) : partition_.evaluate_nearest(now_);
}

void Adaptive::pass_event() {
  read_consistent(front_);
  if (hidden_here_) {
    std::fill(directions_.begin(), directions_.end(), 0);
    directions_[*hidden_here_] = -1;
  } else {
    root_directions(directions_);
  }
  // The side is kept here, so that a zero which rounding shows twice after a restart counts once.
  keep_end();
  for (std::size_t i = 0; i < directions_.size(); ++i)
    if (directions_[i] * switches_.side(i) < 0) take_event(i);
  restart();
  keep_begin();
}

// At the state that now_ is.
void Adaptive::sample_gaps(GapSample& out) {
  out.t = now_.t, out.gaps.resize(switches_.count()), out.speeds.resize(switches_.count());
  system_.set_state(now_.t, now_.q, now_.velocity);
  switches_.gaps(out.gaps);
  switches_.gap_speeds(out.speeds);
}

// When a contact has closed and opened again in the step from `begin` to front_, puts front_ where it closed.
void Adaptive::stop_at_hidden_contact(double begin) {
  next_ = now_, walk_flows_ = flows_.of_elements;
  const auto look = [&](GapSample& sample) {
    read_consistent(sample.t);
    sample_gaps(sample);
  };
  if (step_end_.t != begin || step_end_.gaps.empty()) step_end_.t = begin, look(step_end_);
  std::swap(step_begin_, step_end_);
  read(front_);  // at the end of a step no projection is needed to say how wide gaps are
  now_.t = front_;
  sample_gaps(step_end_);
  const auto found = find_hidden_contact(switches_, system_.length_scale(), step_begin_, step_end_, look);
  if (found) {
    const auto at = [&](double share) { return found->open + share * (found->closed - found->open); };
    const auto gap = [&](double share) {
      GapSample sample{.t = at(share)};
      look(sample);
      return sample.gaps[found->which];
    };
    front_ = at(locate_crossing(gap, 1, gap(0), gap(1)));
    hidden_here_ = found->which, root_ = true;
  }
  now_ = next_, flows_.of_elements = walk_flows_;
}

// When an event of a joint has come and gone in the step from `begin` to front_, puts front_ where it came.
void Adaptive::stop_at_hidden_event(double begin) {
  const double h = front_ - begin;
  next_ = now_, walk_flows_ = flows_.of_elements;
  const auto look_at = [&](double t, std::vector<double>& out) {
    read_consistent(t);
    look(now_, out);
  };
  std::array<TimedValue, event_looks.size()> samples;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].t = begin + event_looks[k] * h;
    look_at(samples[k].t, event_gaps_[k]);
  }
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_joint(i) || switches_.side(i) < 0) continue;
    for (std::size_t k = 0; k < samples.size(); ++k) samples[k].value = event_gaps_[k][i];
    const auto gap = [&](double t) {
      look_at(t, gaps_);
      return gaps_[i];
    };
    // One that is at its value where the method begins has no root there, and passes it all the same.
    const double clear = system_.model().events[switches_.event(i)].element.hysteresis();
    if (!root_ && std::abs(samples.front().value) <= clear && samples.back().value < -clear)
      front_ = begin, hidden_here_ = i, root_ = true;
    const auto found = find_hidden_dip(samples, gap);
    if (!found) continue;
    const auto at = [&](double share) { return found->above + share * (found->below - found->above); };
    const auto gap_at = [&](double share) { return gap(at(share)); };
    const double passed = at(locate_crossing(gap_at, 1, gap_at(0), gap_at(1)));
    if (passed < front_) front_ = passed, hidden_here_ = i, root_ = true;
  }
  now_ = next_, flows_.of_elements = walk_flows_;
}

void Adaptive::on_advance(double h) {
  const double end = clock_.end_of_step(now_.t, h);
  if (wrench_changes_ != system_.wrench_changes()) {
    coupled_ = true;
    restart();
  }
  const double stop = coupled_ ? end : std::numeric_limits<double>::infinity();
  double looked_at = front_;
  for (long taken = 0; front_ < end; ++taken) {
    if (crossing_) leave_crossing();
    if (taken == most_steps) give_up(taken, end);
    if (taken > 0 && taken % looked_back_on == 0) {
      const double steps_needed = (end - front_) / (front_ - looked_at) * looked_back_on;
      if (!(steps_needed < 10.0 * most_steps)) give_up(taken, end);
      looked_at = front_;
    }
    if (beside_singular_) {
      walk(end);
    } else if (walking_) {
      restart();
    } else if (root_) {
      pass_event();
    } else if (cut_) {
      read_consistent(front_);
      restart();
    } else {
      step_on(end, stop);
    }
  }
  if (crossing_) read_crossing(end);
  if (walking_) return;
  if (now_.t != end) read_consistent(end);
  bool anew = has_drifted();
  if (partition_.choose_again_if_needed(now_)) {
    partition_.evaluate(now_);
    anew = anew || follows_partition();
  }
  if (anew || partition_.used_rows() != rows_) restart();
}

void Adaptive::give_up(long taken, double end) {
  char text[160];
  std::snprintf(text, sizeof text, "t = %.9g s: %ld steps did not reach %.9g s, the last is of %.2g s; ", front_, taken,
                end, last_step_);
  std::string why = "the system is stiff, its forces are not smooth or a given motion jumps: take " +
                    std::string(follows_partition() ? "ida" : "adams-moulton with a step") + ", or a wider tolerance";
  try {
    if (failure_) std::rethrow_exception(failure_);
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  if (now_.t != front_) read_consistent(front_);
  throw std::runtime_error(text + why + standing_out(system_, partition_, now_));
}

// Returns false where the step failed and the method is to begin anew there, or a singular pose is near enough to be
// the reason. What a method extrapolates from its past may be a guess from which its iteration does not converge: there
// is no other reason to stop where it fails without a past too.
bool Adaptive::try_step(double end, double stop, Reached& reached) {
  try {
    reached = take_step(end, stop);
    has_past_ = true;
    return true;
  } catch (const std::runtime_error& error) {
    if (now_.t != front_) read_consistent(front_);
    const bool near = partition_.distance_from_singular() <= other_reason;
    if (!near && !has_past_) throw std::runtime_error(error.what() + standing_out(system_, partition_, now_));
    near ? beside_singular_ = true : cut_ = true;
    return false;
  }
}

void Adaptive::step_on(double end, double stop) {
  Reached reached;
  const double asked = stop, planned = inputs_.any() || profiles_.any() ? planned_step(end) : 0;
  const auto stop_at = [&](double resolved) {
    if (std::isinf(stop) || resolved < stop - 1e-9 * (stop - front_)) stop = resolved;
  };
  if (inputs_.any()) stop_at(inputs_.stop(front_, planned));
  if (profiles_.any()) {
    if (now_.t != front_) read_consistent(front_);
    stop_at(profiles_.stop(now_, planned));
  }
  if (!try_step(end, stop, reached)) return;
  // A step that ended at a stop may have been longer: intervals between stops that follow it must not shrink for ever.
  const double taken = reached.t - front_;
  last_step_ = reached.t < stop ? taken : 4 * taken;
  cut_ = stop < asked && reached.t == stop && taken < 0.5 * std::min(planned, Inputs::window);
  energy_range_.see(system_);  // as it was evaluated last, in this step
  const double begin = std::exchange(front_, reached.t);
  root_ = reached.root;
  if (watches_switches() && switches_.has_gaps()) stop_at_hidden_contact(begin);
  if (watches_switches() && system_.has_joint_events()) stop_at_hidden_event(begin);
  if (remembers_) {  // what ground is struck by, and how deep, is seen with the method's own steps
    read_consistent(front_);
    system_.commit();
  }
  if (root_) return;
  if (keeps() && front_ <= end) {
    read_consistent(front_);
    keep_end(), keep_begin(false);
  }
  if (!follows_partition()) {
    read_consistent(front_);
  } else if (front_ < end && partition_.asks_for_choice()) {
    read_consistent(front_);
    if (partition_.choose_again_if_needed(now_)) return restart();
  }
  beside_singular_ = partition_.near_singular() || creeps(taken);
}

// Whether ida takes steps beside a singular pose in which hardly anything moves: its Newton iteration then fails
// however short they are, and does not say so.
bool Adaptive::creeps(double taken) const {
  if (follows_partition() || !(partition_.distance_from_singular() < far_enough)) return false;
  return taken * rate_of(now_) < least_motion;
}

// rad/s, lengths as shares of the machine's.
double Adaptive::rate_of(const MotionState& m) const {
  return m.velocity.cwiseProduct(coordinate_scale(system_)).cwiseAbs().maxCoeff() / system_.length_scale();
}

// One step past a singular pose, or to what comes first: the end asked for, an event.
void Adaptive::walk(double end) {
  if (now_.t != front_) read_consistent(front_);
  if (!walking_) begin_walk();
  if (cross(end)) return;
  const double h = std::min(walk_step_, end - now_.t);
  if (!try_walk(h, end)) return;
  walk_failures_ = 0;
  const std::size_t event = stop_at_event(h);
  partition_.refuse_other_branch(next_);
  std::swap(now_, next_);
  flows_.of_elements = walk_flows_;
  if (end - now_.t <= 1e-12 * h) now_.t = end;
  energy_range_.see(system_);
  front_ = now_.t, last_step_ = walk_step_;
  const bool passed = event < switches_.count();
  if (passed) take_event(event);
  // On the singular pose itself there is nothing to choose, and nothing to evaluate.
  if (!landed_ && (partition_.choose_again_if_needed(now_) || passed)) partition_.evaluate_nearest(now_);
  const double distance = partition_.distance_from_singular();
  approach_ = distance_ > 0 ? (distance_ - distance) / h : 0;
  distance_ = distance;
  beside_singular_ = distance < far_enough;
}

// One step from this side of the singular pose to as far behind it; false where that is not due, or not good enough.
bool Adaptive::cross(double end) {
  if (!may_cross_ || landed_ || !(distance_ > 0) || !(distance_ < step_over) || !(approach_ > 0)) return false;
  const double h = 2 * distance_ / approach_;
  if (coupled_ && h > end - now_.t) return false;  // the future is not known
  may_cross_ = false;
  walk_flows_ = flows_.of_elements;
  try {
    walker_.step(now_, h, next_, walk_flows_);
    partition_.refuse_other_branch(next_);
  } catch (const std::runtime_error&) {
    partition_.evaluate_nearest(now_);
    return false;
  }
  if (walker_.error() > most_of_crossing || stop_at_event(h) < switches_.count()) {
    partition_.evaluate_nearest(now_);
    return false;
  }
  crossing_ = true;
  before_crossing_ = now_, after_crossing_ = next_;
  flows_before_ = flows_.of_elements, flows_after_ = walk_flows_;
  front_ = after_crossing_.t;
  distance_ = partition_.distance_from_singular(), approach_ = 0;
  return true;
}

void Adaptive::leave_crossing() {
  crossing_ = false;
  now_ = after_crossing_;
  flows_.of_elements = flows_after_;
  partition_.evaluate_nearest(now_);
  if (partition_.choose_again_if_needed(now_)) partition_.evaluate_nearest(now_);
}

void Adaptive::read_crossing(double t) {
  interpolate(before_crossing_, after_crossing_, t, now_);
  interpolate_flows(before_crossing_, after_crossing_, flows_before_, flows_after_, t, flows_.of_elements);
  next_ = now_;
  try {  // reactions grow as one over the distance and lie on no line
    partition_.evaluate_nearest(next_);
    if (partition_.distance_from_singular() > Partition::known_reactions) now_.lambda = next_.lambda;
  } catch (const SingularPose&) {
  }
  system_.set_state(t, now_.q, now_.velocity);
  system_.set_multipliers(now_.lambda);
  system_.set_element_states(now_.states);
  Eigen::VectorXd loads(now_.q.size());
  system_.loads(loads);  // for what forces report
}

void Adaptive::begin_walk() {
  walking_ = true, walk_controlled_ = true, walk_failures_ = 0;
  distance_ = approach_ = 0, may_cross_ = true, crossing_ = false;
  const double slowness = 1 / std::max(rate_of(now_), 1.0);
  walk_step_ = slowness * std::pow(step_tolerance(), 0.2), landing_step_ = slowness * std::pow(step_tolerance(), 0.25);
}

// Returns whether next_ may stand; else the step has been made shorter. Near the pose rounding is more than what the
// estimate of the error means to see: there the step stays what it was.
bool Adaptive::try_walk(double h, double end) {
  const bool core = partition_.distance_from_singular() < 0.01;  // of now_
  walk_flows_ = flows_.of_elements;
  const bool from_singular = std::exchange(landed_, false);
  const auto shorten = [&](double factor) {
    walk_step_ = factor * h, landed_ = from_singular;
    if (!from_singular) partition_.evaluate_nearest(now_);
    return false;
  };
  try {
    walker_.step(now_, h, next_, walk_flows_);
  } catch (const SingularPose&) {  // a stage has met it: those of another step do not, unless it is the end asked for
    if (++walk_failures_ > most_failures_of_a_step) throw;
    if (h > landing_step_ || end - now_.t > (1 + 1e-12) * h) return shorten(0.8);
    walk_flows_ = flows_.of_elements;
    walker_.step_onto_singular(now_, h, next_, walk_flows_);
    return landed_ = true;
  }
  if (core && !walk_controlled_) return true;
  // Rounding leaves its share of the accelerations in a step, however short.
  const double distance = partition_.distance_from_singular(), rounding = 1e-15 * h / (distance * distance * distance);
  const double allowed = std::max(step_tolerance(), rounding);
  const double change = 0.9 * std::pow(allowed / std::max(walker_.error(), 1e-30), 0.2);
  if (change < 0.9 && ++walk_failures_ <= (core ? 3 : most_failures_of_a_step)) return shorten(std::max(change, 0.2));
  walk_controlled_ = false;
  if (h >= walk_step_) walk_step_ *= std::clamp(change, 0.2, 2.0);
  return true;
}

// When a switch has changed sides over the step to next_, puts next_ at the first zero; returns which, or their count.
std::size_t Adaptive::stop_at_event(double h) {
  if (!watches_switches()) return switches_.count();
  const auto go = [&](double share) {
    walk_flows_ = flows_.of_elements;
    walker_.step(now_, share * h, next_, walk_flows_);
    look(next_, gaps_);
  };
  look(now_, gaps_before_);
  look(next_, gaps_);
  const std::vector<double> at_end = gaps_;
  std::size_t first = switches_.count();
  double share = 2;
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (at_end[i] * switches_.side(i) >= 0) continue;
    const auto gap = [&](double part) {
      go(part);
      return gaps_[i];
    };
    const double at = locate_crossing(gap, switches_.side(i), gaps_before_[i], at_end[i]);
    if (at < share) share = at, first = i;
  }
  if (first < switches_.count()) go(share);
  return first;
}

}  // namespace subsoil::mbd
