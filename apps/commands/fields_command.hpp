#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace subsoil::sim {

/// `subsoil fields`: what stands on the command line.
struct FieldsWords {
  std::string run, out, kernel = "lucy", width, spacing, section;
  std::vector<std::string> times;
  bool all = false;
};
CLI::App* add_fields(CLI::App& app, FieldsWords& words);
int fields_command(const FieldsWords& words);

}  // namespace subsoil::sim
