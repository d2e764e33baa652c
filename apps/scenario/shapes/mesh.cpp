#include "apps/scenario/shapes/mesh.hpp"

#include <admesh/stl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <vector>

#include "apps/scenario/shapes/stl_file.hpp"
#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::app {

void MeshShape::describe(Fields& v) {
  v.card("mesh", "triangles of an STL file");
  v.file("mesh", file, "STL file (binary or text) beside the scenario");
  v.unit("unit", unit, "m", "unit of the file's numbers");
}

dem::TriangleMesh MeshShape::mesh() const { return read_stl(file, unit); }

namespace {

/// Binary files say how many triangles they have, text ends with a word: what is cut off is not taken for all of it.
void refuse_cut_off(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  std::uint32_t count = 0;
  if (text.size() >= 84) std::memcpy(&count, text.data() + 80, 4);
  const std::size_t wanted = 84 + 50 * static_cast<std::size_t>(count);
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  const bool is_text = begin != std::string::npos && text.compare(begin, 5, "solid") == 0 &&
                       text.find("facet") != std::string::npos && wanted != text.size();
  if (is_text) {
    const std::size_t vertices = text.rfind("endfacet"), end = text.rfind("endsolid");
    if (end == std::string::npos || (vertices != std::string::npos && end < vertices))
      throw std::runtime_error(file + ": is cut off: the text ends without `endsolid`; export it again");
  } else if (text.size() > 84 && text.size() < wanted && wanted < 100 * text.size()) {
    throw std::runtime_error(
        fmt::format("{}: is cut off: it says {} triangles, which take {} bytes, and has {}; export "
                    "it again",
                    file, count, wanted, text.size()));
  }
}

using Facet = std::array<Vec3, 3>;

std::vector<Facet> facets_of(const std::string& file, double unit) {
  stl_file stl{};
  std::string name = file;
  stl_open(&stl, name.data());
  if (stl_get_error(&stl) != 0 || stl.stats.number_of_facets <= 0) {
    stl_close(&stl);
    throw std::runtime_error(file + ": no STL file that can be read (binary or ASCII triangles are expected)");
  }
  std::vector<Facet> soup;
  for (int i = 0; i < stl.stats.number_of_facets; ++i) {
    Facet t;
    for (std::size_t k = 0; k < 3; ++k) {
      const stl_vertex& v = stl.facet_start[i].vertex[k];
      t[k] = Vec3{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)} * unit;
    }
    soup.push_back(t);
  }
  stl_close(&stl);
  return soup;
}

/// Facets whose corners weld to less than three, or lie on a line. Without them the others still fit together: the two
/// sides that are left of one lie on each other.
std::size_t drop_flat(std::vector<Facet>& soup) {
  dem::Bounds box;
  for (const Facet& t : soup)
    for (const Vec3& p : t) box.include(p);
  const double weld = 1e-6 * box.diagonal();
  return std::erase_if(soup, [&](const Facet& t) {
    const double ab = dem::norm(t[1] - t[0]), bc = dem::norm(t[2] - t[1]), ca = dem::norm(t[0] - t[2]);
    const double longest = std::max({ab, bc, ca});
    return std::min({ab, bc, ca}) <= weld ||
           dem::norm(dem::area_vector(t[0], t[1], t[2])) <= dem::TriangleMesh::flatness * longest * longest;
  });
}

}  // namespace

StlFile load_stl(const std::string& file, double unit) {
  if (!std::filesystem::exists(file)) throw std::runtime_error(file + ": no such file");
  refuse_cut_off(file);
  std::vector<Facet> soup = facets_of(file, unit);
  const std::size_t flat = drop_flat(soup);
  if (soup.empty()) throw std::runtime_error(file + ": no triangle has an area");
  StlFile out{dem::welded_mesh(soup), flat, 0};
  for (std::size_t i = 0; i < soup.size(); ++i)
    if (dem::dot(dem::area_vector(soup[i][0], soup[i][1], soup[i][2]), out.mesh.normal(i)) < 0) ++out.turned;
  return out;
}

dem::TriangleMesh read_stl(const std::string& file, double unit) { return load_stl(file, unit).mesh; }

}  // namespace subsoil::app
