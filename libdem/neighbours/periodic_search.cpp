#include "libdem/neighbours/periodic_search.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace subsoil::dem {
namespace {

/// One of each two opposite shifts by periods, m.
std::vector<Vec3> upward_shifts(const PeriodicCell& cell) {
  std::vector<Vec3> out;
  const auto turns = [&](int d) { return cell.length[d] > 0 ? 1 : 0; };
  for (int a = 0; a <= turns(0); ++a)
    for (int b = a > 0 ? -turns(1) : 0; b <= turns(1); ++b)
      for (int c = a > 0 || b > 0 ? -turns(2) : 1; c <= turns(2); ++c)
        out.push_back({a * cell.length.x, b * cell.length.y, c * cell.length.z});
  return out;
}

/// First particle and image of each pair across a side.
using AcrossPair = std::pair<std::uint32_t, std::uint32_t>;

/// use(j) for the spheres of all cells that a place has within a distance.
template <class Use>
void each_sphere_around(const Grid& grid, const Vec3& x, double distance, const Use& use) {
  int from[3], to[3];
  for (int k = 0; k < 3; ++k) {
    Vec3 edge = x;
    edge[grid.axis[k]] = x[grid.axis[k]] - distance, from[k] = grid.coordinate(edge, k);
    edge[grid.axis[k]] = x[grid.axis[k]] + distance, to[k] = grid.coordinate(edge, k);
  }
  for (int a = from[0]; a <= to[0]; ++a)
    for (int b = from[1]; b <= to[1]; ++b) {
      const std::uint32_t end = grid.start[grid.index(a, b, to[2]) + 1];
      for (std::uint32_t j = grid.start[grid.index(a, b, from[2])]; j < end; ++j) use(j);
    }
}

/// Behind the other partners of each first particle, which the images' indices come after.
void merge(std::vector<AcrossPair> pairs, std::uint32_t spheres, NeighbourList& list) {
  std::sort(pairs.begin(), pairs.end());
  NeighbourList all;
  all.gap_error = list.gap_error;
  all.start.reserve(list.start.size());
  all.j.renew(list.j.size() + pairs.size()), all.gap.renew(list.j.size() + pairs.size());
  std::uint32_t end = 0;
  auto next = pairs.begin();
  for (std::uint32_t i = 0; i < spheres; ++i) {
    for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p)
      all.j[end] = list.j[p], all.gap[end++] = list.gap[p];
    for (; next != pairs.end() && next->first == i; ++next)
      all.j[end] = spheres + next->second, all.gap[end++] = NeighbourList::kUnknown;
    all.start.push_back(end);
  }
  list = std::move(all);
}

}  // namespace

PeriodicImages add_pairs_across(std::span<const Sphere> spheres, const Grid& grid, const Bounds& box,
                                const PeriodicCell& cell, double largest, double cutoff, NeighbourList& list) {
  PeriodicImages images;
  const auto count = static_cast<std::uint32_t>(spheres.size());
  images.spheres = count;
  std::vector<AcrossPair> pairs;
  for (const Vec3& shift : upward_shifts(cell))
    for (std::uint32_t k = 0; k < count; ++k) {
      const Sphere& s = spheres[k];
      const Vec3 x = s.x + shift;
      const double far = s.r + largest + cutoff;
      if (box.distance_squared(x) > far * far) continue;
      const std::size_t before = pairs.size();
      each_sphere_around(grid, x, far, [&](std::uint32_t i) {
        const Vec3 d = spheres[i].x - x;
        const double limit = spheres[i].r + s.r + cutoff;
        if (dot(d, d) < limit * limit) pairs.push_back({i, static_cast<std::uint32_t>(images.size())});
      });
      if (pairs.size() == before) continue;
      images.of.push_back(k), images.shift.push_back(shift);
    }
  merge(std::move(pairs), count, list);
  return images;
}

void require_period(const PeriodicCell& cell, double reach) {
  for (int d = 0; d < 3; ++d)
    if (cell.length[d] > 0 && cell.length[d] < 2 * reach) {
      char text[300];
      std::snprintf(text, sizeof text,
                    "the period of %.6g m in %c is too short: a sphere could meet another one from both sides; it must "
                    "be %.6g m at least, twice the distance up to which neighbours are listed (two radii, the range of "
                    "the law and the skin): a longer container, or smaller spheres",
                    cell.length[d], "xyz"[d], 2 * reach);
      throw std::invalid_argument(text);
    }
}

void require_period_of_clumps(const PeriodicCell& cell, double least) {
  for (int d = 0; d < 3; ++d)
    if (cell.length[d] > 0 && cell.length[d] < least) {
      char text[300];
      std::snprintf(
          text, sizeof text,
          "the period of %.6g m in %c is too short: a clump could meet itself; it must be %.6g m at least, the "
          "gap between the clump's farthest spheres and the distance up to which neighbours are listed: a "
          "longer container, or smaller clumps",
          cell.length[d], "xyz"[d], least);
      throw std::invalid_argument(text);
    }
}

double skin_within_period(const PeriodicCell& cell, double range, double widest, double least, double usual) {
  double skin = usual;
  for (int d = 0; d < 3; ++d)
    if (cell.length[d] > 0) skin = std::min({skin, 0.5 * cell.length[d] - range, cell.length[d] - widest - range});
  return std::max(skin, least);
}

}  // namespace subsoil::dem
