#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libsim/studies/calibrate/plan.hpp"

namespace subsoil::sim {

/// The tests at one set of parameters.
struct Evaluation {
  enum class Why { truth, design, search };
  Why why = Why::design;
  std::vector<double> parameters;    ///< in the plan's units
  std::vector<double> found, error;  ///< per target: mean over packings and its standard deviation, SI; NaN: failed
  std::string failure;               ///< of a test that gave nothing there
  bool complete() const { return failure.empty(); }
};

/// What a calibration knows at its end. u is a parameter's place in its range, 0 to 1.
struct Calibrated {
  std::vector<PlanTarget> targets;  ///< with values
  std::vector<Evaluation> evaluations;
  Eigen::VectorXd u;              ///< the set found
  std::vector<double> values;     ///< the same in the plan's units
  std::vector<double> low, high;  ///< ends of the 95 % interval, within the range
  std::vector<double> predicted;  ///< per target, by the surrogate
  std::size_t nearest = 0;        ///< evaluation nearest to the set
  double distance = 0;            ///< of it in u, maximum over the parameters
  Eigen::MatrixXd slopes;         ///< d target/d u at the set, over the target's deviation
  Eigen::MatrixXd directions;     ///< right singular vectors of the slopes, a column each, strongest first
  Eigen::VectorXd strengths;      ///< singular values; below `blind` a direction is not identifiable
  bool converged = false;         ///< the last search led to a set that had been evaluated
  /// Deviation of a uniform range is 1/sqrt(12): a direction with less strength is known no better than its range.
  static constexpr double blind = 3.4641016151377544;
};

using CalibrationProgress = std::function<void(const Evaluation&, std::size_t number)>;

/// Finds the parameters that meet the plan's targets.
///   1. A design of points that fill the ranges (Halton) goes through the tests; common seeds, so that packings differ
///      between points by the parameters alone.
///   2. Each target becomes a surrogate of its values (surrogate.hpp); chi^2 = sum ((surrogate - value)/deviation)^2,
///   the
///      deviation that of the target's tolerance and of its mean over packings together.
///   3. DIRECT-L, then BOBYQA, find the minimum chi^2 on the surrogates; that point goes through the tests. From 2 on,
///      until the search leads within a hundredth of the ranges to a point that is known, or the evaluations are used
///      up.
///   4. Slopes J of the targets over u at the set, divided by the deviations. Intervals are those of the covariance
///      (J'J + 12 I)^-1: what the targets tell, and the range, as a uniform prior of deviation 1/sqrt(12).
/// Every evaluation is kept in `store` (CSV) at once; what stands in it is not run again. Throws std::runtime_error for
/// a store of another plan, and when too few evaluations succeed.
Calibrated calibrate(const Plan& plan, const std::filesystem::path& store, int threads,
                     const CalibrationProgress& progress);

/// The report: set, intervals, targets, slopes, what is not identifiable. Markdown.
std::string calibration_text(const Plan& plan, const Calibrated& c);
/// report.md and the pictures targets (deviations over evaluations) and, of each parameter, scatter, in `folder`.
void write_calibration(const Plan& plan, const Calibrated& c, const std::filesystem::path& folder,
                       const std::string& pictures);

}  // namespace subsoil::sim
