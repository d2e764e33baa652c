#include <algorithm>
#include <cmath>
#include <numeric>

#include "libdem/bed_impl.hpp"

/// Contact search: spheres sorted by cell, half list of neighbours within reach plus a skin, list of spheres near each
/// boundary. The lists hold while no sphere's path plus its partner's is longer than the skin. A tile's path is a bound
/// on that of all its spheres and their partners: every step adds the longest path in the tiles that its pairs reach
/// into, so no contact can be missed, and one fast corner of the bed wakes only its own sleeping blocks.
namespace subsoil::dem {

struct Grid {
  Vec3 low;
  double cell = 1;
  int axis[3] = {0, 1, 2};  ///< longest first: slabs across it are the sorted order
  int n[3] = {1, 1, 1};
  std::vector<std::uint32_t> start;  ///< first sphere of each cell

  int coordinate(const Vec3& x, int k) const {
    const double at = std::floor((x[axis[k]] - low[axis[k]]) / cell);
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(n[k] - 1)));
  }
  std::size_t index(int a, int b, int c) const {
    return (static_cast<std::size_t>(a) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(b)) *
               static_cast<std::size_t>(n[2]) +
           static_cast<std::size_t>(c);
  }
  std::size_t index(const Vec3& x) const { return index(coordinate(x, 0), coordinate(x, 1), coordinate(x, 2)); }
};

double Bed::Impl::largest_reach() const {
  double reach = 0;
  for (const double r : law_reach) reach = std::max(reach, r);
  return reach;
}

bool Bed::Impl::lists_hold() const {
  if (stale) return false;
  double moved = 0;
  for (const Tile& t : tiles) moved = std::max(moved, t.path);
  if (2 * moved > skin) return false;
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    if (boundaries[b].active != (listed_active[b] != 0)) return false;
    const Pose& was = listed_pose[b];
    const Pose& is = boundaries[b].pose;
    const Quaternion turn = is.attitude * was.attitude.conjugate();
    const double angle = 2 * std::atan2(norm(Vec3{turn.x, turn.y, turn.z}), std::abs(turn.w));
    if (moved + norm(is.position - was.position) + angle * boundary_radius[b] > skin) return false;
  }
  return true;
}

/// Returns for each sphere that stays its place before.
std::vector<std::uint32_t> Bed::Impl::take_out(const std::function<bool(const Sphere&)>& gone) {
  std::vector<std::uint32_t> kept;
  kept.reserve(spheres.size());
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    const Sphere& s = spheres[i];
    const bool fell = s.x.y < options.floor_drop;
    if (!fell && !(gone && gone(s))) {
      spheres[kept.size()] = s;
      kept.push_back(i);
      continue;
    }
    removed_energy += 0.5 * s.m * dot(s.v, s.v) + 0.5 * inertia(s) * dot(s.w, s.w) - s.m * dot(options.gravity, s.x);
    if (fell) ++removed;
  }
  spheres.resize(kept.size());
  return kept;
}

void Bed::Impl::require_laws() const {
  std::vector<char> present(static_cast<std::size_t>(laws.materials), 0);
  for (const Sphere& s : spheres) present[s.material] = 1;
  for (int a = 0; a < laws.materials; ++a)
    for (int b = a; b < laws.materials; ++b)
      if (present[static_cast<std::size_t>(a)] && present[static_cast<std::size_t>(b)] && laws.of(a, b) < 0)
        throw std::invalid_argument("no contact law between materials " + std::to_string(a) + " and " +
                                    std::to_string(b) + ", and spheres of both are in the bed");
}

/// Stable counting sort by cell. Returns for each new place the place before.
std::vector<std::uint32_t> Bed::Impl::sort_spheres(double cell, Grid& grid) {
  const std::size_t count = spheres.size();
  Bounds box;
  for (const Sphere& s : spheres) box.include(s.x);
  const Vec3 size = count > 0 ? box.high - box.low : Vec3{};
  std::sort(grid.axis, grid.axis + 3, [&](int a, int b) { return size[a] > size[b] || (size[a] == size[b] && a < b); });
  grid.low = count > 0 ? box.low : Vec3{};
  // A few spheres far away must not make an array of empty cells: grow the cell until their number is in proportion.
  for (grid.cell = cell;; grid.cell *= 1.5) {
    double cells = 1;
    for (int k = 0; k < 3; ++k) {
      const double n = std::min(std::floor(size[grid.axis[k]] / grid.cell) + 1, 1e6);
      grid.n[k] = static_cast<int>(n);
      cells *= n;
    }
    if (cells <= 8.0 * static_cast<double>(count) + 4096) break;
  }
  const std::size_t cells = grid.index(grid.n[0] - 1, grid.n[1] - 1, grid.n[2] - 1) + 1;
  std::vector<std::uint32_t> cell_of(count);
  grid.start.assign(cells + 1, 0);
  for (std::size_t i = 0; i < count; ++i) {
    cell_of[i] = static_cast<std::uint32_t>(grid.index(spheres[i].x));
    ++grid.start[cell_of[i] + 1];
  }
  std::partial_sum(grid.start.begin(), grid.start.end(), grid.start.begin());
  std::vector<std::uint32_t> next(grid.start.begin(), grid.start.end() - 1), old_index(count);
  std::vector<Sphere> sorted(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t to = next[cell_of[i]]++;
    sorted[to] = spheres[i];
    old_index[to] = static_cast<std::uint32_t>(i);
  }
  spheres.swap(sorted);
  return old_index;
}

HalfList find_pairs(const std::vector<Sphere>& spheres, const Grid& grid, double reach, int threads) {
  const std::size_t count = spheres.size();
  HalfList list;
  list.start.assign(count + 1, 0);
  std::vector<std::vector<std::uint32_t>> found(static_cast<std::size_t>(threads));
  const auto first_of = [&](int t) { return count * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads); };
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    auto& others = found[static_cast<std::size_t>(t)];
    others.reserve(6 * count / static_cast<std::size_t>(threads) + 64);
    for (std::size_t i = first_of(t); i < first_of(t + 1); ++i) {
      const Sphere& s = spheres[i];
      const std::size_t before = others.size();
      const auto scan = [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j) {
          const Vec3 d = s.x - spheres[j].x;
          const double limit = s.r + spheres[j].r + reach;
          if (dot(d, d) < limit * limit) others.push_back(static_cast<std::uint32_t>(j));
        }
      };
      // The rest of the own row, then the rows above it: cells of a row are neighbours in the sorted order.
      const int a = grid.coordinate(s.x, 0), b = grid.coordinate(s.x, 1), c = grid.coordinate(s.x, 2);
      const int c0 = std::max(c - 1, 0), c1 = std::min(c + 1, grid.n[2] - 1);
      scan(i + 1, grid.start[grid.index(a, b, c1) + 1]);
      if (b + 1 < grid.n[1]) scan(grid.start[grid.index(a, b + 1, c0)], grid.start[grid.index(a, b + 1, c1) + 1]);
      if (a + 1 < grid.n[0])
        for (int e = std::max(b - 1, 0); e <= std::min(b + 1, grid.n[1] - 1); ++e)
          scan(grid.start[grid.index(a + 1, e, c0)], grid.start[grid.index(a + 1, e, c1) + 1]);
      list.start[i + 1] = static_cast<std::uint32_t>(others.size() - before);
    }
  }
  std::partial_sum(list.start.begin(), list.start.end(), list.start.begin());
  list.other.resize(list.start[count]);
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    const auto& others = found[static_cast<std::size_t>(t)];
    std::copy(others.begin(), others.end(), list.other.begin() + list.start[first_of(t)]);
  }
  return list;
}

void Bed::Impl::fold_losses() {
  for (Tile& t : tiles) lost_before += t.lost, t.lost = {};
  for (SurfaceChunk& c : chunks) lost_before += c.lost, c.lost = {};
}

/// A quarter of the mean radius unless given: longer, and the lists grow; shorter, and they are built more often.
void Bed::Impl::choose_skin(double& largest_radius) {
  double radius_sum = 0;
  largest_radius = 0;
  for (const Sphere& s : spheres) {
    if (!(std::isfinite(s.x.x) && std::isfinite(s.x.y) && std::isfinite(s.x.z)))
      throw BedFault("t = " + std::to_string(time) + " s: sphere " + std::to_string(s.id) + ": position is not finite");
    radius_sum += s.r;
    largest_radius = std::max(largest_radius, s.r);
  }
  const double mean = spheres.empty() ? 1 : radius_sum / static_cast<double>(spheres.size());
  skin = options.skin > 0 ? options.skin : 0.25 * mean;
}

/// How far a boundary reaches from its origin, for the path of its points when it turns.
void Bed::Impl::measure_boundaries() {
  boundary_radius.resize(boundaries.size());
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Bounds box = bounds(boundaries[b].shape);
    Vec3 far{};
    for (int d = 0; d < 3; ++d) far[d] = std::max(std::abs(box.low[d]), std::abs(box.high[d]));
    boundary_radius[b] = norm(far);
    if (std::isfinite(boundary_radius[b])) continue;
    // An infinite plane that turns: what counts is how far the bed reaches from its origin.
    boundary_radius[b] = 0;
    for (const Sphere& s : spheres)
      boundary_radius[b] = std::max(boundary_radius[b], norm(s.x - boundaries[b].pose.position) + s.r + skin);
  }
}

void Bed::Impl::clear_lists() {
  tiles.clear(), runs.clear(), blocks.clear(), wake.clear(), rows.clear();
  plane_runs.clear(), plane_blocks.clear(), plane_rows.clear();
  entries.clear(), candidates.clear(), entry_order.clear(), chunks.clear();
  waiting_pairs.clear(), waiting_surfaces.clear();
  stale = true;
}

void Bed::Impl::put_aside() {
  fold_losses();
  if (tiles.empty()) return;  // there are no lists; what waits goes on waiting
  std::vector<PairHistory> of_pairs = pair_histories();
  std::vector<SurfaceHistory> of_surfaces = surface_histories();
  clear_lists();
  waiting_pairs = std::move(of_pairs), waiting_surfaces = std::move(of_surfaces);
}

void Bed::Impl::rebuild(const std::function<bool(const Sphere&)>& gone) {
  put_aside();
  // Spheres leave before the sort; histories still count them, so they are found by the numbering before.
  const std::size_t count_before = spheres.size();
  const std::vector<std::uint32_t> before_removal = take_out(gone);
  require_laws();
  double largest = 0;
  choose_skin(largest);
  const double reach_and_skin = largest_reach() + skin;
  Grid grid;
  const std::vector<std::uint32_t> old_index = sort_spheres(2 * largest + reach_and_skin, grid);
  std::vector<std::uint32_t> new_index(count_before, kGone);
  for (std::size_t i = 0; i < old_index.size(); ++i)
    new_index[before_removal[old_index[i]]] = static_cast<std::uint32_t>(i);

  HalfList list = find_pairs(spheres, grid, reach_and_skin, threads);
  build_runs(list);
  put_pairs(list, waiting_pairs, new_index);
  build_surfaces();
  put_surfaces(waiting_surfaces, new_index);
  waiting_pairs = {}, waiting_surfaces = {};
  divide_work();
  measure_boundaries();

  std::uint32_t slot = 0;
  slot_of_id.assign(next_id, 0);
  for (const Sphere& s : spheres) slot_of_id[s.id] = 1;
  for (std::uint32_t& s : slot_of_id) s = s != 0 ? slot++ : 0;
  stale = false;
  ++rebuilds;
}

}  // namespace subsoil::dem
