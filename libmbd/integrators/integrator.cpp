#include "libmbd/integrators/integrator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/base/dense.hpp"
#include "libmbd/integrators/adams_moulton.hpp"
#include "libmbd/integrators/cvode.hpp"
#include "libmbd/integrators/ida.hpp"
#include "libmbd/integrators/kinematic.hpp"

namespace subsoil::mbd {

Integrator::Integrator(System& system) : system_(system), partition_(system), switches_(system) {
  const auto n = system.coordinates();
  now_.q.setZero(n), now_.velocity.setZero(n), now_.acceleration.setZero(n);
  now_.lambda.setZero(system.equations());
  now_.rates.setZero(system.rate_count());
  now_.states.setZero(static_cast<Eigen::Index>(system.state_count()));
  flows_.of_elements = now_.rates;
  q_before_ = now_.q;
  before_ = now_;
  flows_before_ = flows_;
  lost_at_once_ = flows_.of_elements;
  gaps_.assign(switches_.count(), 0);
  stuck_since_.assign(switches_.count(), std::numeric_limits<double>::quiet_NaN());
}

void Integrator::start(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  hide(), dense_ = {}, ++starts_;
  std::fill(stuck_since_.begin(), stuck_since_.end(), std::numeric_limits<double>::quiet_NaN());
  now_.t = t, now_.q = q, now_.velocity = velocity;
  flows_.of_elements.setZero(), lost_at_once_.setZero();
  flows_.external_work = flows_.latched = 0;
  system_.set_state(t, q, velocity);
  system_.restart_traces();
  system_.begin_joints();
  partition_.choose(now_);
  if (system_.state_count() > 0) begin_states();
  partition_.evaluate(now_);
  events_.clear();
  step_error_ = {};
  switches_.take_sides();
  await_passage();
  fire_due();
  begin_grips();
  on_start();
}

// Several that stick carry the load one after the other, each what those before it leave; those of an equilibrium carry
// what they do there.
void Integrator::begin_grips() {
  std::size_t frictions = 0;
  for (std::size_t i = 0; i < switches_.count(); ++i) frictions += switches_.of_friction(i);
  const int turns = frictions > 1 && !system_.keeps_grips() ? 20 : 1;
  for (int turn = 0; turn < turns; ++turn)
    for (std::size_t i = 0; i < switches_.count(); ++i)
      if (switches_.of_friction(i)) grip(switches_.force(i), switches_.place(i));
}

double Integrator::grip(std::size_t force, std::size_t place) {
  system_.set_state(now_.t, now_.q, now_.velocity);
  system_.set_element_states(now_.states);
  MotionState ahead;
  bool looks_ahead = false;
  const auto accelerate = [&]() -> const Eigen::VectorXd& {
    std::exchange(looks_ahead, false) ? partition_.evaluate(now_) : partition_.accelerate(now_);
    return now_.acceleration;
  };
  const auto look_ahead = [&](double dt) {
    ahead = now_, looks_ahead = true;
    ahead.t += dt, ahead.q += dt * (now_.velocity + 0.5 * dt * now_.acceleration);
    ahead.velocity += dt * now_.acceleration;
    try {
      partition_.evaluate(ahead);
      return true;
    } catch (const std::runtime_error&) {  // the end of its travel
      return false;
    }
  };
  return system_.grip(force, place, {accelerate, look_ahead});
}

// Of a place that begins to stick now, with those of its force that did so at this instant.
double Integrator::share_grips(std::size_t which) {
  // Fixed steps find one event after the other, of which the second may lie behind the first by what a root is known
  // to.
  const double same = 1e-9 * std::max(1.0, std::abs(now_.t));
  stuck_since_[which] = now_.t;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < switches_.count(); ++i)
    if (switches_.of_friction(i) && switches_.force(i) == switches_.force(which) &&
        std::abs(stuck_since_[i] - now_.t) <= same && system_.sense(switches_.force(i), switches_.place(i)) == 0)
      places.push_back(switches_.place(i));
  if (places.size() < 2) return 0;
  const auto accelerate = [&]() -> const Eigen::VectorXd& {
    partition_.accelerate(now_);
    return now_.acceleration;
  };
  return system_.share_grips(switches_.force(which), places, {accelerate, {}});
}

void Integrator::damp_grips() {
  system_.set_state(now_.t, now_.q, now_.velocity);
  system_.set_element_states(now_.states);
  const auto accelerate = [&]() -> const Eigen::VectorXd& {
    partition_.accelerate(now_);
    return now_.acceleration;
  };
  for (std::size_t i = 0; i < switches_.count(); ++i)
    if (switches_.of_friction(i)) system_.damp(switches_.force(i), switches_.place(i), {accelerate, {}});
}

void Integrator::release_friction() {
  look(now_, gaps_);
  const std::vector<double> margins = gaps_;
  for (std::size_t i = 0; i < switches_.count(); ++i)
    if (switches_.of_friction(i) && margins[i] == 0)
      flows_.of_elements[static_cast<Eigen::Index>(switches_.force(i))] -= grip(switches_.force(i), switches_.place(i));
  for (std::size_t turn = 0; turn < 2 * switches_.count(); ++turn) {
    look(now_, gaps_);
    std::size_t i = 0;
    while (i < switches_.count() && !(switches_.of_friction(i) && gaps_[i] < 0)) ++i;
    if (i == switches_.count()) break;
    take_event(i);
    partition_.accelerate(now_);
  }
}

void Integrator::pass_contacts_at_zero() {
  // Of the machine's length: roots of one instant lie this near each other; a gap that changes by more than rounding,
  // and by more than a small share of what moves, tells where it is led; and a way over which it has to.
  constexpr double near = 1e-10, visible = 1e-12, share = 1e-6, probe = 1e-8, farthest = 1e-3;
  constexpr int most_tenfold = 12;  // at rest nothing leads anywhere
  if (!switches_.has_gaps()) return;
  look(now_, gaps_);
  const double length = system_.length_scale();
  const std::vector<double> gaps = gaps_;
  std::vector<std::size_t> passed;
  const Eigen::VectorXd scale = coordinate_scale(system_);
  const auto size = [&](const Eigen::VectorXd& v) { return v.cwiseProduct(scale).cwiseAbs().maxCoeff() / length; };
  MotionState ahead = now_;
  // How gap i changes, over a way that grows until it does.
  const auto change = [&](std::size_t i) {
    double dt = std::min(probe / std::max(size(now_.velocity), 1e-12),
                         std::sqrt(2 * probe / std::max(size(now_.acceleration), 1e-12)));
    for (int longer = 0;; ++longer, dt *= 10) {
      const Eigen::VectorXd way = dt * (now_.velocity + 0.5 * dt * now_.acceleration);
      ahead.t = now_.t + dt, ahead.q = now_.q + way, ahead.velocity = now_.velocity + dt * now_.acceleration;
      look(ahead, gaps_);
      const double changes = gaps_[i] - gaps[i];
      if (std::abs(changes) > std::max(visible, share * size(way)) * length) return changes;
      if (size(way) > farthest || longer == most_tenfold) return 0.0;
    }
  };
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_gap(i)) continue;
    const double on_its_side = switches_.side(i) * gaps[i];
    if (on_its_side > near * length) continue;
    if (on_its_side < -near * length || switches_.side(i) * change(i) < -visible * length) passed.push_back(i);
  }
  for (const std::size_t i : passed) take_event(i);
  look(now_, gaps_);
  if (!passed.empty()) partition_.accelerate(now_);
}

void Integrator::update_contacts() {
  if (!switches_.has_gaps()) return;
  look(now_, gaps_);
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_gap(i) || !(gaps_[i] * switches_.side(i) < 0)) continue;
    switches_.set_side(i, -switches_.side(i));
    system_.touch(switches_.force(i), switches_.place(i), switches_.side(i) < 0);
  }
}

// A measure that is beyond its value at the start has to come back before it can pass it.
void Integrator::await_passage() {
  if (!system_.has_joint_events()) return;
  look(now_, gaps_);
  for (std::size_t i = 0; i < switches_.count(); ++i)
    if (switches_.of_joint(i) && gaps_[i] < 0 && system_.model().events[switches_.event(i)].element.input)
      switches_.set_side(i, -1);
}

// A joint opens or closes where now_ is, and with it every joint whose event has come at that instant: at once, so that
// the order of the events does not matter. What comes due because of them (a reaction jumps, an impact takes a measure
// past its value) follows in the same instant, no event twice.
void Integrator::fire(std::size_t event) {
  std::vector<char> had(system_.model().events.size(), 0);
  std::vector<std::size_t> due = reached(had);
  if (std::find(due.begin(), due.end(), event) == due.end()) due.push_back(event);
  bool changed = false;
  while (!due.empty()) {
    const std::vector<char> open = system_.open_joints();
    if (!switch_joints(due, had)) break;
    changed = true;
    arm(open);
    due = reached(had);
  }
  if (changed) damp_grips();
}

// Opens and closes the joints of the events, and of those that come by the same time; false where all were so already.
bool Integrator::switch_joints(std::vector<std::size_t> due, std::vector<char>& had) {
  const auto& events = system_.model().events;
  system_.set_state(now_.t, now_.q, now_.velocity);
  system_.set_element_states(now_.states);
  bool changed = false, closed = false;
  const auto pass = [&](std::size_t event) {
    const JointEvent& e = events[event].element;
    const bool opens = e.does == JointEvent::Does::opens, changes = opens != (system_.open_joints()[e.index] != 0);
    had[event] = 1;
    system_.switch_joint(event);
    if (!changes) return;
    changed = true, closed = closed || !opens;
    events_.push_back({now_.t, e.joint, opens ? 1 : -1, false});
  };
  for (const std::size_t event : due) pass(event);
  const double same_time = 1e-12 * std::max(1.0, std::abs(now_.t));
  for (std::size_t next; (next = system_.due_event(same_time)) < events.size();) pass(next);
  if (!changed) return false;
  partition_.choose(now_);
  if (closed) take_impulse();
  partition_.evaluate(now_);
  return true;
}

// After joints have changed that were as in `open` before. A measure that could change one of them back or anew has to
// be clear of its value first, with hysteresis; a limit of a reaction holds from that instant on.
void Integrator::arm(const std::vector<char>& open) {
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_joint(i)) continue;
    const JointEvent& e = system_.model().events[switches_.event(i)].element;
    if (open[e.index] != system_.open_joints()[e.index]) switches_.set_side(i, e.input ? -1 : 1);
  }
  look(now_, gaps_);
  arm_returned();
}

// Events that wait, and whose measure is clear of their value in gaps_.
void Integrator::arm_returned() {
  for (std::size_t i = 0; i < switches_.count(); ++i)
    if (switches_.of_joint(i) && switches_.side(i) < 0 && gaps_[i] > 0) switches_.set_side(i, 1);
}

// Events of joints that are at their value, within their hysteresis, or beyond it at now_, and wait for nothing else.
std::vector<std::size_t> Integrator::reached(const std::vector<char>& had) {
  std::vector<std::size_t> due;
  look(now_, gaps_);
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_joint(i) || switches_.side(i) < 0) continue;
    const std::size_t event = switches_.event(i);
    const JointEvent& e = system_.model().events[event].element;
    const bool done = (e.does == JointEvent::Does::opens) == (system_.open_joints()[e.index] != 0);
    if (e.timed() || done || gaps_[i] > e.hysteresis()) continue;
    if (had[event])
      switches_.set_side(i, -1);
    else
      due.push_back(event);
  }
  return due;
}

// y = M^1/2 (v+ - v-), of least norm with Phi_q v+ = -Phi_t; impulses P from M^1/2 y = -Phi_q^T P.
void Integrator::take_impulse() {
  Constraints c;
  system_.set_state(now_.t, now_.q, now_.velocity);
  system_.constraints(c);
  const Eigen::VectorXd root = system_.mass().cwiseSqrt();
  const Eigen::MatrixXd weighted = row_scale(system_).asDiagonal() * c.jacobian * root.cwiseInverse().asDiagonal();
  const Eigen::VectorXd off = row_scale(system_).cwiseProduct(Eigen::VectorXd(c.jacobian * now_.velocity + c.phi_t));
  const Eigen::VectorXd y = -least_norm_solution(weighted, off, rank_share);
  const Eigen::VectorXd impulse =
      row_scale(system_).cwiseProduct(-least_norm_solution(weighted.transpose(), y, rank_share));
  now_.velocity += y.cwiseQuotient(root);
  flows_.latched += 0.5 * y.squaredNorm();
  const auto drivers = static_cast<Eigen::Index>(2 * system_.model().forces.size());
  for (std::size_t d = 0; d < system_.model().drivers.size(); ++d) {
    const int row = system_.row_of_driver(d);
    flows_.of_elements[drivers + static_cast<Eigen::Index>(d)] += impulse[row] * c.phi_t[row];
  }
}

bool Integrator::fire_due() {
  changes_seen_ = system_.wrench_changes();
  if (!system_.has_joint_events()) return false;
  bool fired = false;
  for (std::size_t due = system_.due_event(0); due < system_.model().events.size(); due = system_.due_event(0))
    fire(due), fired = true;
  look(now_, gaps_);
  arm_returned();  // what a jump has brought back has no root either
  for (std::size_t i = 0; i < switches_.count(); ++i)
    if (switches_.of_joint(i) && switches_.side(i) > 0 && gaps_[i] < 0) {
      fire(switches_.event(i));
      fired = true;
      look(now_, gaps_);
    }
  return fired;
}

bool Integrator::begin_controllers() {
  const SharedReactions reactions(system_, partition_.used_rows().size(), now_.lambda,
                                  controllers_read_reactions(system_));
  return system_.begin_states_of(now_.acceleration, reactions.lambda());
}

// Sampled controllers look, at the state now_.
void Integrator::act(double close) {
  const SharedReactions reactions(system_, partition_.used_rows().size(), now_.lambda,
                                  controllers_read_reactions(system_));
  system_.act(now_.acceleration, reactions.lambda(), close);
}

// A controller that measures the solution begins with one in which it has
// nothing to do.
void Integrator::begin_states() {
  const auto take = [&] {
    const std::vector<double>& x = system_.element_states();
    std::copy(x.begin(), x.end(), now_.states.data());
    flows_.of_elements.tail(now_.states.size()) = now_.states;
  };
  system_.begin_states(), take();
  partition_.evaluate(now_);
  if (begin_controllers()) take(), partition_.evaluate(now_);
  if (system_.next_instant() <= now_.t) act(0);
}

void Integrator::advance_part(double h) {
  if (watches_switches() && !finds_events())
    advance_over_events(h);
  else
    on_advance(h);
}

// Sampled controllers act between parts of the step.
void Integrator::advance_over_instants(double h) {
  // Instants of samples, delays and rows that ought to be one differ by rounding: no step is that short.
  const double end = now_.t + h, close = std::min(0.5 * h, std::max(1e-9 * h, 1e-13 * std::max(1.0, std::abs(end))));
  system_.forget_outputs_before();
  while (end - now_.t > close) {
    const double next = system_.next_instant(), until = next < end - close ? next : end;
    if (until - now_.t > close) advance_part(until - now_.t);
    if (next > now_.t + close) continue;
    system_.set_state(now_.t, now_.q, now_.velocity);
    system_.set_element_states(now_.states);
    keep_end();
    const long changes = system_.wrench_changes();
    act(close);
    const bool jumped = changes != system_.wrench_changes();
    if (jumped) partition_.accelerate(now_);
    bool anew = jumped && !finds_events();  // those that find events look at jumps themselves
    for (std::size_t due; (due = system_.due_event(close)) < system_.model().events.size(); anew = true) fire(due);
    if (finds_events() && system_.has_joint_events() && changes_seen_ != system_.wrench_changes()) {
      partition_.accelerate(now_);
      anew = fire_due() || anew;
    }
    if (anew && !finds_events() && watches_switches()) release_friction();
    if (anew) on_start();
    keep_begin();
  }
}

void Integrator::advance(double h) {
  asked_end_ = std::numeric_limits<double>::quiet_NaN();
  step_by(h);
}

void Integrator::advance_to(double end) {
  asked_end_ = end;
  step_by(end - state().t);
}

void Integrator::step_by(double h) {
  if (!(h > 0)) throw std::invalid_argument("machine step = " + std::to_string(h) + " s: must be above 0");
  // A step that fails leaves segments too, which are read with what the elements remember at its begin.
  if (keeps_ && !dense_.memory) q_before_ = now_.q, keep_memory();
  move(h);
  refuse_blow_up(system_, state());
}

void Integrator::move(double h) {
  q_before_ = now_.q;
  flows_.of_elements += lost_at_once_, lost_at_once_.setZero();
  dense_.segments.clear();
  if (finds_events() && system_.has_joint_events() && changes_seen_ != system_.wrench_changes()) {
    partition_.accelerate(now_);
    if (fire_due()) on_start();
  }
  keep_begin();
  system_.has_instants() ? advance_over_instants(h) : advance_part(h);
  keep_end();
  system_.set_state(now_.t, now_.q, now_.velocity);
  system_.commit(lost_at_once_);
  flows_.external_work += system_.external_work(q_before_, now_.q);
  if (keeps_) keep_memory();
}

StepSegment Integrator::begin_segment(bool jumps) const {
  return {.begin = now_,
          .end = now_,
          .flows_begin = flows_,
          .flows_end = flows_,
          .open = system_.open_joints(),
          .grips = system_.grips(),
          .jumps = jumps};
}

void Integrator::keep_begin(bool jumps) {
  if (keeps_) dense_.segments.push_back(begin_segment(jumps));
}

void Integrator::keep_end() {
  if (!keeps_) return;
  StepSegment& last = dense_.segments.back();
  last.end = now_, last.flows_end = flows_, last.choice = partition_.choice();
}

void Integrator::keep_memory() {
  dense_.memory = std::make_shared<const StepMemory>(StepMemory{system_.memory(), q_before_, starts_});
}

void Integrator::show(double t) {
  if (!shown_) shown_ = std::make_unique<Evaluation>(system_);
  shown_->evaluate(dense_, t, dense_.count() - 1);
  shows_ = true;
}

void Integrator::look(const MotionState& m, std::vector<double>& gaps) {
  system_.set_state(m.t, m.q, m.velocity);
  system_.set_multipliers(m.lambda);
  system_.set_element_states(m.states);
  const SharedReactions reactions(system_, partition_.used_rows().size(), m.lambda, events_read_reactions(system_));
  switches_.gaps(gaps, &m.acceleration, &reactions.lambda());
}

bool Integrator::crossed() {
  look(now_, gaps_);
  for (std::size_t i = 0; i < gaps_.size(); ++i)
    if (gaps_[i] * switches_.side(i) < 0) return true;
  return false;
}

void Integrator::take_event(std::size_t which) {
  if (switches_.of_joint(which)) {
    // One that comes back from beyond its value may be passed again.
    return switches_.side(which) < 0 ? switches_.set_side(which, 1) : fire(switches_.event(which));
  }
  look(now_, gaps_);
  const bool friction = switches_.of_friction(which);
  if (!friction) switches_.set_side(which, -switches_.side(which));
  const std::size_t force = switches_.force(which), place = switches_.place(which);
  const int before = friction ? system_.sense(force, place) : 0;
  const Changeover change =
      friction ? system_.pass_event(force, place) : system_.touch(force, place, switches_.side(which) < 0);
  double& lost = flows_.of_elements[static_cast<Eigen::Index>(force)];
  lost += change.heat;
  if (friction ? !change.slides : switches_.side(which) < 0) lost -= grip(force, place);
  if (friction && !change.slides) lost -= share_grips(which);
  const int after = friction ? system_.sense(force, place) : 0;
  if (friction && after != 0 && after == before) return;  // rounding of a speed that comes to 0 and rises again
  events_.push_back({now_.t, switches_.name(which), !friction ? switches_.side(which) : after != 0 ? 1 : -1, friction});
}

void Integrator::take(const std::vector<double>& from, Eigen::VectorXd& to, const char* what) {
  if (static_cast<Eigen::Index>(from.size()) != to.size())
    throw std::invalid_argument("restart: the state has " + std::to_string(from.size()) + " numbers of " + what +
                                ", this machine has " + std::to_string(to.size()));
  std::copy(from.begin(), from.end(), to.data());
}

Snapshot Integrator::save() const {
  const MotionState& m = state();
  const EnergyFlows& flows = this->flows();
  Snapshot out{.time = m.t,
               .pose = numbers(m.q),
               .velocity = numbers(m.velocity),
               .flows = numbers(flows.of_elements + lost_at_once_),
               .external_work = flows.external_work,
               .latched = flows.latched,
               .elements = system_.save(),
               .error = step_error_,
               .switches = {},
               .events = {},
               .past = {}};
  for (std::size_t i = 0; i < switches_.count(); ++i) out.switches.push_back(switches_.side(i));
  for (const Event& e : events_) {
    std::size_t which = 0;
    while (which + 1 < switches_.count() &&
           (switches_.name(which) != e.name || switches_.of_friction(which) != e.of_friction))
      ++which;
    out.events.push_back({e.t, e.direction, which});
  }
  on_save(out.past);
  return out;
}

// What follows depends on the snapshot alone, not on what the machine did before: one that is restored from its own
// state continues as another one does.
void Integrator::restore(const Snapshot& from) {
  hide(), dense_ = {}, ++starts_;
  std::fill(stuck_since_.begin(), stuck_since_.end(), std::numeric_limits<double>::quiet_NaN());
  now_.t = from.time;
  take(from.pose, now_.q, "pose");
  take(from.velocity, now_.velocity, "velocity");
  take(from.flows, flows_.of_elements, "energy"), lost_at_once_.setZero();
  now_.states = flows_.of_elements.tail(now_.states.size());
  flows_.external_work = from.external_work, flows_.latched = from.latched;
  system_.restore(from.elements);
  changes_seen_ = system_.wrench_changes();
  step_error_ = from.error;
  const auto refuse = [] {
    throw std::invalid_argument("restart: switches and events of the state are those of another machine");
  };
  if (from.switches.size() != switches_.count()) refuse();
  events_.clear();
  for (const Snapshot::SwitchEvent& e : from.events) {
    if (e.of >= switches_.count()) refuse();
    events_.push_back({e.time, switches_.name(e.of), e.direction, switches_.of_friction(e.of)});
  }
  now_.lambda.setZero();  // a guess
  partition_.choose(now_);
  partition_.evaluate(now_);
  for (std::size_t i = 0; i < from.switches.size(); ++i) switches_.set_side(i, from.switches[i]);
  on_restore(from.past);
}

std::unique_ptr<Integrator> make_integrator(IntegratorKind kind, System& system, const AdamsMoultonOptions& adams,
                                            const IdaOptions& ida, const CvodeOptions& cvode) {
  switch (kind) {
    case IntegratorKind::cvode:
      return std::make_unique<Cvode>(system, cvode);
    case IntegratorKind::ida:
      return std::make_unique<Ida>(system, ida);
    case IntegratorKind::kinematic:
      return std::make_unique<Kinematic>(system);
    case IntegratorKind::adams_moulton:
      break;
  }
  return std::make_unique<AdamsMoulton>(system, adams);
}

}  // namespace subsoil::mbd
