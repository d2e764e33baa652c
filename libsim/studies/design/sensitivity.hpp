#pragma once
#include <filesystem>
#include <functional>
#include <vector>

#include "libsim/studies/design/plan.hpp"
#include "libsim/studies/design/runs.hpp"

namespace subsoil::sim {

/// A derivative by differences, and how far it may be off.
struct Slope {
  double value = 0, error = 0;
  double jump = 0;  ///< at a kink: the slope above less that below, half of which is in the error
  double below() const { return value - 0.5 * jump; }
  double above() const { return value + 0.5 * jump; }
};

/// The limit of central differences for step 0: least squares of
///   d(h) = a + b h^2 (+ c h^4 (+ d h^6)),   weights h
/// since what integrator and rounding add to a difference falls with 1/h. Of the three orders the one whose a has the
/// narrowest 95 % interval (Student's t, from the residuals): a high one where the numbers are smooth, a low one where
/// they are noisy. The interval is the error. Richardson's table with the smallest difference of its entries (Ridders
/// 1982) lost: among noisy entries two agree by chance, a thousand times better than they are right.
/// @param differences (f(x + h_i) - f(x - h_i))/(2 h_i), h_i = h_0/1.4^i
Slope extrapolated_slope(const std::vector<double>& differences);
/// What the slope above the point has more than that below, where it exceeds chance; else 0. Least squares of
///   (f(x + h) + f(x - h) - 2 f(x))/h = J + c/h + b h (+ d h^3, or e h^2 + d h^3)
/// as above, whose c is what f(x) itself may be off. Chance counts as five of its 95 % intervals: since the narrowest
/// of three is taken, noise is then a kink in less than one of a hundred.
double slope_jump(const std::vector<double>& second_differences);
/// Both together: the error holds both slopes.
Slope slope_with_kink(const std::vector<double>& differences, const std::vector<double>& second_differences);
inline constexpr double step_ratio = 1.4;
inline constexpr std::size_t step_count = 7;

struct Sensitivity {
  std::vector<double> values;              ///< per number, at the parameters
  std::vector<std::string> units;          ///< likewise; empty: unknown
  std::vector<std::vector<Slope>> slopes;  ///< [number][parameter], unit of the number per the parameter's unit
};

/// Runs 2 * 7 runs per parameter and one, side by side. Throws StudyInterrupted, and std::runtime_error where a run
/// fails, with its cause.
Sensitivity find_sensitivity(const SensitivityPlan& plan, GrowingStudy& study);
Study study_of(const SensitivityPlan& plan);

/// FOLDER/sensitivity.csv.
void write_sensitivity(const SensitivityPlan& plan, const Sensitivity& found, const std::filesystem::path& folder);
std::string sensitivity_text(const SensitivityPlan& plan, const Sensitivity& found);

}  // namespace subsoil::sim
