#pragma once
#include <vector>

#include "libmbd/search/step_search.hpp"
#include "libsim/run/crossings.hpp"
#include "libsim/run/motion_summary.hpp"

namespace subsoil::sim {

/// Takes the columns of a machine alone through the dense output of its steps: to extrema, roots, jumps and integrals
/// of what is followed over time, and where given of levels passed and of the summary. Runs and simulations in process
/// follow their columns by it, so that both have the same values.
class MotionSearch : private mbd::StepSignals {
 public:
  /// Keeps the machine's dense output. @param crossings, summary may be null
  MotionSearch(mbd::Machine& machine, Columns& columns, Crossings* crossings, MotionSummary* summary);

  /// Between two instants at the most where columns are followed, s.
  static constexpr double longest = 1e-3;

  /// All columns at the first instant, or behind a jump there. True where the run is to end.
  bool begin(double t, std::vector<double>& row);
  /// From an instant of the last step, whose row is `row`, to a later one, whose row it becomes. True where the run is
  /// to end, at Crossings::stopped_at().
  bool search(double from, double until, std::vector<double>& row);

  /// At a time of the last step; at the step's end where `t` is beyond it by `close` at the most.
  mbd::Instant instant_at(double t, double close = 0);
  /// At a time in the last step, behind what jumps there: where a run stops.
  mbd::Instant instant_behind(double t);

 private:
  // Signals are the columns.
  void sample(double t, const mbd::Instant& at, std::vector<double>& row) override;
  void rounding(const mbd::Instant& at, std::span<const double> row, std::vector<double>& out) override;
  void request(double until, std::vector<mbd::Request>& out) override;
  bool take_jump(double t, std::vector<double>& row) override;
  bool take_part(const mbd::StepPart& part) override;

  const mbd::Machine& machine_;
  Columns& columns_;
  Crossings* crossings_;  ///< null: none
  MotionSummary* summary_;
  mbd::Evaluation evaluation_;
  mbd::StepSearch search_;
  int parts_;  ///< of a segment of a step
  std::vector<double> between_, half_;
};

}  // namespace subsoil::sim
