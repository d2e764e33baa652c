#pragma once
#include <string>

namespace subsoil::sim {

/// Throws std::runtime_error where the elements and lists of a PLY file ask for more than its bytes hold: a reader
/// would make room for them first. What is no PLY header at all is left to the reader.
void refuse_short_ply(const std::string& file);

}  // namespace subsoil::sim
