#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "libsim/fmu/export.hpp"

namespace subsoil::sim {

/// `subsoil fmu`: what stands on the command line.
struct FmuWords {
  FmuRequest request;
  std::string version = "3", step;
};
CLI::App* add_fmu(CLI::App& app, FmuWords& words);
int fmu_command(const FmuWords& words);

}  // namespace subsoil::sim
