#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace subsoil::sim {

/// `subsoil wear`: what stands on the command line.
struct WearWords {
  std::string run, out, spread, width, length, law, pictures = "svg";
  std::vector<double> hectares, passes;
  bool repeat = false;
  int threads = 1;
};
CLI::App* add_wear(CLI::App& app, WearWords& words);
int wear_command(const WearWords& words);

}  // namespace subsoil::sim
