#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "libsim/base/json_fwd.hpp"
#include "libsim/post/furrow.hpp"
#include "libsim/scenario/scenario.hpp"

/// What one pass has done to the soil, read off the frames of a run: for the summary, the report and pictures alike.
namespace subsoil::sim {

struct Disturbance {
  std::optional<ToolPath> tool;
  std::optional<Furrow> furrow;
  std::string why;  ///< there is none
};

/// The bed's periodic sides, as far as the scenario is known.
dem::PeriodicCell periodic_cell(const Scenario* scenario);

/// @param steady_from time at which steady work begins, NaN where that is not known
Disturbance disturbance_of(const FramesFile& file, const Scenario* scenario, double soil_surface, double steady_from);

/// Of results that are complete, or as far as they go: the same of a folder.
Disturbance disturbance_of(const std::filesystem::path& run);

/// The soil's mean surface before the pass, m: of the summary, of the scenario, or the 99th percentile of the tops of
/// spheres in the first frame.
double soil_surface(double of_summary, const Scenario* scenario, const FramesFile& file);

/// Key of the section `disturbance` under which a run states a warning of a wall; null where its means never
/// began.
inline constexpr const char* reaches_wall_key = "disturbed soil reaches a wall";

/// As in summary.json. @param draft mean force against the travel, N, and half of its interval; NaN where not known
Json disturbance_json(const Disturbance& d, double draft, double half_width);

}  // namespace subsoil::sim
