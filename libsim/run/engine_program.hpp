#pragma once
#include <filesystem>

#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

/// The program that steps soil by LIGGGHTS: beside this one. It is one of its own since LIGGGHTS is under the GPL.
std::filesystem::path engine_program();

/// Continues as that program, with the same command line, where the scenario asks for it; returns where it does not.
/// Throws ScenarioError where it should be and is not.
void go_on_as_engine(const Loaded& loaded);

}  // namespace subsoil::sim
