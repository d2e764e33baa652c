#pragma once
#include <optional>
#include <vector>

#include "libmbd/search/step_search.hpp"
#include "libsim/run/motion_summary.hpp"
#include "libsim/run/run_output.hpp"

namespace subsoil::sim {

/// Samples of a machine alone without columns of means: rows and frames are of their times exactly. Methods with a
/// dense output of their own end steps there; with fixed steps what lies between is read from the step that leads past
/// it. Between them the motion is searched for extrema, crossings and stop conditions.
class MotionSamples : public Samples, private mbd::StepSignals {
 public:
  explicit MotionSamples(RunOutput& output);

  double time() const override { return t_; }
  mbd::Instant machine() override;
  const std::vector<double>& last_row() const override { return o_.values; }
  void before_step(bool spheres_changed, StepRequest& request) override;
  bool after_step() override;

 private:
  // Signals are the columns.
  void sample(double t, const mbd::Instant& at, std::vector<double>& row) override;
  void rounding(const mbd::Instant& at, std::span<const double> row, std::vector<double>& out) override;
  void request(double until, std::vector<mbd::Request>& out) override;
  bool take_jump(double t, std::vector<double>& row) override;
  bool take_part(const mbd::StepPart& part) override;

  /// At a time of the last step; at the step's end where `t` is beyond it by `close` at the most.
  mbd::Instant instant_at(double t, double close = 0);
  /// At a time in the last step, behind what jumps there: where a run stops.
  mbd::Instant instant_behind(double t);
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
  std::optional<mbd::Evaluation> evaluation_;
  std::optional<mbd::StepSearch> search_;
  bool begun_ = false;
  double t_;
  double planned_ = 0;  ///< the next instant
  std::vector<double> between_, half_;
};

}  // namespace subsoil::sim
