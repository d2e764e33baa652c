#pragma once
#include <string>

namespace subsoil::sim {

/// Throws std::runtime_error where the elements and lists of a PLY file ask for more than its bytes hold: a reader
/// would make room for them first. Also where triangles stand as strips, which the reader passes over.
/// @param file for messages @param content of the file
void refuse_short_ply(const std::string& file, const std::string& content);

}  // namespace subsoil::sim
