#pragma once
#include <filesystem>
#include <string>

#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::sim {

/// Writes a mesh as STL text, in metres with every digit: binary STL has seven, in which a layer of micrometres drowns.
/// Throws std::runtime_error where the file cannot be written.
void write_stl(const std::filesystem::path& path, const dem::TriangleMesh& mesh, const std::string& name);
/// What it writes.
std::string stl_text(const dem::TriangleMesh& mesh, const std::string& name);

}  // namespace subsoil::sim
