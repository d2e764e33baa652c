#include "libmbd/adams_moulton.hpp"

#include <stdexcept>

namespace subsoil::mbd {

namespace {

// Weights, newest first. Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, III.1.
constexpr double bashforth[6][6] = {
    {1.},
    {3. / 2, -1. / 2},
    {23. / 12, -16. / 12, 5. / 12},
    {55. / 24, -59. / 24, 37. / 24, -9. / 24},
    {1901. / 720, -2774. / 720, 2616. / 720, -1274. / 720, 251. / 720},
    {4277. / 1440, -7923. / 1440, 9982. / 1440, -7298. / 1440, 2877. / 1440, -475. / 1440},
};
constexpr double moulton[6][6] = {
    {1.},
    {1. / 2, 1. / 2},
    {5. / 12, 8. / 12, -1. / 12},
    {9. / 24, 19. / 24, -5. / 24, 1. / 24},
    {251. / 720, 646. / 720, -264. / 720, 106. / 720, -19. / 720},
    {475. / 1440, 1427. / 1440, -798. / 1440, 482. / 1440, -173. / 1440, 27. / 1440},
};

// Dormand & Prince 1980, order 5, six stages.
constexpr int stage_count = 6;
constexpr double nodes[stage_count] = {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1};
constexpr double stage_weights[stage_count][5] = {
    {},
    {1. / 5},
    {3. / 40, 9. / 40},
    {44. / 45, -56. / 15, 32. / 9},
    {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
    {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
};
constexpr double result_weights[stage_count] = {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84};

// Substeps of a starting step: the start's error is then far below that of the steps that follow.
constexpr int substeps = 2;

}  // namespace

AdamsMoulton::AdamsMoulton(System& system, const AdamsMoultonOptions& options) : Integrator(system), options_(options) {
  if (options.order < 1 || options.order > order_max)
    throw std::invalid_argument("adams-moulton order = " + std::to_string(options.order) + ": must be in [1, 6]");
  ring_.assign(order_max, {now_.velocity, now_.acceleration, now_.rates});
  stages_.assign(stage_count, ring_.front());
  trial_ = now_;
  q_sum_ = velocity_sum_ = now_.q;
  rates_sum_ = now_.rates;
}

void AdamsMoulton::on_start() {
  stored_ = 0;
  step_ = 0;
  wrench_changes_ = system_.wrench_changes();
  push_past();
}

void AdamsMoulton::push_past() {
  newest_ = (newest_ + 1) % order_max;
  if (stored_ < order_max) ++stored_;
  past(0).velocity = now_.velocity;
  past(0).acceleration = now_.acceleration;
  past(0).rates = now_.rates;
}

void AdamsMoulton::take_jump() {
  if (wrench_changes_ == system_.wrench_changes()) return;
  wrench_changes_ = system_.wrench_changes();
  partition_.accelerate(now_);
  if (options_.wrench_jump == WrenchJump::restart) {
    stored_ = 0;
    push_past();
    return;
  }
  velocity_sum_ = now_.acceleration - past(0).acceleration;
  rates_sum_ = now_.rates - past(0).rates;
  for (int age = 0; age < stored_; ++age) {
    past(age).acceleration += velocity_sum_;
    past(age).rates += rates_sum_;
  }
}

void AdamsMoulton::on_advance(double h) {
  // Rounding of a caller's own clock must not throw the past away.
  if (!(std::abs(h - step_) <= 1e-9 * step_)) {
    stored_ = 0;
    push_past();
    step_ = h, origin_ = now_.t, steps_ = 0;
  }
  take_jump();
  if (stored_ < options_.order) {
    one_step(step_);
  } else {
    multistep(step_);
  }
  now_.t = origin_ + static_cast<double>(++steps_) * step_;
  if (partition_.choose_again_if_needed(now_)) partition_.evaluate(now_);
  push_past();
}

void AdamsMoulton::set_independent(const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  for (const int i : partition_.independent()) trial_.q[i] = q[i], trial_.velocity[i] = velocity[i];
}

void AdamsMoulton::multistep(double h) {
  const int k = options_.order;
  const double *b = bashforth[k - 1], *c = moulton[k - 1];
  trial_.t = now_.t + h;
  trial_.q = now_.q, trial_.velocity = now_.velocity;
  for (int j = 0; j < k; ++j) {
    trial_.q += h * b[j] * past(j).velocity;
    trial_.velocity += h * b[j] * past(j).acceleration;
  }
  partition_.evaluate(trial_);

  q_sum_ = now_.q + h * c[0] * trial_.velocity;
  velocity_sum_ = now_.velocity + h * c[0] * trial_.acceleration;
  rates_sum_.setZero();
  for (int j = 0; j + 1 < k; ++j) {
    q_sum_ += h * c[j + 1] * past(j).velocity;
    velocity_sum_ += h * c[j + 1] * past(j).acceleration;
    rates_sum_ += h * c[j + 1] * past(j).rates;
  }
  set_independent(q_sum_, velocity_sum_);
  partition_.evaluate(trial_);
  flows_.of_elements += rates_sum_ + h * c[0] * trial_.rates;
  std::swap(now_, trial_);
}

void AdamsMoulton::one_step(double h) {
  const double start = now_.t;
  for (int i = 0; i < substeps; ++i) {
    runge_kutta(h / substeps);
    now_.t = start + h * (i + 1) / substeps;
  }
}

void AdamsMoulton::runge_kutta(double h) {
  trial_ = now_;
  for (int stage = 0; stage < stage_count; ++stage) {
    if (stage > 0) {
      q_sum_ = now_.q, velocity_sum_ = now_.velocity;
      for (int j = 0; j < stage; ++j) {
        q_sum_ += h * stage_weights[stage][j] * stages_[static_cast<std::size_t>(j)].velocity;
        velocity_sum_ += h * stage_weights[stage][j] * stages_[static_cast<std::size_t>(j)].acceleration;
      }
      trial_.t = now_.t + nodes[stage] * h;
      trial_.q = q_sum_;
      set_independent(q_sum_, velocity_sum_);
      partition_.evaluate(trial_);
    }
    auto& f = stages_[static_cast<std::size_t>(stage)];
    f.velocity = trial_.velocity, f.acceleration = trial_.acceleration, f.rates = trial_.rates;
  }
  q_sum_ = now_.q, velocity_sum_ = now_.velocity;
  for (int j = 0; j < stage_count; ++j) {
    const auto& f = stages_[static_cast<std::size_t>(j)];
    q_sum_ += h * result_weights[j] * f.velocity;
    velocity_sum_ += h * result_weights[j] * f.acceleration;
    flows_.of_elements += h * result_weights[j] * f.rates;
  }
  trial_.t = now_.t + h;
  trial_.q = q_sum_;
  set_independent(q_sum_, velocity_sum_);
  partition_.evaluate(trial_);
  std::swap(now_, trial_);
}

void AdamsMoulton::on_save(std::vector<double>& out) const {
  out.insert(out.end(), {static_cast<double>(stored_), step_, origin_, static_cast<double>(steps_)});
  for (int age = stored_; age-- > 0;) {
    put(out, past(age).velocity);
    put(out, past(age).acceleration);
    put(out, past(age).rates);
  }
}

void AdamsMoulton::on_restore(const double*& from, const double* end) {
  const int count = static_cast<int>(take(from, end));
  if (count < 0 || count > order_max)
    throw std::runtime_error("machine restart data are damaged: stored steps of the integrator");
  step_ = take(from, end), origin_ = take(from, end), steps_ = static_cast<long>(take(from, end));
  stored_ = 0;
  for (int i = 0; i < count; ++i) {
    newest_ = (newest_ + 1) % order_max;
    ++stored_;
    take(from, end, past(0).velocity);
    take(from, end, past(0).acceleration);
    take(from, end, past(0).rates);
  }
  // The wrench came back with the system and is the one that the past was stored under.
  wrench_changes_ = system_.wrench_changes();
}

}  // namespace subsoil::mbd
