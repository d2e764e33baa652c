#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libsim/base/json.hpp"
#include "libsim/report/numbers.hpp"

/// `subsoil report RUN...`: one or several runs as one HTML file that needs nothing beside it.
namespace subsoil::sim {

struct ReportRequest {
  std::vector<std::filesystem::path> runs;  ///< result directories; the first is what others are compared with
  std::filesystem::path out = "report.html";
  std::optional<double> from, until;  ///< s; window of the numbers in place of the runs' own
  bool source = false;                ///< set the 1S-300 source's numbers beside ours
  std::optional<SoilStrength> soil;   ///< for McKyes-Ali
  double slice = 0;                   ///< z of the section, m; used when given
  bool slice_given = false;
};

/// The page's data: what is drawn and the machine-readable table. Throws std::invalid_argument for what is no result
/// directory; what a directory lacks is listed in it.
Json report_data(const ReportRequest& request);
/// Writes the page, complete or not at all, and prints to stderr what was missing.
void write_report(const ReportRequest& request);

/// Cohesion and friction angle from the table `shear.csv` that `subsoil test shear --out FOLDER` leaves. Throws
/// std::invalid_argument when it is not there or lacks them.
SoilStrength read_strength(const std::filesystem::path& folder);

}  // namespace subsoil::sim
