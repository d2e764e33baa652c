#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "libsim/report/report.hpp"
#include "libsim/run/runner.hpp"

namespace subsoil::sim {

/// `subsoil report` as typed: values with their units are read later, so that a refusal names the flag.
struct ReportWords {
  std::vector<std::string> runs;
  std::string out = "report.html", from, until, slice, shear, cohesion, friction, wall_friction, adhesion;
  bool source = false;
};
CLI::App* add_report(CLI::App& app, ReportWords& words);
int report_command(const ReportWords& words);

}  // namespace subsoil::sim
