#pragma once
#include <string>

#include "libsim/scenario/shapes/shape.hpp"

namespace subsoil::sim {

/// Triangles of an STL, OBJ or PLY file.
struct MeshShape {
  std::string file;        // absolute path
  double unit = required;  // metres per unit of the file's numbers

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const { return {}; }
  dem::TriangleMesh mesh() const;
};

/// Reads an STL, OBJ or PLY file in double; `unit` metres per unit of the file. Throws std::runtime_error naming it.
dem::TriangleMesh read_mesh(const std::string& file, double unit);

}  // namespace subsoil::sim
