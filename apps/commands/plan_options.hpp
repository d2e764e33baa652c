#pragma once
#include <CLI/CLI.hpp>

#include "apps/commands/command_pages.hpp"

namespace subsoil::sim {

/// What every command takes that works by a plan: the file, overrides of its values, the folder.
/// @param holds what a plan of this command consists of, for the help
template <class Request>
void add_plan_options(CLI::App& word, Request& request, const std::string& holds) {
  word.add_option("plan", request.plan, "plan (YAML): " + holds)->required()->type_name(takes_yaml);
  word.add_option("--set", request.sets, "override a value of the plan: path=value (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
  word.add_option("--out", request.out, "folder; default: ./<name of the plan>");
}

}  // namespace subsoil::sim
