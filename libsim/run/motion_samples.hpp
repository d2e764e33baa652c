#pragma once
#include <optional>
#include <vector>

#include "libsim/run/motion_search.hpp"
#include "libsim/run/run_output.hpp"

namespace subsoil::sim {

/// Samples of a machine alone without columns of means: rows and frames are of their times exactly. Methods with a
/// dense output of their own end steps there; with fixed steps what lies between is read from the step that leads past
/// it. Between them the motion is searched for extrema, crossings and stop conditions.
class MotionSamples : public Samples {
 public:
  explicit MotionSamples(RunOutput& output);

  double time() const override { return t_; }
  mbd::Instant machine() override;
  const std::vector<double>& last_row() const override { return o_.values; }
  void before_step(bool spheres_changed, StepRequest& request) override;
  bool after_step() override;

 private:
  /// At a time of the last step; at the step's end where `t` is beyond it by `close` at the most.
  mbd::Instant instant_at(double t);
  /// Searches the last step up to t; true where the run is to end by then.
  bool search(double t);
  /// Row and frame, where they are due; false where the machine's energy is lost.
  bool write(double t, const mbd::Instant& at, bool last);
  double next_due(double t) const;
  /// Between two instants, s.
  double longest() const;

  RunOutput& o_;
  const mbd::Machine& machine_;
  const bool fixed_;     ///< steps are
  const bool sums_up_;   ///< the summary has columns
  const bool watches_;   ///< crossings, or what is followed over time
  const bool searches_;  ///< between rows
  MotionSummary motion_;
  std::optional<MotionSearch> search_;  ///< also reads between the steps of a method of fixed step
  bool begun_ = false;
  double t_;
  double planned_ = 0;  ///< the next instant
};

}  // namespace subsoil::sim
