#include "apps/commands/view_command.hpp"

#include <fmt/format.h>

#include "apps/commands/command_pages.hpp"
#include "libsim/run/runner.hpp"

namespace subsoil::sim {

CLI::App* add_show(CLI::App& app, ShowRequest& request) {
  CLI::App* word =
      app.add_subcommand("show", "draw a scenario before it runs: one HTML file that opens without network");
  word->footer("What the picture shows and what its symbols mean: docs/reference/show.md");
  word->add_option("scenario", request.scenario, "scenario file (YAML)")->required()->type_name(takes_yaml);
  word->add_option("--out", request.out, "the page; default: ./<name of the scenario>.html");
  word->add_option("--set", request.sets, "override a value of the scenario: path=value (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
  return word;
}

int show_command(ShowRequest request) {
  if (request.out.empty()) request.out = std::filesystem::path(request.scenario).stem().string() + ".html";
  write_show(request);
  fmt::print("{}\n", request.out.string());
  return exit_ok;
}

CLI::App* add_view(CLI::App& app, ViewRequest& request) {
  CLI::App* word = app.add_subcommand("view", "draw a run over time: one HTML file that opens without network");
  word->footer("What the picture shows: docs/reference/view.md");
  word->add_option("run", request.run, "result directory")->required()->type_name(takes_folder);
  word->add_option("--out", request.out, "the page; default: ./<name of the directory>.html");
  word->add_option("--bytes", request.bytes, "of the spheres in the page; frames are left out until they fit")
      ->check(CLI::PositiveNumber);
  return word;
}

int view_command(ViewRequest request) {
  if (request.out.empty()) {
    const std::filesystem::path folder = std::filesystem::absolute(request.run).lexically_normal();
    request.out = (folder.has_filename() ? folder.filename() : folder.parent_path().filename()).string() + ".html";
  }
  write_view(request);
  fmt::print("{}\n", request.out.string());
  return exit_ok;
}

}  // namespace subsoil::sim
