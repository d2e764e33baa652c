#pragma once
#include <string>

#include "libdem/bed.hpp"
#include "libsim/io/state_file.hpp"

/// A bed in a state file: its arrays under `bed/`.
namespace subsoil::sim {

/// Spheres, pairs and contacts at surfaces of a bed, under a folder such as `bed/`.
void put_spheres(StateWriter& out, const std::string& folder, const dem::Bed::State& bed);
void read_spheres(const StateReader& in, const std::string& folder, dem::Bed::State& bed);

void put_bed_state(StateWriter& out, const dem::Bed::State& bed);
dem::Bed::State bed_state_of(const StateReader& in);

}  // namespace subsoil::sim
