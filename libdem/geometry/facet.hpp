#pragma once
#include <cmath>
#include <cstdint>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// Part of a triangle: its face, one of its edges (edge i from corner i to i + 1) or one of its corners.
enum class Part : uint8_t { face, edge0, edge1, edge2, corner0, corner1, corner2 };

/// A triangle prepared for distances. Reader: the contact sweep, once per sphere and candidate, at random places in
/// the array; writer: nobody after the build. 304 bytes, most of which the query touches. Everything that needs a
/// division or a root is stored; gathering corners through the index list instead cost two more cache lines and the
/// roots. What only accepted contacts need (outward directions of edges and corners) lives in MeshSurface.
struct Facet {
  Vec3 corner[3];
  Vec3 normal;              ///< unit
  Vec3 aside[3];            ///< unit, in the plane, across edge i and away from the triangle
  Vec3 along[3];            ///< unit, edge i from corner i to corner i + 1
  double length[3];         ///< m, of edge i
  double rounding;          ///< m, of a place computed near the triangle: so far beyond an edge is still above the face
  uint32_t part_corner[6];  ///< edges 0..2 and corners 0..2 in MeshSurface's list
  uint32_t surface;
  bool sided;  ///< of a closed surface: only the outside acts

  static Facet from(const Vec3& a, const Vec3& b, const Vec3& c);
};

/// Nearest point of a triangle.
struct Nearest {
  Vec3 point;
  double distance_squared;
  Part part;
};

/// Nearest point of the triangle to c. The three edge planes decide: inside all of them the foot of the perpendicular
/// is it, else the nearest point of the edges that c lies beyond (a point outside a convex polygon has its nearest
/// point on a side that it sees). No barycentric division, which loses (length/height)^2 digits on slivers.
inline Nearest nearest_point(const Facet& f, const Vec3& c) {
  double beyond[3];
  for (int i = 0; i < 3; ++i) beyond[i] = dot(c - f.corner[i], f.aside[i]);
  if (beyond[0] <= f.rounding && beyond[1] <= f.rounding && beyond[2] <= f.rounding) {
    const double height = dot(c - f.corner[0], f.normal);
    return {c - height * f.normal, height * height, Part::face};
  }
  Nearest best{{}, INFINITY, Part::face};
  for (int i = 0; i < 3; ++i) {
    if (beyond[i] <= 0) continue;
    const int next = i == 2 ? 0 : i + 1;
    const double t = dot(c - f.corner[i], f.along[i]);
    const bool at_start = t <= 0, at_end = t >= f.length[i];
    const Vec3 p = at_start ? f.corner[i] : at_end ? f.corner[next] : f.corner[i] + t * f.along[i];
    const Vec3 u = c - p;
    const double d2 = dot(u, u);
    if (d2 < best.distance_squared) best = {p, d2, static_cast<Part>(at_start ? 4 + i : at_end ? 4 + next : 1 + i)};
  }
  return best;
}

}  // namespace subsoil::dem
