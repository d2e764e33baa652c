#include "apps/commands/export_command.hpp"

#include <fmt/format.h>

#include "apps/commands/command_pages.hpp"
#include "libsim/post/vtkhdf.hpp"
#include "libsim/run/runner.hpp"

namespace subsoil::sim {

CLI::App* add_export(CLI::App& app, ExportWords& words) {
  CLI::App* word = app.add_subcommand("export", "a run's frames in another program's format");
  word->footer(
      "vtkhdf: VTKHDF 2.0, read back with VTK 9.7. Soil, contact forces and every surface are blocks "
      "of "
      "polygonal data; every frame is a step.\n"
      "Arrays and restrictions: docs/reference/export.md");
  word->add_option("run", words.run, "result directory")->required()->type_name(takes_folder);
  word->add_option("--to", words.to, "the format")->required()->check(CLI::IsMember({"vtkhdf"}));
  word->add_option("--out", words.out, "folder of the files; default: RUN/vtkhdf");
  return word;
}

int export_command(const ExportWords& words) {
  const VtkhdfReport report = write_vtkhdf({.run = words.run, .out = words.out});
  fmt::print("{} step{} in each of\n", report.steps, report.steps == 1 ? "" : "s");
  for (const auto& file : report.files) fmt::print("{}\n", file.string());
  return exit_ok;
}

}  // namespace subsoil::sim
