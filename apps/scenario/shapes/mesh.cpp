#include "apps/scenario/shapes/mesh.hpp"

#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::app {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Faces = std::vector<std::vector<std::size_t>>;

bool is_ply(const std::string& file) {
  char magic[4] = {};
  std::ifstream(file, std::ios::binary).read(magic, 3);
  return std::string(magic) == "ply";
}

/// Points and faces as the file has them; false: not readable.
bool read_file(const std::string& file, const std::string& kind, std::vector<Point>& points, Faces& faces) {
  try {
    if (kind == "PLY") return CGAL::IO::read_PLY(file, points, faces);
    if (kind == "OBJ") return CGAL::IO::read_OBJ(file, points, faces);
    return CGAL::IO::read_STL(file, points, faces);
  } catch (const std::exception&) {
    return false;
  }
}

/// A fan of triangles from the first corner. Throws std::runtime_error for a face that a fan does not cover: bent, or
/// with a corner that points inward.
void add_fan(const std::vector<Vec3>& face, const std::string& what, std::vector<std::array<Vec3, 3>>& soup) {
  const auto area = [&](std::size_t k) { return cross(face[k] - face[0], face[k + 1] - face[0]); };
  Vec3 sum;
  for (std::size_t k = 1; k + 1 < face.size(); ++k) sum += area(k);
  for (std::size_t k = 1; k + 1 < face.size(); ++k) {
    // Within 1e-3 rad of the face's mean normal.
    if (face.size() > 3 && dot(area(k), sum) < (1 - 5e-7) * norm(area(k)) * norm(sum))
      throw std::runtime_error(
          fmt::format("{} has {} corners and is not flat and convex; cut it into triangles", what, face.size()));
    soup.push_back({face[0], face[k], face[k + 1]});
  }
}

}  // namespace

void MeshShape::describe(Fields& v) {
  v.card("mesh", "triangles of an STL, OBJ or PLY file");
  v.file(
      "mesh", file,
      "STL (binary or text), OBJ or PLY file beside the scenario; binary STL holds numbers of 7 digits, the others as "
      "many as are written");
  v.unit("unit", unit, "m", "unit of the file's numbers");
}

dem::TriangleMesh MeshShape::mesh() const { return read_stl(file, unit); }

dem::TriangleMesh read_stl(const std::string& file, double unit) {
  if (!std::filesystem::exists(file)) throw std::runtime_error(file + ": no such file");
  std::string ending = std::filesystem::path(file).extension();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::string kind = is_ply(file) ? "PLY" : ending == ".obj" ? "OBJ" : "STL";
  std::vector<Point> points;
  Faces faces;
  if (!read_file(file, kind, points, faces) || faces.empty())
    throw std::runtime_error(
        fmt::format("{}: no {} file that can be read (STL, binary or text, OBJ and PLY are)", file, kind));
  std::vector<std::array<Vec3, 3>> soup;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::string what = fmt::format("{}: face {}", file, f + 1);
    if (faces[f].size() < 3) throw std::runtime_error(what + " has fewer than three corners");
    std::vector<Vec3> corners;
    for (const std::size_t k : faces[f]) {
      if (k >= points.size())
        throw std::runtime_error(fmt::format("{} names vertex {} of {}", what, k + 1, points.size()));
      corners.push_back(Vec3{points[k].x(), points[k].y(), points[k].z()} * unit);
    }
    add_fan(corners, what, soup);
  }
  return dem::welded_mesh(soup);
}

}  // namespace subsoil::app
