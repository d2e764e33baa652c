#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libsim/base/json_fwd.hpp"
#include "libsim/post/furrow.hpp"
#include "libsim/post/statistics.hpp"
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

/// Mean force of the soil on a tool against its travel, N, with half of its interval.
struct ToolDraft {
  std::string name;
  std::string direction;  ///< of its travel: "+x", "-z"; empty of a tool that does not travel
  double mean = 0, half_width = 0;
};

/// Share of the window of the means above which a tool out of the soil leaves no specific draft.
inline constexpr double most_out_of_soil = 0.01;

/// Mean draft of all tools over the disturbed area, N/m^2.
struct SpecificDraft {
  double value, half_width;
};
/// NaN where nothing is disturbed, no tool travels, two go against each other, since the area is that of one of them,
/// or the frames show the tool out of the soil in the window of the drafts.
SpecificDraft specific_draft(const ToolPath& tool, const Furrow& furrow, const std::vector<ToolDraft>& drafts,
                             const TimeWindow& window);

/// Key of the section `disturbance` under which a run states a warning of a wall; null where its means never
/// began.
inline constexpr const char* reaches_wall_key = "disturbed soil reaches a wall";

/// As in summary.json. @param window of the drafts
Json disturbance_json(const Disturbance& d, const std::vector<ToolDraft>& drafts, const TimeWindow& window);

}  // namespace subsoil::sim
