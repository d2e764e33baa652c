#pragma once
#include <array>
#include <span>
#include <vector>

#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::dem {

using Point2 = std::array<double, 2>;

/// The points of a simple polygon, a repeated first point at the end dropped. Throws std::invalid_argument, naming the
/// points (numbered from 1), when fewer than three remain, two neighbours coincide, or sides touch or cross.
std::vector<Point2> simple_polygon(std::span<const Point2> outline);

/// Triangles of a simple polygon by ear clipping: indices into `outline`, counter-clockwise, every point used, none
/// without area, best-shaped ear first. Refusals as above.
std::vector<Triangle> triangulate_polygon(std::span<const Point2> outline);

/// Signed area of a polygon, positive when it runs counter-clockwise.
double polygon_area(std::span<const Point2> outline);

}  // namespace subsoil::dem
