#pragma once
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libsim/studies/sweep/study.hpp"
#include "libsim/studies/wear/recession.hpp"
#include "libsim/studies/wear/worn_run.hpp"

/// `subsoil wear`: surfaces after many passes, from the wear of one run or of a run for each step.
namespace subsoil::sim {

struct WearRequest {
  std::filesystem::path run{}, out{};
  std::vector<double> hectares{}, passes{};  ///< one of them: where steps end, rising
  double spread = 0;                         ///< m
  std::optional<double> width{}, length{};   ///< m, of the strip that the run has worked
  std::optional<WearLaw> law{};
  bool repeat = false;  ///< a run with each worn tool, whose wear is that of the next step
  PoolOptions pool{};
  std::string pictures = "svg";
};

/// A surface at the end of a step.
struct WornState {
  std::string name;
  std::filesystem::path file{};  ///< STL
  double volume = 0;             ///< m^3, lost since it was new
  double mass = 0;               ///< kg
  Recessed by{};                 ///< since it was new
  double mean_depth() const { return by.area > 0 ? volume / by.area : 0; }
};

struct WearStep {
  std::string label;  ///< 10 ha
  double passes = 0;  ///< of the run
  double hectares = std::numeric_limits<double>::quiet_NaN();
  std::vector<WornState> surfaces{};
  std::filesystem::path scenario{};           ///< that runs with them
  std::vector<double> value{}, half_width{};  ///< of the study's numbers, of the run with them
};

struct WearResult {
  std::vector<WearStep> steps;        ///< with `repeat` the new tool before all
  std::vector<WornSurface> surfaces;  ///< of the given run
  std::optional<WorkedStrip> strip;   ///< where hectares were asked for
  std::vector<std::string> numbers;   ///< with units
  bool interrupted = false;
};

/// Writes OUT/SURFACE-10ha.stl, OUT/worn-10ha.yaml and OUT/wear.csv; with `repeat` OUT/points, sweep.csv, sweep.h5,
/// sweep.html of the runs and a picture of the first number over the steps.
/// Throws std::invalid_argument or ScenarioError where a request or a surface is refused, std::runtime_error where a
/// run of a step fails.
WearResult wear_study(const WearRequest& request);

}  // namespace subsoil::sim
