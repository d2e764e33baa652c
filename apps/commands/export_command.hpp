#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace subsoil::sim {

/// `subsoil export`: what stands on the command line.
struct ExportWords {
  std::string run, to, out;
};
CLI::App* add_export(CLI::App& app, ExportWords& words);
int export_command(const ExportWords& words);

}  // namespace subsoil::sim
