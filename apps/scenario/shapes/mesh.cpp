#include "apps/scenario/shapes/mesh.hpp"

#include <admesh/stl.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::app {

void MeshShape::describe(Fields& v) {
  v.card("mesh", "triangles of an STL file");
  v.file("mesh", file, "STL file (binary or text) beside the scenario");
  v.unit("unit", unit, "m", "unit of the file's numbers");
}

dem::TriangleMesh MeshShape::mesh() const { return read_stl(file, unit); }

dem::TriangleMesh read_stl(const std::string& file, double unit) {
  if (!std::filesystem::exists(file)) throw std::runtime_error(file + ": no such file");
  stl_file stl{};
  std::string name = file;
  stl_open(&stl, name.data());
  if (stl_get_error(&stl) != 0 || stl.stats.number_of_facets <= 0) {
    stl_close(&stl);
    throw std::runtime_error(file + ": no STL file that can be read (binary or ASCII triangles are expected)");
  }
  std::vector<std::array<Vec3, 3>> soup;
  for (int i = 0; i < stl.stats.number_of_facets; ++i) {
    std::array<Vec3, 3> t;
    for (std::size_t k = 0; k < 3; ++k) {
      const stl_vertex& v = stl.facet_start[i].vertex[k];
      t[k] = Vec3{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)} * unit;
    }
    soup.push_back(t);
  }
  stl_close(&stl);
  return dem::welded_mesh(soup);
}

}  // namespace subsoil::app
