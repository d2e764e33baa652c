#pragma once
#include <string>

#include "libsim/scenario/sections/beams.hpp"

namespace subsoil::sim {

/// What a beam is and how far its elements serve, for `subsoil check`.
std::string beam_words(const BeamSection& beam);

}  // namespace subsoil::sim
