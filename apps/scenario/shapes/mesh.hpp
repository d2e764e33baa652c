#pragma once
#include <string>

#include "apps/scenario/shapes/shape.hpp"

namespace subsoil::app {

/// Triangles of an STL file.
struct MeshShape {
  std::string file;        // absolute path
  double unit = required;  // metres per unit of the file's numbers

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const { return {}; }
  dem::TriangleMesh mesh() const;
};

/// Reads an STL file (binary or ASCII); `unit` metres per unit of the file. Throws std::runtime_error naming the file.
dem::TriangleMesh read_stl(const std::string& file, double unit);

}  // namespace subsoil::app
