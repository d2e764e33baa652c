#pragma once
#include "apps/output/state_file.hpp"
#include "libdem/bed.hpp"

/// A bed in a state file: its arrays under `bed/`.
namespace subsoil::app {

void put_bed_state(StateWriter& out, const dem::Bed::State& bed);
dem::Bed::State bed_state_of(const StateReader& in);

}  // namespace subsoil::app
