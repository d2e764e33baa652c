#pragma once
#include <string>

#include "bench/bed_case.hpp"

/// The same case for LAMMPS and LIGGGHTS: spheres as a data file that both read, the tool as STL, and every number of
/// the case as a `variable` line, so that no input in bench/peers/ repeats one.
namespace subsoil::bench {

/// Writes bed.data, case.in and, with a tool, tool.stl into the folder; `bed` as filled, before its first step.
/// Throws std::invalid_argument for a law that the others do not have.
void write_peer_files(const std::string& folder, const Case& c, const dem::Bed& bed);

}  // namespace subsoil::bench
