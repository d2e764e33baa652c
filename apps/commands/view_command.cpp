#include "apps/commands/view_command.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/page_option.hpp"
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
  require_page_name(request.out, "for a PNG open the page and press its button PNG");
  write_show(request);
  fmt::print("{}\n", request.out.string());
  return exit_ok;
}

CLI::App* add_view(CLI::App& app, ViewWords& words) {
  CLI::App* word = app.add_subcommand("view", "draw a run over time: one HTML file that opens without network");
  word->footer("What the picture shows: docs/reference/view.md");
  word->add_option("run", words.page.run, "result directory")->required()->type_name(takes_folder);
  CLI::Option* const out =
      word->add_option("--out", words.page.out, "the page; default: ./<name of the directory>.html");
  CLI::Option* const bytes =
      word->add_option("--bytes", words.page.bytes, "of the spheres in the page; frames are left out until they fit")
          ->check(CLI::PositiveNumber);
  CLI::Option* const serve =
      word->add_flag("--serve", words.serve,
                     "serve the page to this computer: frames are read on demand, a run in progress is followed");
  serve->excludes(out)->excludes(bytes);
  word->add_option("--port", words.served.port,
                   "with --serve: port of the loopback interface; default: one that is free")
      ->check(CLI::Range(1, 65535))
      ->needs(serve);
  word->add_option("--idle", words.served.idle, "with --serve: seconds without a request after which it ends; 0: never")
      ->check(CLI::NonNegativeNumber)
      ->needs(serve);
  return word;
}

int view_command(const ViewWords& words) {
  if (words.serve) {
    ServeRequest served = words.served;
    served.run = words.page.run;
    serve_run(served, [](const std::string& address) {
      fmt::print("{}\n", address);
      std::fflush(stdout);
    });
    return exit_ok;
  }
  ViewRequest request = words.page;
  if (request.out.empty()) {
    const std::filesystem::path folder = std::filesystem::absolute(request.run).lexically_normal();
    request.out = (folder.has_filename() ? folder.filename() : folder.parent_path().filename()).string() + ".html";
  }
  require_page_name(request.out, "for a PNG open the page and press its button PNG, or use `subsoil plot`");
  write_view(request);
  fmt::print("{}\n", request.out.string());
  return exit_ok;
}

void view_when_opened(RunRequest& request) {
  request.opened = [](const std::filesystem::path& folder) {
    // A process of its own: the HDF5 library is for one thread, and the picture must not slow the run's.
    std::vector<std::string> words{"subsoil", "view", folder.string(), "--serve", "--idle", "60"};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t child = 0;
    if (const int error = posix_spawn(&child, "/proc/self/exe", nullptr, nullptr, arguments.data(), environ);
        error != 0)
      throw std::runtime_error(fmt::format("--view: the program could not be started again: {}", std::strerror(error)));
  };
}

}  // namespace subsoil::sim
