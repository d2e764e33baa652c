#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace subsoil::sim {

/// `subsoil optimise` and `subsoil sensitivity`: a plan and a folder.
struct DesignRequest {
  std::string plan;
  std::vector<std::string> sets;  ///< path=value of the plan
  std::string out;                ///< folder; empty: named like the plan
  int threads = 0;                ///< cores of each run; 0: as in the plan
};
CLI::App* add_optimise(CLI::App& app, DesignRequest& request);
CLI::App* add_sensitivity(CLI::App& app, DesignRequest& request);
int optimise_command(const DesignRequest& request);
int sensitivity_command(const DesignRequest& request);

}  // namespace subsoil::sim
