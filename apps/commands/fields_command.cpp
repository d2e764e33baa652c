#include "apps/commands/fields_command.hpp"

#include <fmt/format.h>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/quantity_option.hpp"
#include "libsim/post/fields.hpp"
#include "libsim/run/runner.hpp"

namespace subsoil::sim {
namespace {

FieldSection section_of(const std::string& text) {
  if (text.size() < 3 || text[0] < 'x' || text[0] > 'z' || text[1] != '=')
    throw std::invalid_argument(fmt::format("--section {}: is no plane across an axis; write it as z=0mm", text));
  return {text[0] - 'x', quantity_option("--section", text.substr(2), "m", false)};
}

}  // namespace

CLI::App* add_fields(CLI::App& app, FieldsWords& words) {
  CLI::App* word = app.add_subcommand(
      "fields", "coarse-grained density, porosity, velocity and stress of a run's frames on a grid, for ParaView");
  word->footer(
      "Writes RUN/fields.h5 and RUN/fields.xdmf2, which ParaView opens. Contact stress needs frames with "
      "`output.contact forces: yes`.\n"
      "Equations: docs/theory; how to look at them: docs/reference/fields.md");
  word->add_option("run", words.run, "result directory")->required()->type_name(takes_folder);
  word->add_option("--out", words.out, "files OUT.h5 and OUT.xdmf2; default: RUN/fields");
  word->add_option("--kernel", words.kernel,
                   "of the coarse graining, by its width w: lucy ends at 2 w, gaussian at 3 w")
      ->check(CLI::IsMember({"lucy", "gaussian"}));
  word->add_option("--width", words.width, "w, such as \"20 mm\"; default: the mean diameter");
  word->add_option("--spacing", words.spacing,
                   "of the grid, along periodic axes the nearest that divides them; default: half the width, or what "
                   "makes 2 million "
                   "points");
  word->add_option("--section", words.section, "plane in place of the whole bed, such as z=0mm or x=0.4m");
  CLI::Option* times = word->add_option("--times", words.times,
                                        "instants, such as 0.5s,1s: the nearest frames; "
                                        "default: the last frame")
                           ->delimiter(',');
  word->add_flag("--all", words.all, "every frame")->excludes(times);
  return word;
}

int fields_command(const FieldsWords& words) {
  FieldsRequest request;
  request.run = words.run, request.out = words.out, request.all = words.all;
  request.kernel = words.kernel == "lucy" ? FieldKernel::Kind::lucy : FieldKernel::Kind::gaussian;
  if (!words.width.empty()) request.width = quantity_option("--width", words.width, "m", true);
  if (!words.spacing.empty()) request.spacing = quantity_option("--spacing", words.spacing, "m", true);
  if (!words.section.empty()) request.section = section_of(words.section);
  for (const std::string& t : words.times) request.times.push_back(quantity_option("--times", t, "s", false));
  const FieldsReport report = write_fields(request);
  const Vec3& apart = report.grid.spacing;
  const std::string spacing = apart.x == apart.y && apart.y == apart.z
                                  ? fmt::format("{:.4g}", apart.x)
                                  : fmt::format("{:.4g} x {:.4g} x {:.4g}", apart.x, apart.y, apart.z);
  fmt::print("{} frame{} on {} x {} x {} points {} m apart; {} kernel, width {:.4g} m, zero from {:.4g} m on\n",
             report.frames, report.frames == 1 ? "" : "s", report.grid.n[0], report.grid.n[1], report.grid.n[2],
             spacing, words.kernel, report.width, report.reach);
  if (!report.sides.empty()) fmt::print("sides are taken as open, not as periodic: {}\n", report.sides);
  if (!report.has_velocity) fmt::print("no velocity and kinetic stress: output.columns leaves velocities out\n");
  if (!report.has_contacts) fmt::print("no coordination: output.columns leaves contacts out\n");
  if (!report.has_stress) fmt::print("no contact stress: run with `output: {{contact forces: yes}}` for it\n");
  fmt::print("{}\n", report.xdmf.string());
  return exit_ok;
}

}  // namespace subsoil::sim
