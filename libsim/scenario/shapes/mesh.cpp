#include "libsim/scenario/shapes/mesh.hpp"

#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/geometry/mesh_edges.hpp"
#include "libsim/base/byte_order_mark.hpp"
#include "libsim/base/input_limits.hpp"
#include "libsim/scenario/shapes/mesh_file.hpp"
#include "libsim/scenario/shapes/mesh_text.hpp"
#include "libsim/scenario/shapes/ply_length.hpp"

namespace subsoil::sim {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Facet = std::array<Vec3, 3>;
using Faces = std::vector<std::vector<std::size_t>>;

std::string content_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Points and faces as the content has them; false: not readable.
bool read_content(const std::string& kind, const std::string& content, std::vector<Point>& points, Faces& faces) {
  try {
    std::istringstream in(content);
    if (kind == "PLY") return CGAL::IO::read_PLY(in, points, faces);
    return kind == "OBJ" ? CGAL::IO::read_OBJ(in, points, faces) : CGAL::IO::read_STL(in, points, faces);
  } catch (const std::exception&) {
    return false;
  }
}

/// A fan of triangles from the first corner. Throws std::runtime_error for a face that a fan does not cover: bent, or
/// with a corner that points inward.
void add_fan(const std::vector<Vec3>& face, const std::string& what, std::vector<Facet>& soup) {
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

[[noreturn]] void refuse_many(const std::string& file, std::size_t count) {
  throw std::runtime_error(fmt::format("{}: has {} triangles; a mesh may have {}: mesh the surface more coarsely{}",
                                       file, count, input_limits().triangles, allow_more("triangles")));
}

/// Before anything is read: a triangle takes 50 bytes of a binary file, some 250 of text.
void refuse_long(const std::string& file) {
  const std::uintmax_t bytes = std::filesystem::file_size(file), most = 400 * input_limits().triangles;
  if (bytes > most)
    throw std::runtime_error(fmt::format("{}: has {} bytes; with {} triangles at most it may have {}{}", file, bytes,
                                         input_limits().triangles, most, allow_more("triangles")));
  std::array<char, 84> head{};
  std::ifstream in(file, std::ios::binary);
  std::uint32_t count = 0;
  if (!in.read(head.data(), head.size())) return;
  std::memcpy(&count, head.data() + 80, 4);
  const bool binary_stl = bytes == 84 + 50 * static_cast<std::uintmax_t>(count);
  if (binary_stl && count > input_limits().triangles) refuse_many(file, count);
}

/// Triangles that share one edge: two of a solid, some more where bodies touch. What holds a crowd of them at one edge
/// holds the same triangle over and over, and costs the square of their number.
void refuse_crowded_edges(const std::string& file, const dem::TriangleMesh& mesh) {
  constexpr std::size_t most = 64;
  for (const dem::MeshEdge& edge : dem::MeshEdges(mesh.triangles()).edges) {
    if (edge.end - edge.begin <= most) continue;
    const Vec3 &a = mesh.vertices()[edge.low], &b = mesh.vertices()[edge.high];
    throw std::runtime_error(
        fmt::format("{}: {} triangles meet at the edge from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}) m; at "
                    "most {} may: remove those that stand several times",
                    file, edge.end - edge.begin, a.x, a.y, a.z, b.x, b.y, b.z, most));
  }
}

/// Binary files say how many triangles they have, text ends with a word: what is cut off is not taken for all of it.
void refuse_cut_off(const std::string& file, const std::string& content, const std::string& text) {
  const std::size_t wanted = bytes_of_binary(content), bytes = content.size();
  if (!text.empty()) {
    const std::size_t vertices = text.rfind("endfacet"), end = text.rfind("endsolid");
    if (end == std::string::npos || (vertices != std::string::npos && end < vertices))
      throw std::runtime_error(file + ": is cut off: the text ends without `endsolid`; export it again");
  } else if (bytes > 84 && bytes < wanted && wanted < 100 * bytes) {
    throw std::runtime_error(
        fmt::format("{}: is cut off: it declares {} triangles, which take {} bytes, and has {}; export "
                    "it again",
                    file, (wanted - 84) / 50, wanted, bytes));
  }
}

/// The content of a file as a reader takes it, after the faults that the reader would not see.
std::string readable(const std::string& file, const std::string& kind, std::string content) {
  if (kind == "PLY") {
    refuse_short_ply(file, content);
    return content;
  }
  if (kind == "OBJ") return plain_obj(file, content);
  std::string text = plain_stl(content);
  refuse_cut_off(file, content, text);
  if (!text.empty()) return text;
  if (content.size() >= 84 && bytes_of_binary(content) <= content.size()) refuse_no_numbers(file, content);
  return content;
}

[[noreturn]] void refuse_unreadable(const std::string& file, const std::string& kind, const std::string& content) {
  const std::string word = kind == "PLY" ? "" : kind == "OBJ" ? "v" : "vertex";
  const std::string commas = decimal_commas(content, word);
  throw std::runtime_error(
      commas.empty() ? fmt::format("{}: no {} file that can be read (STL, binary or text, OBJ and PLY are)", file, kind)
                     : fmt::format("{}: {}", file, commas));
}

std::vector<Facet> facets_of(const std::string& file, double unit) {
  refuse_long(file);
  std::string content = content_of(file);
  content = std::string(without_byte_order_mark(content));
  const std::string ending = lower(std::filesystem::path(file).extension());
  const std::string kind = content.starts_with("ply") ? "PLY" : ending == ".obj" ? "OBJ" : "STL";
  // The 80 bytes before a binary STL file may hold anything.
  const bool binary_stl = kind == "STL" && content.size() >= 84 && bytes_of_binary(content) == content.size();
  if (const std::string other = binary_stl ? std::string() : other_format(content); !other.empty())
    throw std::runtime_error(fmt::format("{}: {}", file, other));
  std::vector<Point> points;
  Faces faces;
  if (!read_content(kind, readable(file, kind, content), points, faces) || faces.empty())
    refuse_unreadable(file, kind, content);
  std::size_t triangles = 0;
  for (const auto& face : faces) triangles += face.size() - std::min<std::size_t>(face.size(), 2);
  if (triangles > input_limits().triangles) refuse_many(file, triangles);
  std::vector<Facet> soup;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::string what = fmt::format("{}: face {}", file, f + 1);
    if (faces[f].size() < 3) throw std::runtime_error(what + " has fewer than three corners");
    std::vector<Vec3> corners;
    for (const std::size_t k : faces[f]) {
      if (k >= points.size())
        throw std::runtime_error(fmt::format("{} names vertex {} of {}", what, k + 1, points.size()));
      corners.push_back(Vec3{points[k].x(), points[k].y(), points[k].z()} * unit);
      if (!(dem::norm(corners.back()) < 1e30))
        throw std::runtime_error(
            fmt::format("{} has the vertex {} at ({:g}, {:g}, {:g}), which no metre reaches; export the mesh again",
                        what, k + 1, points[k].x(), points[k].y(), points[k].z()));
    }
    add_fan(corners, what, soup);
  }
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

/// Facets whose corners and sense are those of one before. Of both senses is a sheet that is seen from both sides, or
/// the face at which two solids touch.
std::size_t drop_repeated(const dem::TriangleMesh& mesh, std::vector<Facet>& soup) {
  std::map<std::array<std::uint32_t, 3>, std::vector<Vec3>> seen;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < soup.size(); ++i) {
    auto corners = mesh.triangles()[i];
    std::sort(corners.begin(), corners.end());
    const Vec3 area = dem::area_vector(soup[i][0], soup[i][1], soup[i][2]);
    std::vector<Vec3>& there = seen[{corners[0], corners[1], corners[2]}];
    if (std::any_of(there.begin(), there.end(), [&](const Vec3& other) { return dem::dot(area, other) > 0; })) continue;
    there.push_back(area);
    soup[kept++] = soup[i];
  }
  const std::size_t repeated = soup.size() - kept;
  soup.resize(kept);
  return repeated;
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

dem::TriangleMesh MeshShape::mesh() const { return read_mesh(file, unit); }

MeshFile load_mesh(const std::string& file, double unit) {
  if (!std::filesystem::exists(file)) throw std::runtime_error(file + ": no such file");
  std::vector<Facet> soup = facets_of(file, unit);
  const std::size_t flat = drop_flat(soup);
  if (soup.empty()) throw std::runtime_error(file + ": no face has an area");
  MeshFile out{.mesh = dem::welded_mesh(soup), .flat = flat};
  refuse_crowded_edges(file, out.mesh);
  out.repeated = drop_repeated(out.mesh, soup);
  if (out.repeated > 0) out.mesh = dem::welded_mesh(soup);
  for (std::size_t i = 0; i < soup.size(); ++i)
    if (dem::dot(dem::area_vector(soup[i][0], soup[i][1], soup[i][2]), out.mesh.normal(i)) < 0) ++out.turned;
  return out;
}

dem::TriangleMesh read_mesh(const std::string& file, double unit) { return load_mesh(file, unit).mesh; }

}  // namespace subsoil::sim
