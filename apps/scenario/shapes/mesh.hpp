#pragma once
#include <string>

#include "apps/scenario/shapes/shape.hpp"

namespace subsoil::app {

/// Triangles of an STL, OBJ or PLY file.
struct MeshShape {
  std::string file;        // absolute path
  double unit = required;  // metres per unit of the file's numbers

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const { return {}; }
  dem::TriangleMesh mesh() const;
};

/// Reads an STL (binary or text), OBJ or PLY file in double precision; `unit` metres per unit of the file. Corners
/// nearer than 1e-6 of the mesh's diagonal are one vertex; faces of more than three corners, flat and convex, are cut
/// into triangles. Throws std::runtime_error naming the file.
dem::TriangleMesh read_mesh(const std::string& file, double unit);

}  // namespace subsoil::app
