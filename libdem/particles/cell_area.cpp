#include "libdem/particles/cell_area.hpp"

#include <utility>

#include "libdem/geometry/bounds.hpp"

namespace subsoil::dem {
namespace {

/// What of a convex polygon lies at sign (x[d] - limit) <= 0.
std::vector<Vec3> cut(const std::vector<Vec3>& polygon, int d, double limit, double sign) {
  std::vector<Vec3> out;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double beyond_a = sign * (a[d] - limit), beyond_b = sign * (b[d] - limit);
    if (beyond_a <= 0) out.push_back(a);
    if ((beyond_a <= 0) != (beyond_b <= 0)) out.push_back(a + (b - a) * (beyond_a / (beyond_a - beyond_b)));
  }
  return out;
}

}  // namespace

std::vector<Vec3> within(std::vector<Vec3> polygon, const PeriodicCell& cell, const std::array<bool, 3>& wanted) {
  for (int d = 0; d < 3; ++d) {
    if (cell.length[d] == 0 || !wanted[static_cast<std::size_t>(d)]) continue;
    polygon = cut(cut(polygon, d, cell.low[d], -1), d, cell.low[d] + cell.length[d], 1);
  }
  return polygon;
}

std::array<bool, 3> spanned(const Bounds& box, const PeriodicCell& cell) {
  std::array<bool, 3> out{};
  for (int d = 0; d < 3; ++d)
    out[static_cast<std::size_t>(d)] =
        cell.length[d] > 0 && box.low[d] <= cell.low[d] && box.high[d] >= cell.low[d] + cell.length[d];
  return out;
}

std::vector<double> areas_met(const TriangleMesh& mesh, const PeriodicCell& cell) {
  const std::array<bool, 3> directions = spanned(mesh.bounds(), cell);
  std::vector<double> out;
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
    const Vec3 whole = area_vector(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    Vec3 met = whole;
    if (directions != std::array<bool, 3>{}) {
      const std::vector<Vec3> p = within({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}, cell, directions);
      met = {};
      for (std::size_t k = 2; k < p.size(); ++k) met += area_vector(p[0], p[k - 1], p[k]);
    }
    out.push_back(0.5 * norm(met));
  }
  return out;
}

}  // namespace subsoil::dem
