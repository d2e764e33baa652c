#include "libmbd/integrators/evaluation.hpp"

namespace subsoil::mbd {

Evaluation::Evaluation(const System& moved)
    : moved_(moved), system_(moved.copy()), partition_(std::make_unique<Partition>(*system_)) {}

Instant Evaluation::evaluate(const State& state) {
  read_ = state;
  return evaluate_read();
}

Instant Evaluation::evaluate(const DenseOutput& output, double t) {
  const std::size_t segment = output.segment_at(t);
  return evaluate(output, t, segment);
}

Instant Evaluation::evaluate(const DenseOutput& output, double t, std::size_t segment) {
  output.read(t, segment, read_);
  return evaluate_read();
}

Instant Evaluation::evaluate_read() {
  prepare();
  state_ = read_.motion, flows_ = read_.flows;
  try {
    put_on_constraints();
  } catch (const SingularPose&) {
    state_ = read_.motion;
    keep_as_read();
  }
  flows_.external_work = external_work();
  return instant();
}

// Memories change with the step, the elements themselves with the start of the machine.
void Evaluation::prepare() {
  if (memory_ != read_.memory) {
    if (memory_ && memory_->start != read_.memory->start) {
      system_ = moved_.copy();
      partition_ = std::make_unique<Partition>(*system_);
    }
    memory_ = read_.memory;
    system_->set_memory(memory_->elements);
  }
  system_->see_outputs_before(read_.before_jump);
  system_->set_open_joints(read_.open);
  system_->set_grips(read_.grips);
}

void Evaluation::put_on_constraints() {
  // Factors of each pose by the choice of the motion: the same bits whatever was evaluated before.
  partition_->adopt(read_.choice);
  partition_->forget_factors();
  if (read_.nearest) {  // so near the polynomial is nearer to the constraints than rounding lets them say
    partition_->accelerate_as_it_is(state_);
    if (partition_->distance_from_singular() > Partition::known_velocities)
      state_ = read_.motion, partition_->evaluate_nearest(state_);
    return;
  }
  partition_->evaluate(state_);
  if (!partition_->near_singular()) return;
  // There u(v) makes reactions of rounding.
  state_ = read_.motion;
  partition_->evaluate_nearest(state_);
  if (!(partition_->distance_from_singular() < Partition::known_reactions)) return;
  state_.lambda = read_.motion.lambda, state_.rates = read_.motion.rates;
  state_.acceleration = read_.motion.acceleration;
  keep_as_read();
}

// What forces report and store follows the state.
void Evaluation::keep_as_read() {
  system_->set_state(state_.t, state_.q, state_.velocity);
  system_->set_multipliers(state_.lambda);
  system_->set_element_states(state_.states);
  Eigen::VectorXd loads(state_.q.size());
  system_->loads(loads);
}

double Evaluation::external_work() const {
  return read_.external_work_begin + system_->external_work(memory_->q_begin, state_.q);
}

}  // namespace subsoil::mbd
