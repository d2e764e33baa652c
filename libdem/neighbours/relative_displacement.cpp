#include "libdem/neighbours/relative_displacement.hpp"

#include <limits>

namespace subsoil::dem {

void RelativeDisplacement::include(const Bounds& of_cell, std::span<const Vec3> boundaries, Layer& found) {
  const double gone = of_cell.farthest(Vec3{});
  found.gone = std::max(found.gone, gone);
  for (std::size_t k = 0; k < boundaries.size(); ++k) {
    const Vec3& way = boundaries[k];
    const bool stays = way.x == 0 && way.y == 0 && way.z == 0;  // most do
    found.against[k] = std::max(found.against[k], stays ? gone : of_cell.farthest(way));
  }
}

RelativeDisplacement::Cubes RelativeDisplacement::cubes_of(Range cells, int axis) const {
  Cubes out;
  for (int k = cells.first; k <= cells.last; ++k)
    if (const int cube = cell(k, axis) / kCube; out.count == 0 || out.of[out.count - 1] != cube)
      out.of[out.count++] = cube;
  return out;
}

bool RelativeDisplacement::may_part(int a, int b, int c, double known) const {
  const Bounds& own = cubes_[cube_index(a, b, c)];
  if (own.empty() || own.farthest(Vec3{}) <= 0.25 * skin_) return false;
  const Cells near = around(cells_of_cube(a, b, c));
  for (const int x : cubes_of(near.of[0], 0))
    for (const int y : cubes_of(near.of[1], 1))
      for (const int z : cubes_of(near.of[2], 2)) {
        const Bounds& other = cubes_[cube_index(x, y, z)];
        if (!other.empty() && own.farthest(other) > known) return true;
      }
  return false;
}

RelativeDisplacement::Found RelativeDisplacement::of_all(double parted, std::size_t boundaries) {
  const std::span<double> against = of_layer(layers_.size(), boundaries);
  std::fill(against.begin(), against.end(), 0.0);
  Found out{.parted = parted, .gone = 0, .against = against};
  for (const Layer& layer : layers_) {
    out.gone = std::max(out.gone, layer.gone);
    for (std::size_t k = 0; k < boundaries; ++k) against[k] = std::max(against[k], layer.against[k]);
  }
  // Of both ends of a way one is a float.
  Vec3 size{};
  for (int k = 0; k < 3; ++k) size[grid_.axis[k]] = grid_.cell * grid_.n[k];
  const double rounding = 2.0 * std::numeric_limits<float>::epsilon() * norm(size);
  out.parted += rounding, out.gone += rounding;
  for (double& x : against) x += rounding;
  return out;
}

}  // namespace subsoil::dem
