#pragma once
#include <string>

#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::sim {

/// A mesh file (STL, OBJ, PLY) as it is used, and what was wrong with it and could be fixed.
struct MeshFile {
  dem::TriangleMesh mesh;
  std::size_t flat = 0;      ///< triangles without area, dropped
  std::size_t repeated = 0;  ///< triangles that stand there already, wound the same way; dropped
  std::size_t turned = 0;    ///< of a closed mesh: triangles whose corners ran the wrong way round
};

/// `unit` metres per unit of the file's numbers. Throws std::runtime_error naming the file where it cannot be used:
/// missing, no STL, cut off, nothing but triangles without area.
MeshFile load_mesh(const std::string& file, double unit);

}  // namespace subsoil::sim
