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
constexpr long counted_steps = 20'000;
// From a singular configuration, in rad: farther away the failure of a method has another reason. A step over one ends
// up to 0.55 behind it, where the method restarts.
constexpr double other_reason = 0.6;
// From where the approach to a singular configuration is looked at, and from where a step may lead behind one.
constexpr double sight = 0.6, leap = 0.95;
// Nearer than this no step of the method ends before one: rounding in a step over it falls as the cube of its length.
constexpr double far_side = 0.3;
// Pivots that have fallen by this: the choice of coordinates may be what is near its end.
constexpr double worn_choice = 3;
// Of steps where the ground remembers what it is pressed by (s).
constexpr double ground_interval = 1e-3;
// Motion in a step (rad) that is none; the first one of ida is of some 1e-5.
constexpr double least_motion = 1e-8;
// A step so short beside the longest since the start has collapsed.
constexpr double collapse = 1e-4;
// Instants that ought to be one differ by rounding: no step is that short (s).
double same_instant(double t) { return 1e-12 * std::max(1.0, std::abs(t)); }
// Of a state at which a method gave up: the body most accelerated, the constraint nearest to losing its rank.
std::string standing_out(const System& system, const Partition& partition, const MotionState& m) {
  Eigen::Index most = 0;
  const double largest = m.acceleration.cwiseProduct(coordinate_scale(system)).cwiseAbs().maxCoeff(&most);
  char text[200];
  std::snprintf(text, sizeof text, "; at t = %.9g s body '%.60s' is the most accelerated, %.2e m/s^2", m.t,
                system.body_name(static_cast<int>(most / 3) + 1).c_str(), largest);
  std::string all = text;
  const double distance = partition.distance_from_singular();
  if (distance > other_reason) return all;
  std::snprintf(text, sizeof text, ", and %.80s is some %.2g rad from a singular configuration",
                partition.singular_owner().c_str(), distance);
  return all + text;
}

/// The same fault with more text behind it.
[[noreturn]] void rethrow_with(const std::runtime_error& error, const std::string& more) {
  if (const auto* fault = dynamic_cast<const MotionFault*>(&error)) throw MotionFault(*fault, more);
  throw std::runtime_error(error.what() + more);
}

}  // namespace

Adaptive::Adaptive(System& system)
    : Integrator(system),
      inputs_(system.model()),
      profiles_(system),
      directions_(switches_.count(), 0),
      passage_(system, partition_),
      next_(now_),
      gaps_(switches_.count(), 0),
      gaps_before_(gaps_) {
  for (std::size_t i = 0; i < switches_.count(); ++i) has_friction_ = has_friction_ || switches_.of_friction(i);
}

void Adaptive::on_start() {
  clock_.restart();
  remembers_ = remembers(system_.model());
  coupled_ = std::any_of(system_.external_wrenches().begin(), system_.external_wrenches().end(),
                         [](const auto& wrench) { return wrench != std::array<double, 3>{}; });
  rows_ = partition_.used_rows();
  output_ = now_.t, commits_ = false, jumps_ = true, longest_step_ = 0;
  build();
  restart();
}

void Adaptive::restart() {
  wrench_changes_ = system_.wrench_changes();
  const double at = now_.t;
  if (follows_partition()) now_.t = inputs_.inside(at, at).time(at);
  partition_.evaluate(now_), elsewhere_ = false;
  now_.t = at;
  if (watches_switches()) fire_due(), pass_contacts_at_zero(), release_friction();  // what begins beyond has no root
  if (partition_.used_rows() != rows_) {  // redundant constraints: others carry the multipliers now
    rows_ = partition_.used_rows();
    build();
  }
  begin();
  note_distance();
  front_ = now_.t, first_ = First::nothing, has_past_ = false, failure_ = nullptr;
  hidden_here_ = {}, event_of_passage_ = {}, slip_end_.t = std::numeric_limits<double>::quiet_NaN();
  passage_.leave();
  if (partition_.near_singular()) passage_.enter();
}

// External wrenches have changed: the motion continues from the output, since what was reached beyond is another one.
void Adaptive::meet_jump() {
  coupled_ = true;
  dense_.segments.clear();
  if (shows()) now_ = state(), flows_ = flows(), front_ = output_;
  hide();
  need_state();
  jumps_ = true;
  restart();
}

void Adaptive::move(double h) {
  const double end = clock_.end_of_step(output_, h, asked_end_);
  if (system_.has_instants()) system_.forget_outputs_before();
  if (wrench_changes_ != system_.wrench_changes()) meet_jump();
  std::erase_if(dense_.segments, [&](const StepSegment& p) { return p.end.t <= output_; });
  q_before_ = now_.q;
  double before = front_;
  for (long taken = 0;;) {
    if (act_at_instant(end)) continue;
    if (!(front_ < end) || (coupled_ && end - front_ <= same_instant(end))) break;
    if (taken == most_steps) give_up(taken, end);
    if (taken > 0 && taken % counted_steps == 0) {
      const double steps_needed = (end - front_) / (front_ - before) * counted_steps;
      if (!(steps_needed < 10.0 * most_steps)) give_up(taken, end);
      before = front_;
    }
    double stop = std::min(coupled_ ? end : std::numeric_limits<double>::infinity(), system_.next_instant());
    if (remembers_) stop = std::min(stop, ground_interval * (std::floor(front_ / ground_interval + 1e-6) + 1));
    const double begin = front_;
    const bool beside = !passage_.away();
    const std::shared_ptr<const Choice> choice = partition_.choice();  // the step's, which the next one may change
    acted_ = false;
    next_step(stop);
    ++taken;
    if (front_ > begin && (keeps() || front_ >= end)) keep_segment(begin, beside, choice);
  }
  output_ = end;
  if (!coupled_) keep_memory();
  // At an instant at which something has acted the state is the one behind it.
  const bool behind = acted_ && std::abs(front_ - end) <= same_instant(end);
  if (behind && !coupled_) return hide();
  if (!coupled_) return show(end);
  need_state();
  now_.t = front_ = end;
  commit();
  if (first_ == First::restart) restart();
  system_.set_state(now_.t, now_.q, now_.velocity);
  flows_.external_work += system_.external_work(q_before_, now_.q);
  if (keeps()) keep_memory();
}

// Sampled controllers and timed events act at the instant that has been reached, when the end lies not before it.
bool Adaptive::act_at_instant(double end) {
  if (!system_.has_instants()) return false;
  const double next = system_.next_instant(), close = same_instant(end);
  if (next > std::min(front_, end) + close) return false;
  need_state();
  system_.set_state(now_.t, now_.q, now_.velocity);
  system_.set_element_states(now_.states);
  const long changes = system_.wrench_changes();
  act(close);
  bool jumped = changes != system_.wrench_changes();
  if (jumped) partition_.accelerate(now_);
  for (std::size_t due; (due = system_.due_event(close)) < system_.model().events.size(); jumped = true) fire(due);
  if (system_.has_joint_events() && changes_seen_ != system_.wrench_changes()) {
    partition_.accelerate(now_);
    jumped = fire_due() || jumped;
  }
  jumps_ = acted_ = true;
  if (!jumped) return true;
  rows_ = partition_.used_rows();
  build();
  restart();
  return true;
}

// The state at front_ is accepted: the ground takes its ruts. Not before the next step, since what is read between the
// ends of the one before belongs to the ground as it was.
void Adaptive::commit() {
  if (!std::exchange(commits_, false)) return;
  need_state();
  system_.set_state(now_.t, now_.q, now_.velocity);
  if (system_.commit(flows_.of_elements) && first_ != First::event) first_ = First::restart, jumps_ = true;
}

void Adaptive::keep_segment(double begin, bool beside, const std::shared_ptr<const Choice>& choice) {
  if (!keeps()) dense_.segments.clear();
  StepSegment segment = begin_segment(std::exchange(jumps_, false));
  segment.begin.t = begin;
  segment.choice = choice;
  segment.nearest = beside;
  if (beside)
    segment.polynomial = passage_.polynomial();
  else
    dense(front_, segment);
  segment.end.t = front_;
  dense_.segments.push_back(std::move(segment));
}

void Adaptive::read_consistent(double t) {
  read(t);
  now_.t = t, elsewhere_ = false;
  follows_partition() ? partition_.evaluate(now_) : partition_.evaluate_nearest(now_);
}

// now_ is the state at front_.
void Adaptive::need_state() {
  if (now_.t != front_ || elsewhere_) read_consistent(front_);
}

void Adaptive::pass_event() {
  if (event_of_passage_) return pass_event_of_passage();
  need_state();
  if (hidden_here_) {
    std::fill(directions_.begin(), directions_.end(), 0);
    directions_[*hidden_here_] = -1;
  } else {
    root_directions(directions_);
  }
  // The side is kept here, so that a zero which rounding shows twice after a restart counts once.
  for (std::size_t i = 0; i < directions_.size(); ++i)
    if (directions_[i] * switches_.side(i) < 0) take_event(i);
  jumps_ = true;
  restart();
}

// now_ is what it was before samples within the step were looked at; forces and reactions are still those of the last.
void Adaptive::return_from_samples() { now_ = next_, flows_.of_elements = next_flows_, elsewhere_ = true; }

// At the state that now_ is.
void Adaptive::sample_gaps(GapSample& out) {
  out.t = now_.t, out.gaps.resize(switches_.count()), out.speeds.resize(switches_.count());
  system_.set_state(now_.t, now_.q, now_.velocity);
  switches_.gaps(out.gaps);
  switches_.gap_speeds(out.speeds);
}

// When a contact has closed and opened again in the step from `begin` to front_, puts front_ where it closed first.
void Adaptive::stop_at_hidden_contact(double begin) {
  next_ = now_, next_flows_ = flows_.of_elements;
  const auto look = [&](GapSample& sample) {
    read_consistent(sample.t);
    sample_gaps(sample);
  };
  if (step_end_.t != begin || step_end_.gaps.empty()) step_end_.t = begin, look(step_end_);
  std::swap(step_begin_, step_end_);
  read(front_);  // at the end of a step no projection is needed to say how wide gaps are
  now_.t = front_;
  sample_gaps(step_end_);
  const double length = system_.length_scale();
  const WaysOfPieces ways{1e-4 * length, 1e-9 * length + 1e-12 * now_.q.cwiseAbs().maxCoeff()};
  for (GapSample end = step_end_;;) {
    // One that closes at the end is open until there: a root's far side is negative by rounding.
    for (std::size_t i = 0; i < end.gaps.size(); ++i)
      if (switches_.side(i) > 0) end.gaps[i] = std::max(end.gaps[i], 0.0);
    const auto found = find_hidden_contact(switches_, ways, step_begin_, end, look);
    if (!found) break;
    const auto at = [&](double share) { return found->open + share * (found->closed - found->open); };
    const auto gap = [&](double share) {
      GapSample sample{.t = at(share)};
      look(sample);
      return sample.gaps[found->which];
    };
    front_ = at(locate_crossing(gap, 1, gap(0), gap(1)));
    hidden_here_ = found->which, first_ = First::event;
    end.t = front_, look(end);  // before it may be others
  }
  return_from_samples();
}

// The switching functions at instants of the step from `begin` to front_, in event_gaps_.
void Adaptive::sample_step(double begin) {
  const double h = front_ - begin;
  read_consistent(begin);
  q_sample_ = now_.q;
  read_consistent(begin + h);
  samples_.clear();
  for (const double t : event_times(begin, h, largest_turn(q_sample_, now_.q))) samples_.push_back({t, 0});
  event_gaps_.assign(samples_.size(), gaps_);
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    read_consistent(samples_[k].t);
    look(now_, event_gaps_[k]);
  }
}

// When a switching function has passed 0 and come back between the samples of a step, puts front_ where it passed.
void Adaptive::stop_at_dip(std::size_t which) {
  for (std::size_t k = 0; k < samples_.size(); ++k) samples_[k].value = event_gaps_[k][which];
  const auto gap = [&](double t) {
    read_consistent(t);
    look(now_, gaps_);
    return gaps_[which];
  };
  const auto found = find_hidden_dip(samples_, gap);
  if (!found) return;
  const auto at = [&](double share) { return found->above + share * (found->below - found->above); };
  const auto gap_at = [&](double share) { return gap(at(share)); };
  const double passed = at(locate_crossing(gap_at, 1, gap_at(0), gap_at(1)));
  if (passed < front_) front_ = passed, hidden_here_ = which, first_ = First::event;
}

// When an event of a joint has come and gone in the step from `begin` to front_, puts front_ where it came.
void Adaptive::stop_at_hidden_event(double begin) {
  next_ = now_, next_flows_ = flows_.of_elements;
  sample_step(begin);
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_joint(i) || switches_.side(i) < 0) continue;
    // One that is at its value where the method begins has no root there, and passes it all the same.
    const double clear = system_.model().events[switches_.event(i)].element.hysteresis();
    if (first_ != First::event && std::abs(event_gaps_.front()[i]) <= clear && event_gaps_.back()[i] < -clear)
      front_ = begin, hidden_here_ = i, first_ = First::event;
    stop_at_dip(i);
  }
  return_from_samples();
}

// When friction that sticks has been beyond its limit in the step from `begin` to front_, or is there still, puts
// front_ where it has reached it; the same for surfaces that have come to rest and slide again.
void Adaptive::stop_at_hidden_slip(double begin, bool root) {
  next_ = now_, next_flows_ = flows_.of_elements;
  if ((root || !stop_at_slip_of_end(begin)) && may_have_slipped(begin, root)) {
    for (double end = 0; end != front_;) {  // before the one found may be others
      end = front_;
      sample_step(begin);
      for (std::size_t i = 0; i < switches_.count(); ++i)
        if (switches_.of_friction(i)) stop_at_dip(i);
    }
  }
  return_from_samples();
}

// A root function that is 0 where the method begins has no root for it until it has left 0.
bool Adaptive::stop_at_slip_of_end(double begin) {
  constexpr double soonest = 1e-3;  // of the step: the strain by then shows the sense in which it slides
  const std::vector<double>& at_end = end_values();
  const double h = front_ - begin;
  bool found = false;
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_friction(i) || !(at_end[i] < 0)) continue;
    const auto margin = [&](double share) {
      read_consistent(begin + share * h);
      look(now_, gaps_);
      return gaps_[i];
    };
    const double passed = begin + std::max(soonest, locate_crossing(margin, 1, margin(0), at_end[i])) * h;
    if (passed < front_ || !found) front_ = passed, hidden_here_ = i, first_ = First::event;
    found = true;
  }
  return found;
}

// What presses surfaces at rest may change without moving anything, and no error test shortens a step to that. So the
// margins are looked at between the ends too: their rates at both show a minimum between, and a sample in the middle
// one that rates miss.
bool Adaptive::may_have_slipped(double begin, bool root) {
  constexpr double far = 0.5;  // rad, of half a step: beyond, forces that turn with a body may come and go unseen
  const double end = front_, h = end - begin, beside = 1e-3 * h;
  const auto look_at = [&](double t, std::vector<double>& out) {
    read(t);
    now_.t = t;
    follows_partition() ? partition_.evaluate(now_) : partition_.accelerate_as_it_is(now_);
    look(now_, out);
  };
  std::swap(slip_begin_, slip_end_);
  Margins &from = slip_begin_, &to = slip_end_;
  for (Margins* m : {&from, &to}) m->at.resize(switches_.count()), m->rates.resize(switches_.count());
  if (from.t != begin) {
    look_at(begin, from.at), look_at(begin + beside, from.rates);
    for (std::size_t i = 0; i < switches_.count(); ++i) from.rates[i] = (from.rates[i] - from.at[i]) / beside;
  }
  if (root)
    look_at(end, to.at);
  else
    to.at = end_values();
  look_at(end - beside, to.rates);
  q_sample_ = now_.q;
  look_at(begin + 0.5 * h, gaps_);
  to.t = end;
  bool may = largest_turn(q_sample_, now_.q) > far;
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_friction(i)) continue;
    const double near = to.rates[i];
    to.rates[i] = (to.at[i] - near) / beside;
    may = may || may_dip(std::array<TimedValue, 5>{{{begin, from.at[i]},
                                                    {begin + beside, from.at[i] + beside * from.rates[i]},
                                                    {begin + 0.5 * h, gaps_[i]},
                                                    {end - beside, near},
                                                    {end, to.at[i]}}});
  }
  return may;
}

void Adaptive::give_up(long taken, double end) {
  need_state();
  refuse_blow_up(system_, now_);  // beyond all bounds within finite time: steps vanish there
  char text[160];
  std::snprintf(text, sizeof text, "%ld steps did not reach %.9g s, the last is of %.2g s; ", taken, end, last_step_);
  MotionFault::Cause cause = MotionFault::Cause::other;
  std::string why = "the system is stiff, its forces are not smooth or a given motion jumps: take " +
                    std::string(follows_partition() ? "ida" : "cvode") + ", or a wider tolerance";
  try {
    if (failure_) std::rethrow_exception(failure_);
  } catch (const MotionFault& fault) {
    why = fault.what(), cause = fault.cause;
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  throw MotionFault(front_, text + why + standing_out(system_, partition_, now_), cause);
}

// Returns false where the step failed and the method is to begin without its past, or a singular configuration is near
// enough to be the reason. What a method extrapolates from its past may be a guess from which its iteration does not
// converge: there is no other reason to stop where it fails without a past too.
bool Adaptive::try_step(double stop, Reached& reached) {
  try {
    reached = take_step(stop, inputs_.inside(front_, stop));
    has_past_ = true;
    return true;
  } catch (const std::runtime_error& error) {
    need_state();
    const bool near = partition_.distance_from_singular() <= other_reason;
    if (!near && !has_past_) rethrow_with(error, standing_out(system_, partition_, now_));
    if (near)
      passage_.enter();
    else
      first_ = First::restart;
    return false;
  }
}

// One step of the method, or past a singular configuration; or what comes before it.
void Adaptive::next_step(double stop) {
  commit();
  if (first_ == First::event) return pass_event();
  if (first_ == First::restart) {
    need_state();
    return restart();
  }
  passage_.away() ? method_step(stop) : passage_step(stop);
}

double Adaptive::resolved_stop(double stop, double planned) {
  const auto stop_at = [&](double resolved) {
    if (std::isinf(stop) || resolved < stop - 1e-9 * (stop - front_)) stop = resolved;
  };
  if (inputs_.any()) stop_at(inputs_.stop(front_, planned));
  if (watches_switches()) stop_at(inputs_.next_turn(front_));
  if (profiles_.any()) {
    need_state();
    stop_at(profiles_.stop(now_, planned));
  }
  return stop;
}

// Whether the root that was found opens a contact.
bool Adaptive::opens_contact() {
  root_directions(directions_);
  for (std::size_t i = 0; i < switches_.count(); ++i)
    if (switches_.of_gap(i) && switches_.side(i) < 0 && directions_[i] > 0) return true;
  return false;
}

void Adaptive::method_step(double asked) {
  Reached reached;
  const bool first_of_method = !has_past_;
  asked = std::min(asked, std::exchange(first_until_, std::numeric_limits<double>::infinity()));
  const double planned = inputs_.any() || profiles_.any() ? planned_step() : 0;
  const double stop = resolved_stop(asked, planned);
  if (!try_step(stop, reached)) return;
  // A contact that was touched at the begin and is left in the first step: with no force at either end, no error test
  // has seen what was between.
  if (first_of_method && reached.root && opens_contact()) {
    constexpr double share = 0.125;  // of the contact
    first_until_ = front_ + share * (reached.t - front_), first_ = First::restart;
    return;
  }
  // A step that ended at a stop may have been longer: intervals between stops that follow it must not shrink for ever.
  const double taken = reached.t - front_;
  last_step_ = reached.t < stop ? taken : 4 * taken;
  longest_step_ = std::max(longest_step_, last_step_);
  const bool cut = stop < asked && reached.t == stop && taken < 0.5 * std::min(planned, Inputs::window);
  energy_range_.see(system_);  // as it was evaluated last, in this step
  const double begin = std::exchange(front_, reached.t);
  if (meets_singular()) {
    front_ = begin, first_ = First::nothing;
    read_consistent(begin);
    return passage_.enter();
  }
  commits_ = remembers_;
  // What solves for positions takes no rates from its past, and short steps harm it more than a jump of them.
  const bool corner = follows_partition() && reached.t == stop && inputs_.is_corner(stop);
  if (cut || corner) first_ = First::restart;
  if (reached.root) first_ = First::event;
  if (watches_switches() && has_friction_) stop_at_hidden_slip(begin, reached.root);
  if (watches_switches() && switches_.has_gaps()) stop_at_hidden_contact(begin);
  if (watches_switches() && system_.has_joint_events()) stop_at_hidden_event(begin);
  if (first_ == First::nothing) settle_step(taken);
}

// What the method does next, from where its step has ended.
void Adaptive::settle_step(double taken) {
  if (wants_restart()) first_ = First::restart;
  if (!follows_partition() || partition_.asks_for_choice()) {
    need_state();
    const bool changed = partition_.choose_again_if_needed(now_);
    if (changed) partition_.evaluate(now_), note_distance();
    if ((changed && follows_partition()) || has_drifted() || partition_.used_rows() != rows_) first_ = First::restart;
  }
  if (!creeps(taken) &&
      !(at_end_.distance < sight && passage_.in_sight((at_begin_.distance - at_end_.distance) / taken)))
    return;
  passage_.enter();
  first_ = First::nothing;
}

void Adaptive::note_distance() { at_end_ = {partition_.distance_from_singular(), partition_.orientation()}; }

// Whether the step has ended beside a singular configuration or behind one. It is not taken: what it knows of the
// constraints there is rounding, or another branch.
bool Adaptive::meets_singular() {
  if (!follows_partition()) read_consistent(front_);
  at_begin_ = at_end_;
  note_distance();
  const auto beside = [&] {
    return partition_.near_singular() || (at_end_.distance < far_side && at_end_.distance < at_begin_.distance);
  };
  if (at_end_.orientation != at_begin_.orientation && at_begin_.distance < leap) return true;
  if (!beside()) return false;
  if (partition_.sensitivity() < worn_choice) return true;
  const std::shared_ptr<const Choice> choice = partition_.choice();
  try {
    read_consistent(front_);
    partition_.choose(now_);
    partition_.evaluate(now_);
    note_distance();
    first_ = First::restart;
    if (!beside()) return false;
  } catch (const std::runtime_error&) {
  }
  partition_.adopt(choice);  // by which the step is read
  partition_.forget_factors();
  return true;
}

// Whether ida takes steps beside a singular configuration in which hardly anything moves: its Newton iteration then
// fails however short they are, and does not say so. Farther away a machine at rest, or one that begins to move, moves
// as little: there the step has to be short, beside the longest one and for a motion that would be seen in that one.
bool Adaptive::creeps(double taken) const {
  if (follows_partition()) return false;
  const double distance = partition_.distance_from_singular(), rate = passage_.rate();
  if (!(distance < other_reason && taken * rate < least_motion)) return false;
  return distance < SingularPassage::far_enough ||
         (last_step_ < collapse * longest_step_ && collapse * longest_step_ * rate > least_motion);
}

void Adaptive::passage_step(double stop) {
  need_state();
  if (inputs_.any()) stop = std::min(stop, inputs_.stop(front_, Inputs::window));
  // A step whose part up to an event does not converge is halved: it only just converged itself.
  constexpr int most_halvings = 10;
  double latest = stop, h = 0;
  std::size_t event = switches_.count();
  for (int halvings = 0;; ++halvings) {
    next_flows_ = flows_.of_elements;
    passage_.step(now_, latest, step_tolerance(), next_, next_flows_);
    h = next_.t - now_.t;
    try {
      event = stop_at_event(h);
      break;
    } catch (const MotionFault&) {
      if (halvings == most_halvings) throw;
      latest = now_.t + 0.5 * h;
    }
  }
  passage_.accept();
  std::swap(now_, next_);
  flows_.of_elements = next_flows_;
  flows_.of_elements.tail(now_.states.size()) = now_.states;
  if (stop - now_.t <= 1e-12 * h) now_.t = stop;
  energy_range_.see(system_);
  front_ = now_.t, last_step_ = h, commits_ = remembers_;
  // On the configuration itself there is nothing to choose, and nothing to evaluate.
  if (!passage_.landed() && partition_.choose_again_if_needed(now_)) partition_.evaluate_nearest(now_);
  if (passage_.away()) first_ = First::restart;
  // It acts with the next step: what is read within this one is of the time before.
  if (event < switches_.count()) event_of_passage_ = event, first_ = First::event;
}

// At the end of a step past a singular configuration, where now_ is.
void Adaptive::pass_event_of_passage() {
  const std::size_t event = *std::exchange(event_of_passage_, std::nullopt);
  take_event(event);
  jumps_ = true;
  if (switches_.of_joint(event)) return restart();  // other constraints, which may be singular elsewhere
  if (!passage_.landed()) partition_.choose_again_if_needed(now_), partition_.evaluate_nearest(now_);
  first_ = passage_.away() ? First::restart : First::nothing;
}

// When a switch has changed sides over the step to next_, puts next_ at the first zero; returns which, or their count.
std::size_t Adaptive::stop_at_event(double h) {
  if (!watches_switches()) return switches_.count();
  const auto go = [&](double share) {
    next_flows_ = flows_.of_elements;
    passage_.repeat(now_, share * h, next_, next_flows_);
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
