#pragma once
#include <CLI/CLI.hpp>

#include "libsim/view/show.hpp"
#include "libsim/view/view.hpp"

namespace subsoil::sim {

/// `subsoil show`: a picture of what will run.
CLI::App* add_show(CLI::App& app, ShowRequest& request);
int show_command(ShowRequest request);

/// `subsoil view`: a picture of what has run.
CLI::App* add_view(CLI::App& app, ViewRequest& request);
int view_command(ViewRequest request);

}  // namespace subsoil::sim
