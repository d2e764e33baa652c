#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libsim/post/disturbance.hpp"
#include "libsim/post/furrow.hpp"
#include "libsim/post/run_folder.hpp"
#include "libsim/post/tool_path.hpp"
#include "libsim/report/draft_models.hpp"

namespace subsoil::sim {

/// A curve of a report: which column of the series it is, and what it is called.
struct Quantity {
  std::string key;     ///< pull, draft, lift, spring force, pitch, height, or the column's own name
  std::string column;  ///< of the series
  std::string unit;
};

/// The curves of a run. The six of a towed tool come first: as the run monitors them, else pull from the driver along
/// x, draft and lift from the soil, spring force, pitch and height from the first spring and the body that meets the
/// soil. Then every other monitor. A run without any of them: the forces on its moving boundaries.
std::vector<Quantity> quantities(const RunFolder& run);

/// A number of a report. Every number has the time it is taken over.
struct ReportNumber {
  std::string quantity, statistic, unit;
  double value = 0;
  double half_width = 0;  ///< of the 95 % interval; NaN where there is none
  TimeWindow window;
  std::string name() const { return quantity + ", " + statistic; }
};

/// Soil for McKyes-Ali, with the half width of each value's interval.
struct SoilStrength {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  double cohesion = 0, cohesion_error = unknown;  ///< Pa
  double friction = 0, friction_error = unknown;  ///< rad
  std::optional<double> wall_friction;            ///< rad; left out: two thirds of the friction angle
  double adhesion = 0;                            ///< Pa
};

/// A formula's band beside the draft, or why there is none.
struct ModelBand {
  std::string name;
  std::optional<Band> band;
  std::string text;  ///< with which inputs, or what is missing
};

/// Mean with interval, standard deviation, extremes, span and strongest period of every quantity over the window.
std::vector<ReportNumber> numbers_of(const RunFolder& run, const std::vector<Quantity>& all);
/// Mean draft of each tool over the window of the page, against its travel as the summary has it.
std::vector<ToolDraft> drafts_of(const RunFolder& run);
/// What frames tell: depth, width, speed and rake of the tool, furrow, disturbed area, specific draft.
std::vector<ReportNumber> numbers_of_soil(const RunFolder& run, const ToolPath& tool,
                                          const std::optional<Furrow>& furrow);
/// Burial and direction of fibres, as the summary has them.
std::vector<ReportNumber> numbers_of_fibres(const RunFolder& run);
std::vector<ModelBand> model_bands(const RunFolder& run, const std::optional<ToolPath>& tool,
                                   const std::optional<SoilStrength>& soil);

/// Mean draft over the window; of a run without that column an empty one.
std::optional<WindowStatistics> draft_of(const RunFolder& run);

}  // namespace subsoil::sim
