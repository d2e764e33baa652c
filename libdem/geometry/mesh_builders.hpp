#pragma once
#include <array>
#include <span>
#include <vector>

#include "libdem/geometry/polygon.hpp"
#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::dem {

/// Box with edges along the axes, closed.
TriangleMesh box_mesh(const Vec3& size, const Vec3& centre = {});

/// Flat rectangle corner, corner + u, corner + u + v, corner + v; open, normal along u x v.
TriangleMesh rectangle_mesh(const Vec3& corner, const Vec3& u, const Vec3& v);

/// Prism over a simple polygon in the x-y plane from z = -width/2 to +width/2, closed. The outline may run either way
/// and may repeat its first point at the end. Refuses what simple_polygon refuses, and a width that is not positive.
TriangleMesh extruded_mesh(std::span<const Point2> outline, double width);

/// Closed circular cylinder of `segments` flat sides whose corners lie on the radius; for drawing.
TriangleMesh cylinder_mesh(const Vec3& centre, const Vec3& axis, double radius, double length, int segments = 48);

/// The same with a bore along its axis.
TriangleMesh tube_mesh(const Vec3& centre, const Vec3& axis, double inner_radius, double radius, double length,
                       int segments = 48);

/// Icosahedron divided `subdivisions` times, corners on the radius, closed.
TriangleMesh icosphere_mesh(double radius, int subdivisions);

/// Mesh from loose triangles (what an STL file holds): corners nearer than `weld` metres become one vertex;
/// weld <= 0: 1e-6 of the bounding box' diagonal, some ten times the rounding of a float32 file.
TriangleMesh welded_mesh(std::span<const std::array<Vec3, 3>> soup, double weld = 0);

}  // namespace subsoil::dem
