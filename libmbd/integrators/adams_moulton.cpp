#include "libmbd/integrators/adams_moulton.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <stdexcept>
#include <utility>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/integrators/adams_weights.hpp"
#include "libmbd/system/extent.hpp"

namespace subsoil::mbd {

namespace {

// Error constants of the two, of order k: what a step leaves is C h^(k+1) y^(k+1).
constexpr double bashforth_error[6] = {1. / 2, 5. / 12, 3. / 8, 251. / 720, 95. / 288, 19087. / 60480};
constexpr double moulton_error[6] = {1. / 2, 1. / 12, 1. / 24, 19. / 720, 3. / 160, 863. / 60480};
// Of a step, over the machine's length: more is no solution.
constexpr double most_error = 0.1;

// Lengths of the machine in a second.
constexpr double at_rest = 1e-6;

// A step is made of 2^12 parts at the most, and of no more for an error that is rounding.
constexpr int most_halvings = 12;
constexpr double least_error = 1e-13;
// Twice the step makes an error per second 2^order times as large: some 16, with a margin of four.
constexpr double sure_share = 1. / 64;

// Of the maximum of an input: what a controlled step may miss of its mean. The rest is left to the error of the step.
constexpr double controlled_share = 0.01;

// Substeps of a starting step: the start's error is then far below that of the steps that follow.
constexpr int substeps = 2;

}  // namespace

AdamsMoulton::AdamsMoulton(System& system, const AdamsMoultonOptions& options)
    : Integrator(system), options_(options), starter_(system, partition_), inputs_(system.model()) {
  if (options.order < 1 || options.order > order_max)
    throw std::invalid_argument("adams-moulton order = " + std::to_string(options.order) + ": must be in [1, 6]");
  const Eigen::Index size = 2 * now_.q.size() + now_.rates.size();
  past_.setZero(size, order_max);
  sum_.setZero(size);
  trial_ = now_;
  predicted_q_ = predicted_velocity_ = now_.q;
  scale_ = coordinate_scale(system);
}

void AdamsMoulton::on_start() {
  was_near_singular_ = bridged_ = false;
  stored_ = 0;
  step_ = 0;
  wrench_changes_ = system_.wrench_changes();
  push_past();
}

void AdamsMoulton::push_past() {
  newest_ = (newest_ + 1) % order_max;
  if (stored_ < options_.order) ++stored_;
  keep_rates(past_, slot(0), now_);
}

template <std::size_t... age>
void AdamsMoulton::sum_columns(const double* weights, double h, std::index_sequence<age...>) {
  sum_.noalias() = (... + (h * weights[age] * past_.col(slot(static_cast<int>(age)))));
}

/// sum_ = h times the weighted sum of the past, newest first.
void AdamsMoulton::sum_past(const double* weights, int count, double h) {
  switch (count) {
    case 0:
      sum_.setZero();
      return;
    case 1:
      return sum_columns(weights, h, std::make_index_sequence<1>());
    case 2:
      return sum_columns(weights, h, std::make_index_sequence<2>());
    case 3:
      return sum_columns(weights, h, std::make_index_sequence<3>());
    case 4:
      return sum_columns(weights, h, std::make_index_sequence<4>());
    case 5:
      return sum_columns(weights, h, std::make_index_sequence<5>());
    default:
      return sum_columns(weights, h, std::make_index_sequence<6>());
  }
}

void AdamsMoulton::take_jump() {
  if (wrench_changes_ == system_.wrench_changes()) return;
  wrench_changes_ = system_.wrench_changes();
  if (bridged_) return;  // a singular pose answers to no wrench; the next step does
  partition_.accelerate_by_wrenches(now_);
  if (options_.wrench_jump == WrenchJump::restart) {
    stored_ = 0;
    push_past();
    return;
  }
  const auto n = now_.q.size(), rest = now_.rates.size();
  const double* const before = past_.col(slot(0)).data() + n;
  double* const jump = sum_.data();
  for (Eigen::Index i = 0; i < n; ++i) jump[i] = now_.acceleration[i] - before[i];
  for (Eigen::Index i = 0; i < rest; ++i) jump[n + i] = now_.rates[i] - before[n + i];
  for (int age = 0; age < stored_; ++age) past_.col(slot(age)).tail(n + rest) += sum_.head(n + rest);
}

void AdamsMoulton::on_advance(double h) {
  begin_errors();
  const double parts = std::max(1.0, std::ceil(h / options_.longest_step - 1e-9));
  const double last = clock_.end_of_step(now_.t, h, asked_end_);
  for (double part = 0; part < parts; ++part) {
    if (part > 0) part_segment();
    const double end = part + 1 < parts ? now_.t + h / parts : last;
    if (controlled()) {
      controlled_step(end);
    } else {
      watch_inputs(h / parts);
      whole_step(h / parts);
    }
    if (end - now_.t > 1e-6 * h / parts || (part + 1 < parts && ends_at_event())) return;
  }
}

bool AdamsMoulton::controlled() const { return std::isfinite(options_.error_per_second); }

// In units of the smallest part, so that fewer parts begin where a larger one does. It may end before, at an event.
void AdamsMoulton::controlled_step(double end) {
  constexpr long all = 1L << most_halvings;
  const double h = end - now_.t;
  for (long done = 0; done < all;) {
    const long part = all >> level_;
    if (!attempt(h * static_cast<double>(part) / all)) {
      ++level_, sure_ = 0;
      continue;
    }
    done += part;
    if (part < all) energy_range_.see(system_);  // what comes and goes within the step has moved too
    if (done < all && ends_at_event()) return;
    if (done < all) part_segment();
    if (level_ > 0 && sure_ > 2 * options_.order && done % (2 * part) == 0) --level_, sure_ = 0;
  }
  now_.t = end;
}

// A step of that length, if it errs by no more than it may; else the state is as before, without a past.
bool AdamsMoulton::attempt(double h) {
  if (level_ < most_halvings &&
      (!inputs_.resolves_step(now_.t, h) || !inputs_.gives_means(now_.t, h, weights(), controlled_share)))
    return false;
  const MotionState before = now_;
  const EnergyFlows flows_before = flows_;
  const StepError errors_before = step_error_;
  const double of_flows = flow_error_;
  const double allowed = std::max(options_.error_per_second * h, least_error);
  // Across a singular configuration the past leads; what predictor and corrector differ by there is rounding over the
  // distance, which parts of the step, begun again beside it, make larger.
  const bool has_past = stored_ == options_.order && follows_on(h), began_near = was_near_singular_;
  const bool last = level_ == most_halvings;
  try {
    whole_step(h);
    const double velocity = step_error_.velocities - errors_before.velocities;
    // Of a machine that begins to move: what it gains in the step.
    const double gained = h * now_.acceleration.cwiseProduct(scale_).cwiseAbs().maxCoeff();
    const double error = step_error_.positions - errors_before.positions +
                         (velocity > 0 ? velocity / std::max(step_error_.fastest, gained) : 0) +
                         (flow_error_ - of_flows);
    if (error <= allowed || last || (has_past && (began_near || was_near_singular_))) {
      sure_ = error <= sure_share * allowed ? sure_ + 1 : 0;
      return true;
    }
  } catch (const std::runtime_error&) {
    if (last) throw;
  }
  now_ = before, flows_ = flows_before, step_error_ = errors_before;
  partition_.evaluate(now_);
  on_start();
  return false;
}

std::span<const double> AdamsMoulton::weights() const { return moulton_weights(options_.order); }

// Short steps under soil, which are many, are not watched.
void AdamsMoulton::watch_inputs(double h) {
  if (!(h > Inputs::spacing) && !no_wrench()) return;
  inputs_.add_missed(now_.t, h, weights(), missed_);
  step_error_.unseen = missed_.share();
}

bool AdamsMoulton::no_wrench() const {
  const auto& wrenches = system_.external_wrenches();
  return std::all_of(wrenches.begin(), wrenches.end(),
                     [](const auto& wrench) { return wrench == std::array<double, 3>{}; });
}

/// Rounding of a caller's own clock must not throw the past away.
bool AdamsMoulton::follows_on(double h) const { return std::abs(h - step_) <= 1e-9 * step_; }

void AdamsMoulton::whole_step(double h) {
  if (!follows_on(h)) {
    stored_ = 0;
    push_past();
    step_ = h, origin_ = now_.t, steps_ = 0;
  }
  take_jump();
  // Known beforehand, so that what is evaluated at the end is of that instant to the last bit: there it may jump.
  end_ = origin_ + static_cast<double>(++steps_) * step_;
  if (stored_ < options_.order) {
    one_step(step_);
  } else {
    multistep(step_);
  }
  now_.t = end_;
  if (!bridged_ && partition_.asks_for_choice()) choose_again();
  push_past();
}

/// On a singular configuration there is nothing to choose: the choice that has led there leads on.
void AdamsMoulton::choose_again() {
  const std::shared_ptr<const Choice> choice = partition_.choice();
  const MotionState led_there = now_;
  try {
    if (!partition_.choose_again_if_needed(now_)) return;
    was_near_singular_ ? partition_.evaluate_nearest(now_) : partition_.evaluate(now_);
  } catch (const SingularPose&) {
    if (!was_near_singular_) throw;
    now_ = led_there;
    partition_.adopt(choice);
    partition_.forget_factors();
  }
}

void AdamsMoulton::multistep(double h) {
  const bool bridged_before = std::exchange(bridged_, false);
  const bool nearest = partition_.near_singular();
  try {
    predict(h);
    keep_predicted();
    nearest ? partition_.evaluate_nearest(trial_) : partition_.evaluate_predicted(trial_);
    check_branch();
    correct(h);
    estimate_error(h);
    nearest ? partition_.evaluate_nearest(trial_) : partition_.evaluate(trial_);
    flows_.of_elements += sum_.tail(now_.rates.size()) + h * moulton[options_.order - 1][0] * trial_.rates;
    flows_.of_elements.tail(trial_.states.size()) = trial_.states;  // as the motion was evaluated with
  } catch (const SingularPose&) {
    if (bridged_before) throw;  // singular for longer than an instant
    bridge(h);
  }
  std::swap(now_, trial_);
}

void AdamsMoulton::predict(double h) {
  const auto n = now_.q.size();
  sum_past(bashforth[options_.order - 1], options_.order, h);
  trial_.t = end_;
  trial_.q = now_.q + sum_.head(n);
  trial_.velocity = now_.velocity + sum_.segment(n, n);
  trial_.states = now_.states + sum_.tail(now_.states.size());
}

void AdamsMoulton::correct(double h) {
  const double* c = moulton[options_.order - 1];
  const auto n = now_.q.size();
  sum_past(c + 1, options_.order - 1, h);
  trial_.q = now_.q + sum_.head(n) + h * c[0] * trial_.velocity;
  trial_.velocity = now_.velocity + sum_.segment(n, n) + h * c[0] * trial_.acceleration;
  const auto states = now_.states.size();
  trial_.states = now_.states + sum_.tail(states) + h * c[0] * trial_.rates.tail(states);
}

void AdamsMoulton::keep_predicted() {
  predicted_q_ = trial_.q;
  predicted_velocity_ = trial_.velocity;
  if (controlled()) predicted_flows_ = sum_.tail(now_.rates.size());
}

void AdamsMoulton::estimate_error(double h) {
  const int k = options_.order - 1;
  const double share = moulton_error[k] / (bashforth_error[k] + moulton_error[k]);
  double position = 0, velocity = 0;
  for (Eigen::Index i = 0; i < scale_.size(); ++i) {
    position = std::max(position, std::abs(trial_.q[i] - predicted_q_[i]) * scale_[i]);
    velocity = std::max(velocity, std::abs(trial_.velocity[i] - predicted_velocity_[i]) * scale_[i]);
  }
  add_error(h, share * position, share * velocity, trial_);
  if (!controlled()) return;
  predicted_flows_ = sum_.tail(now_.rates.size()) + h * moulton[k][0] * trial_.rates - predicted_flows_;
  add_flow_error(share, predicted_flows_, trial_);
}

void AdamsMoulton::add_flow_error(double share, const Eigen::Ref<const Eigen::VectorXd>& difference,
                                  const MotionState& at) {
  const Eigen::Index states = at.states.size(), energies = difference.size() - states;
  const double there = system_.kinetic() + std::abs(system_.stored()) + energy_at_rest(system_) +
                       flows_.of_elements.head(energies).cwiseAbs().sum();
  double most = energies > 0 ? difference.head(energies).cwiseAbs().maxCoeff() / there : 0;
  for (Eigen::Index i = 0; i < states; ++i)
    most = std::max(most, std::abs(difference[energies + i]) /
                              (system_.state_scales()[static_cast<std::size_t>(i)] + std::abs(at.states[i])));
  flow_error_ += share * most;
}

// A step that is repeated from the same time, to find an event in it, counts once.
void AdamsMoulton::begin_errors() {
  if (now_.t == errors_from_)
    step_error_ = errors_before_;
  else
    errors_from_ = now_.t, errors_before_ = step_error_;
}

// Errors in m and m/s that a step has left at its end.
void AdamsMoulton::add_error(double h, double position, double velocity, const MotionState& at) {
  const double fastest = at.velocity.cwiseProduct(scale_).cwiseAbs().maxCoeff();
  position /= system_.length_scale();
  step_error_.largest = std::max(step_error_.largest, position);
  step_error_.positions += position;
  step_error_.velocities += velocity;
  // Where the soil's wrench jumps, what predictor and corrector differ by adds up to no drift.
  if (no_wrench()) step_error_.drift += h * step_error_.velocities / system_.length_scale();
  step_error_.fastest = std::max({step_error_.fastest, fastest, at_rest * system_.length_scale()});  // slower: rounding
  if (position <= most_error) return;
  refuse_blow_up(system_, at);
  char text[320];
  std::snprintf(text, sizeof text,
                "the step of %.3g s errs by %.2g of the machine's length; it is too long for the motion, or a "
                "driver or force jumps",
                h, position);
  throw MotionFault(at.t, text, MotionFault::Cause::long_step);
}

void AdamsMoulton::bridge(double h) {
  bridged_ = was_near_singular_ = true;
  predict(h);
  assemble(system_, trial_.t, trial_.q, trial_.velocity);
  const int k = options_.order;
  const auto n = now_.q.size();
  double weights[order_max], binomial = 1;  // f_{n+1} = sum of (-1)^j (k over j + 1) f_{n-j}
  for (int j = 0; j < k; ++j) {
    binomial *= static_cast<double>(k - j) / (j + 1);
    weights[j] = j % 2 ? -binomial : binomial;
  }
  sum_past(weights, k, 1);
  system_.set_state(trial_.t, trial_.q, trial_.velocity);
  system_.loads(trial_.acceleration);  // for what forces report
  trial_.acceleration = sum_.segment(n, n);
  trial_.rates = sum_.tail(now_.rates.size());
  trial_.lambda = now_.lambda;
  const double* c = moulton[k - 1];
  sum_past(c + 1, k - 1, h);
  flows_.of_elements += sum_.tail(now_.rates.size()) + h * c[0] * trial_.rates;
  trial_.states = flows_.of_elements.tail(now_.states.size());
}

void AdamsMoulton::check_branch() {
  const bool near = partition_.near_singular();
  if (near || was_near_singular_) partition_.refuse_other_branch(trial_);
  was_near_singular_ = near;
}

void AdamsMoulton::one_step(double h) {
  const double start = now_.t;
  for (int i = 0; i < substeps; ++i) {
    const double end = i + 1 < substeps ? start + h * (i + 1) / substeps : end_;
    starter_.step(now_, end - now_.t, trial_, flows_.of_elements);
    std::swap(now_, trial_);
    now_.t = end;
    const Eigen::VectorXd& errors = starter_.errors();
    const auto n = scale_.size();
    add_error(h / substeps, errors.head(n).cwiseProduct(scale_).cwiseAbs().maxCoeff(),
              errors.segment(n, n).cwiseProduct(scale_).cwiseAbs().maxCoeff(), now_);
    if (controlled()) add_flow_error(1, errors.tail(now_.rates.size()), now_);
  }
}

void AdamsMoulton::on_save(Snapshot::Past& out) const {
  out.step = step_, out.origin = origin_, out.steps = steps_, out.level = level_, out.sure = sure_;
  for (int age = stored_; age-- > 0;) out.rates.push_back(numbers(past_.col(slot(age))));
  out.missed = missed_.missed, out.all = missed_.all;
  out.clock = clock_;
}

void AdamsMoulton::on_restore(const Snapshot::Past& from) {
  if (from.rates.size() > order_max)
    throw std::invalid_argument("restart: the state has more steps of the integrator than it stores");
  step_ = from.step, origin_ = from.origin, steps_ = from.steps;
  level_ = static_cast<int>(std::clamp(from.level, 0L, static_cast<long>(most_halvings))), sure_ = from.sure;
  missed_ = {.missed = from.missed, .all = from.all};
  clock_ = from.clock;
  step_error_.unseen = missed_.share();
  stored_ = 0, newest_ = 0;
  for (const std::vector<double>& rates : from.rates) {
    newest_ = (newest_ + 1) % order_max;
    stored_ = std::min(stored_ + 1, options_.order);
    take(rates, sum_, "the integrator's past");
    past_.col(slot(0)) = sum_;
  }
  trial_ = now_;
  was_near_singular_ = partition_.near_singular(), bridged_ = false;
  // The wrench came back with the system and is the one that the past was stored under.
  wrench_changes_ = system_.wrench_changes();
}

}  // namespace subsoil::mbd
