#pragma once
#include <CLI/CLI.hpp>

#include "libsim/run/runner.hpp"
#include "libsim/view/serve.hpp"
#include "libsim/view/show.hpp"
#include "libsim/view/view.hpp"

namespace subsoil::sim {

/// `subsoil show`: a picture of what will run.
CLI::App* add_show(CLI::App& app, ShowRequest& request);
int show_command(ShowRequest request);

/// `subsoil view`: a picture of what has run, or runs.
struct ViewWords {
  ViewRequest page;
  ServeRequest served;
  bool serve = false;
};
CLI::App* add_view(CLI::App& app, ViewWords& words);
int view_command(const ViewWords& words);

/// `subsoil run --view`: lets another process serve the folder as soon as the run has opened it.
void view_when_opened(RunRequest& request);

}  // namespace subsoil::sim
