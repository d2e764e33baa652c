#pragma once
#include <string>

#include "apps/scenario/sections/beams.hpp"

namespace subsoil::app {

/// What a beam is and how far its elements serve, for `subsoil check`.
std::string beam_words(const BeamSection& beam);

}  // namespace subsoil::app
