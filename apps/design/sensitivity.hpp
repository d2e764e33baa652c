#pragma once
#include <filesystem>
#include <functional>
#include <vector>

#include "apps/design/plan.hpp"
#include "apps/design/runs.hpp"

namespace subsoil::app {

/// A derivative by differences, and how far it may be off.
struct Slope {
  double value = 0, error = 0;
};

/// The limit of central differences for step 0: least squares of
///   d(h) = a + b h^2 (+ c h^4 (+ d h^6)),   weights h
/// since what integrator and rounding add to a difference falls with 1/h. Of the three orders the one whose a has the
/// narrowest 95 % interval (Student's t, from the residuals): a high one where the numbers are smooth, a low one where
/// they are noisy. The interval is the error. Richardson's table with the smallest difference of its entries (Ridders
/// 1982) lost: among noisy entries two agree by chance, a thousand times better than they are right.
/// @param differences (f(x + h_i) - f(x - h_i))/(2 h_i), h_i = h_0/1.4^i
Slope extrapolated_slope(const std::vector<double>& differences);
inline constexpr double step_ratio = 1.4;
inline constexpr std::size_t step_count = 7;

struct Sensitivity {
  std::vector<double> values;              ///< per number, at the parameters
  std::vector<std::vector<Slope>> slopes;  ///< [number][parameter], SI unit of the number per the parameter's unit
};

/// Runs 2 * 7 runs per parameter and one, side by side. Throws StudyInterrupted, and std::runtime_error where a run
/// fails, with its cause.
Sensitivity find_sensitivity(const SensitivityPlan& plan, GrowingStudy& study);
Study study_of(const SensitivityPlan& plan);

/// FOLDER/sensitivity.csv.
void write_sensitivity(const SensitivityPlan& plan, const Sensitivity& found, const std::filesystem::path& folder);
std::string sensitivity_text(const SensitivityPlan& plan, const Sensitivity& found);

}  // namespace subsoil::app
