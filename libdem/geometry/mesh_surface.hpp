#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "libdem/geometry/facet.hpp"
#include "libdem/geometry/surface_contact.hpp"
#include "libdem/geometry/triangle_mesh.hpp"
#include "libdem/geometry/triangle_tree.hpp"

namespace subsoil::dem {

/// All triangulated surfaces of one body, ready to answer: where does a sphere touch it?
///
/// Rule: the contacts of a sphere are the local minima of the distance from its centre c over the whole surface of the
/// body, as far as c sees them. A point p is a local minimum if and only if it is the nearest point of every triangle
/// that contains it: triangles are convex, so a nearer point of one of them could be approached along a straight line
/// of falling distance. Each triangle has one nearest point, hence no feature can be counted twice: on a flat floor one
/// contact wherever triangle sides run, at a convex edge one, in a corner of walls two or three; of minima closer than
/// 0.2 of their distance one (hollow curved surfaces). The radius is not in the rule: it holds across a gap as well.
///
/// Two ways to find "every triangle that contains p": the neighbours by shared vertices (fast, settles nearly all), and
/// by position, which also covers surfaces that merely lie against each other and sides that meet between vertices.
/// A minimum that c cannot see, because the body lies between (the far side of a plate, the inner faces of stacked
/// solids), is no contact. On a closed surface only the outside acts; on an open one both sides do.
///
/// A centre inside a closed surface has overlap beyond the radius: the nearest minimum alone is returned, with negative
/// distance and outward normal.
class MeshSurface {
 public:
  explicit MeshSurface(std::span<const TriangleMesh> surfaces);
  explicit MeshSurface(const TriangleMesh& surface) : MeshSurface(std::span(&surface, 1)) {}

  /// Appends to `out`, in ascending order, the triangles within `cutoff` of c (a safe superset by rounding).
  void candidates(const Vec3& c, double cutoff, std::vector<uint32_t>& out) const;

  /// Contacts within `cutoff` of the centre c (axes of the mesh), nearest first, at most `max`; returns their number.
  /// `candidates` in ascending order, holding at least every triangle within the cutoff: result does not depend on
  /// others. At most `max_minima` minima before the test of sight are kept, the nearest ones. Allocates nothing;
  /// thread-safe.
  size_t contacts(const Vec3& c, double cutoff, std::span<const uint32_t> candidates, SurfaceContact* out,
                  size_t max) const;
  static constexpr size_t max_minima = 32;

  /// The flat face that alone can be touched by a sphere whose centre stays within `margin` of c, if it is one face and
  /// the centre stays on its side, above its inside and away from its rim. `candidates` as above, for a cutoff of the
  /// sphere's own plus the margin.
  std::optional<FlatFace> flat_face(const Vec3& c, double margin, std::span<const uint32_t> candidates) const;

  /// The triangle nearest to a point, of equally near ones the first; they are numbered mesh after mesh.
  uint32_t nearest_triangle(const Vec3& point) const;
  size_t triangle_count() const { return facets_.size(); }
  const Bounds& bounds() const { return bounds_; }
  const std::vector<TriangleMesh>& surfaces() const { return surfaces_; }
  std::vector<TriangleMesh> drawing(double) const { return surfaces_; }

 private:
  /// An edge or a vertex: the directions in which the surface leaves it, begin..end in cone_.
  struct Corner {
    uint32_t begin = 0, end = 0;
    uint32_t feature = 0;
    Vec3 outward;  ///< angle-weighted mean normal of the triangles around it
  };
  /// Plain doubles, so that the query's array of them costs nothing until it is written (Vec3 sets itself to zero).
  struct Minimum {
    double x, y, z, distance;
    double order;  // distance, with a handicap of rounding for edges and corners
    uint32_t triangle;
    uint32_t corner;  // edge or vertex in corners_, no_corner on a face
    Vec3 point() const { return {x, y, z}; }
  };
  static constexpr uint32_t no_corner = 0xffffffff;
  struct Tolerance;
  class Builder;
  /// rad: faces and edges that bend by less than this are one feature. Meshes carry bends as noise: float32 corners are
  /// 1e-7 m off, which on triangles of 1 mm is 1e-4 rad. How near to each other minima are one contact is another
  /// length, Tolerance::one_contact.
  static constexpr double same_direction = 1e-3;

  /// Minima as far as shared vertices tell, nearest first, equals in the order of triangles; returns their number.
  size_t find_minima(const Vec3& c, double cutoff, std::span<const uint32_t> candidates, const Tolerance& tolerance,
                     Minimum* minima) const;
  bool leaves_nearer(uint32_t corner, const Vec3& u, double distance, const Tolerance& tolerance) const;
  bool is_minimum_by_position(const Minimum& m, const Vec3& c, std::span<const uint32_t> candidates,
                              const Tolerance& tolerance) const;
  bool is_hidden(const Minimum& m, const Vec3& c, std::span<const uint32_t> candidates,
                 const Tolerance& tolerance) const;
  const Vec3& outward(const Minimum& m) const;
  uint32_t feature(const Minimum& m) const;
  SurfaceContact contact_at(const Minimum& m, const Vec3& c, const Tolerance& tolerance) const;

  std::vector<Facet> facets_;
  std::vector<Corner> corners_;         // edges and vertices of all surfaces
  std::vector<Vec3> cone_;              // unit directions, grouped by corner
  std::vector<uint32_t> face_feature_;  // per facet
  TriangleTree tree_;
  Bounds bounds_;
  double rounding_ = 0;  // m: error of a computed point, from the maximum coordinate
  std::vector<TriangleMesh> surfaces_;
};

}  // namespace subsoil::dem
