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

/// Central differences over steps h_i = h_0/1.4^i, extrapolated to h = 0 by Richardson's table in h^2; the value is the
/// entry that differs least from its neighbours in the table, and that difference the error. It rises again where
/// rounding and the integrator's tolerance tell, so that the best step is found by itself. Source: Ridders, Advances in
/// Engineering Software 4 (1982) 75.
/// @param differences (f(x + h_i) - f(x - h_i))/(2 h_i)
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
