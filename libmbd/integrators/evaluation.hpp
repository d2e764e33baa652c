#pragma once

#include <memory>

#include "libmbd/integrators/dense_output.hpp"

namespace subsoil::mbd {

/// A machine at an instant, to be read: its bodies and forces (system), its solution (state), its energy flows. Refers
/// to the machine, which stands at the end of its last step, or to an Evaluation; valid until either moves.
struct Instant {
  const System& system;
  const Partition& partition;
  const MotionState& state;
  const EnergyFlows& flows;

  double time() const { return state.t; }
  const BodyState& body(int index) const { return system.body(index); }
  /// All multipliers; of redundant constraints those of minimum norm.
  Eigen::VectorXd reactions() const { return partition.reactions(state); }
};

/// Evaluates states of a machine on a system and a partition of its own: no bit of the motion depends on what is read,
/// and none of what is read depends on what was read before.
class Evaluation {
 public:
  /// Of the system that an integrator moves, which outlives it.
  explicit Evaluation(const System& moved);

  /// Puts the state on the constraints by the partition of the motion. Where that makes velocities or reactions of
  /// rounding, beside a singular configuration, those of the dense output stay.
  Instant evaluate(const State& state);
  /// At a time in the step, and in one of its segments; see DenseOutput::state().
  Instant evaluate(const DenseOutput& output, double t);
  Instant evaluate(const DenseOutput& output, double t, std::size_t segment);
  /// At the state evaluated last.
  Instant instant() const { return {*system_, *partition_, state_, flows_}; }
  System& system() { return *system_; }

 private:
  Instant evaluate_read();
  void prepare();
  void put_on_constraints();
  void keep_as_read();
  double external_work() const;

  const System& moved_;
  std::unique_ptr<System> system_;
  std::unique_ptr<Partition> partition_;
  std::shared_ptr<const StepMemory> memory_;
  State read_;
  MotionState state_;
  EnergyFlows flows_;
};

}  // namespace subsoil::mbd
