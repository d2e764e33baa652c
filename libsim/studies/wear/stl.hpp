#pragma once
#include <string>

#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::sim {

/// A mesh as STL text, in metres with every digit: binary STL has seven, in which a layer of micrometres drowns.
std::string stl_text(const dem::TriangleMesh& mesh, const std::string& name);

}  // namespace subsoil::sim
