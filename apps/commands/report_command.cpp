#include "apps/commands/report_command.hpp"

#include <fmt/format.h>

#include <numbers>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/page_option.hpp"
#include "apps/commands/quantity_option.hpp"

namespace subsoil::sim {
namespace {

double stress_of(const char* flag, const std::string& text) {
  const double value = quantity_option(flag, text, "Pa", false);
  if (!(value >= 0)) throw std::invalid_argument(fmt::format("{} {}: must not be negative", flag, text));
  return value;
}

/// Of a slope that a soil or a surface can have.
double friction_angle_of(const char* flag, const std::string& text) {
  const double value = quantity_option(flag, text, "rad", false);
  if (!(value >= 0 && value < 0.5 * std::numbers::pi))
    throw std::invalid_argument(fmt::format("{} {}: must be from 0 to below 90 deg", flag, text));
  return value;
}

}  // namespace

CLI::App* add_report(CLI::App& app, ReportWords& words) {
  CLI::App* word = app.add_subcommand("report", "one or several runs as one HTML file that opens without network");
  word->footer(
      "The first run is what the others are compared with. Parts that a result directory lacks are named on the\n"
      "page and on stderr. What the page shows and how it is found: docs/reference/report.md");
  word->add_option("runs", words.runs, "result directories")->required()->type_name(takes_folder);
  word->add_option("--out", words.out, "the page; default: report.html");
  word->add_option("--from", words.from,
                   "window of the numbers begins here, such as \"1.2 s\"; default: the run's own");
  word->add_option("--until", words.until, "and ends here");
  word->add_option("--slice", words.slice, "z of the section; default: the middle of the tool");
  word->add_flag("--source", words.source, "set the numbers of the 1S-300's source beside the runs'");
  CLI::Option* shear = word->add_option("--shear", words.shear,
                                        "folder of `subsoil test shear`: cohesion and friction angle for McKyes-Ali");
  word->add_option("--cohesion", words.cohesion, "of the soil, such as \"18 kPa\"")->excludes(shear);
  word->add_option("--friction-angle", words.friction, "of the soil, such as \"19.5 deg\"")->excludes(shear);
  word->add_option("--wall-friction", words.wall_friction,
                   "angle between soil and tool; default: 2/3 of the friction angle");
  word->add_option("--adhesion", words.adhesion, "between soil and tool; default: none");
  return word;
}

int report_command(const ReportWords& words) {
  ReportRequest request;
  request.runs.assign(words.runs.begin(), words.runs.end());
  request.out = words.out;
  require_page_name(request.out, "for a PNG of curves or of the furrow use `subsoil plot`");
  request.source = words.source;
  if (!words.from.empty()) request.from = quantity_option("--from", words.from, "s", false);
  if (!words.until.empty()) request.until = quantity_option("--until", words.until, "s", false);
  if (!words.slice.empty())
    request.slice = quantity_option("--slice", words.slice, "m", false), request.slice_given = true;
  if (words.cohesion.empty() != words.friction.empty())
    throw std::invalid_argument("--cohesion and --friction-angle belong together; give both, or --shear FOLDER");
  if (!words.shear.empty()) request.soil = read_strength(words.shear);
  if (!words.cohesion.empty())
    request.soil = SoilStrength{.cohesion = stress_of("--cohesion", words.cohesion),
                                .friction = friction_angle_of("--friction-angle", words.friction),
                                .wall_friction = {}};
  if (!request.soil && !(words.wall_friction.empty() && words.adhesion.empty()))
    throw std::invalid_argument(
        "--wall-friction and --adhesion need the soil's strength; give --shear FOLDER, or --cohesion and "
        "--friction-angle");
  if (!words.wall_friction.empty())
    request.soil->wall_friction = friction_angle_of("--wall-friction", words.wall_friction);
  if (!words.adhesion.empty()) request.soil->adhesion = stress_of("--adhesion", words.adhesion);
  write_report(request);
  fmt::print("{}\n", request.out.string());
  return exit_ok;
}

}  // namespace subsoil::sim
