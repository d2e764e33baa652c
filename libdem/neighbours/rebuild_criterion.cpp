#include <algorithm>
#include <cmath>
#include <utility>

#include "libdem/step/bed_impl.hpp"

/// How long the lists hold: until two spheres that are no pair of theirs, or a sphere and a surface, may have come
/// nearer by the skin. Two bounds, of which the smaller counts.
///
/// Paths: every step adds the longest path in the tiles that a tile's pairs reach into, which costs nothing and also
/// wakes sleeping blocks; one fast corner of the bed wakes only its own. Two spheres part by both their paths.
///
/// RelativeDisplacement: how far spheres have really come apart, measured when the paths say no more, and since then by
/// paths. Under a tool, which pushes many the same way, it is half as much.
namespace subsoil::dem {
namespace {

/// Largest angle by which a boundary turned, rad.
double angle_between(const Pose& was, const Pose& is) {
  const Quaternion turn = is.attitude * was.attitude.conjugate();
  return 2 * std::atan2(norm(Vec3{turn.x, turn.y, turn.z}), std::abs(turn.w));
}

}  // namespace

void Bed::Impl::begin_validity(Grid grid, double largest_radius) {
  stale = false;
  path = 0;
  drifted.known = false;
  drifted.place.reserve(boundaries.size()), drifted.way.reserve(boundaries.size());
  // A sphere that is too large for the grid finds its neighbours beyond the next cell.
  drift_counts = !spheres.empty() && largest_radius <= grid.fits;
  if (drift_counts)
    drift.begin(std::move(grid), skin, spheres.size(), boundaries.size(), threads,
                [&](std::size_t i) { return spheres[i].x; });
}

void Bed::Impl::measure_drift() {
  drifted.place.clear(), drifted.way.clear();
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    drifted.place.push_back(boundaries[b].pose.position);
    drifted.way.push_back(drifted.place.back() - listed_pose[b].position);
  }
  const auto measure = [&](const auto& of) {
    return drift.measure(drifted.way, threads, [&](std::size_t i) { return of[i].x; });
  };
  drifted.found = is_mixed() ? measure(mixed) : measure(spheres);
  drifted.path = path;
  drifted.known = true;
}

bool Bed::Impl::lists_hold_within(double limit) const {
  double moved = 0;
  for (const Tile& t : tiles) moved = std::max(moved, t.path);
  const double since = drifted.known ? path - drifted.path : 0;
  // No sphere may be farther from its place than the skin: cells and boundaries are looked at as far as that.
  const bool known = drifted.known && drifted.found.gone + since <= skin;
  if (2 * moved > limit && !(known && drifted.found.parted + 2 * since <= limit)) return false;
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Pose& is = boundaries[b].pose;
    const Pose& was = listed_pose[b];
    double nearer = moved + norm(is.position - was.position);
    if (known) nearer = std::min(nearer, drifted.found.against[b] + since + norm(is.position - drifted.place[b]));
    if (nearer + angle_between(was, is) * boundary_radius[b] > limit) return false;
  }
  return true;
}

bool Bed::Impl::lists_hold() {
  if (stale) return false;
  for (std::size_t b = 0; b < boundaries.size(); ++b)
    if (boundaries[b].active != (listed_active[b] != 0)) return false;
  if (lists_hold_within(skin)) return true;
  if (!drift_counts) return false;
  measure_drift();
  // Nearly used up they would be measured every other step, at half a step's cost.
  constexpr double worth_it = 0.9;
  return lists_hold_within(worth_it * skin);
}

}  // namespace subsoil::dem
