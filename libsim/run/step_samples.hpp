#pragma once
#include <vector>

#include "libsim/run/run_output.hpp"

namespace subsoil::sim {

/// Samples of runs with soil, or with columns of means: what acts over a step is known once it is taken. Rows and
/// frames lie between instants (Rows, FrameOutput).
class StepSamples : public Samples {
 public:
  explicit StepSamples(RunOutput& output);

  double time() const override { return o_.simulation.time(); }
  mbd::Instant machine() override { return o_.world.machine->now(); }
  const std::vector<double>& last_row() const override { return o_.rows->last(); }
  void before_step(bool spheres_changed, StepRequest& request) override;
  bool after_step() override;
  void count_step() override;

 private:
  /// Rows and frames that are due up to the instant, whose values are known; at it too if it is the last.
  void write_due();

  RunOutput& o_;
  std::vector<double> summarised_;  ///< of the summary's columns
  const bool follows_sums_;         ///< what is followed over time is of sums over all spheres
  bool spheres_changed_ = false;
  bool stood_ = true;  ///< the machine, and not at the start of a window
};

}  // namespace subsoil::sim
