#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "libdem/bed_impl.hpp"

/// Contact search: spheres sorted by cell, half list of neighbours within reach plus a skin, list of spheres near each
/// boundary. The lists hold while no sphere's path plus its partner's is longer than the skin; `moved` sums the largest
/// speed of each step, an upper bound of every path, so no contact can be missed.
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
  if (stale || 2 * moved > skin) return false;
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

namespace {

/// The history of a pair in the list before, or nullptr. `flipped` when its owner was the other sphere.
const PairState* find_history(const PairList& old, std::uint32_t a, std::uint32_t b, bool& flipped) {
  flipped = a > b;
  const std::uint32_t owner = std::min(a, b), other = std::max(a, b);
  if (owner + 1 >= old.start.size()) return nullptr;
  for (std::uint32_t p = old.start[owner]; p < old.start[owner + 1]; ++p)
    if (old.other[p] == other) return old.live[p] ? &old.state[p] : nullptr;
  return nullptr;
}

PairState turned_over(PairState s) {
  for (int d = 0; d < 3; ++d) {
    s.xi[d] = -s.xi[d];
    s.rho[d] = -s.rho[d];
    s.dash_t[d] = -s.dash_t[d];
    s.dash_r[d] = -s.dash_r[d];
  }
  return s;
}

}  // namespace

void Bed::Impl::build_pairs(const Grid& grid, const std::vector<std::uint32_t>& old_index) {
  const std::size_t count = spheres.size();
  const double reach = largest_reach() + skin;
  PairList list;
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
  list.state.resize(list.start[count]);
  list.live.assign(list.start[count], 0);
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    const auto& others = found[static_cast<std::size_t>(t)];
    std::copy(others.begin(), others.end(), list.other.begin() + list.start[first_of(t)]);
    for (std::size_t i = first_of(t); i < first_of(t + 1); ++i)
      for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p) {
        bool flipped = false;
        const PairState* old = find_history(pairs, old_index[i], old_index[list.other[p]], flipped);
        if (old == nullptr) continue;
        list.state[p] = flipped ? turned_over(*old) : *old;
        list.live[p] = 1;
      }
  }
  pairs = std::move(list);
}

void Bed::Impl::build_entries(const std::vector<std::uint32_t>& old_index) {
  const std::size_t count = spheres.size();
  std::vector<SurfaceEntry> old = std::move(entries);
  const std::vector<std::uint32_t> old_start = std::move(entry_start), old_of = std::move(entry_of);
  entries.clear();
  candidates.clear();
  chunks.clear();
  listed_pose.resize(boundaries.size());
  listed_active.resize(boundaries.size());
  std::vector<std::uint32_t> per_sphere(count + 1, 0);
  struct Found {
    std::vector<SurfaceEntry> entries;
    std::vector<std::uint32_t> candidates;
  };
  std::vector<Found> found(static_cast<std::size_t>(threads));
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Boundary& boundary = boundaries[b];
    listed_pose[b] = boundary.pose;
    listed_active[b] = boundary.active;
    if (!boundary.active) continue;
    const Bounds box = bounds(boundary.shape);
    const std::size_t first = entries.size();
#pragma omp parallel for num_threads(threads) schedule(static, 1)
    for (int t = 0; t < threads; ++t) {
      Found& mine = found[static_cast<std::size_t>(t)];
      mine.entries.clear();
      mine.candidates.clear();
      const std::size_t begin = count * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads);
      const std::size_t end = count * static_cast<std::size_t>(t + 1) / static_cast<std::size_t>(threads);
      for (std::size_t i = begin; i < end; ++i) {
        const Sphere& s = spheres[i];
        const int law = laws.of(s.material, boundary.material);
        if (law < 0) continue;
        const double near = s.r + reach(law) + skin;
        const Vec3 c = boundary.pose.to_local(s.x);
        if (box.distance_squared(c) > near * near) continue;
        const std::size_t before = mine.candidates.size();
        dem::candidates(boundary.shape, c, near, mine.candidates);
        if (mine.candidates.size() == before) continue;
        SurfaceEntry& e = mine.entries.emplace_back();
        e.sphere = static_cast<std::uint32_t>(i);
        e.boundary = static_cast<std::uint32_t>(b);
        e.candidates_begin = static_cast<std::uint32_t>(before);
        e.candidates_end = static_cast<std::uint32_t>(mine.candidates.size());
        if (old_index[i] + 1 >= old_start.size()) continue;
        for (std::uint32_t k = old_start[old_index[i]]; k < old_start[old_index[i] + 1]; ++k)
          if (const SurfaceEntry& was = old[old_of[k]]; was.boundary == b) {
            e.live = was.live;
            std::copy(was.contact, was.contact + was.live, e.contact);
          }
      }
    }
    for (const Found& mine : found) {
      const auto shift = static_cast<std::uint32_t>(candidates.size());
      candidates.insert(candidates.end(), mine.candidates.begin(), mine.candidates.end());
      for (SurfaceEntry e : mine.entries) {
        e.candidates_begin += shift;
        e.candidates_end += shift;
        ++per_sphere[e.sphere + 1];
        entries.push_back(e);
      }
    }
    for (std::size_t begin = first; begin < entries.size(); begin += kTile)
      chunks.push_back({.boundary = static_cast<std::uint32_t>(b),
                        .begin = static_cast<std::uint32_t>(begin),
                        .end = static_cast<std::uint32_t>(std::min<std::size_t>(begin + kTile, entries.size())),
                        .wrench = {},
                        .lost = {}});
  }
  std::partial_sum(per_sphere.begin(), per_sphere.end(), per_sphere.begin());
  entry_start = per_sphere;
  entry_of.resize(entries.size());
  for (std::size_t k = 0; k < entries.size(); ++k)
    entry_of[per_sphere[entries[k].sphere]++] = static_cast<std::uint32_t>(k);
}

/// Contiguous ranges of whole tiles with about equal numbers of pairs, the contacts that cross their borders, and rings
/// long enough for the farthest partner.
void Bed::Impl::divide_work() {
  const auto count = static_cast<std::uint32_t>(spheres.size());
  const std::uint32_t tile_count = (count + kTile - 1) / kTile;
  tiles.assign(tile_count, {});
  std::uint32_t span = 0;
  for (std::uint32_t i = 0; i < count; ++i)
    if (pairs.start[i + 1] > pairs.start[i]) span = std::max(span, pairs.other[pairs.start[i + 1] - 1] - i);
  std::size_t ring = 1;
  while (ring < std::min<std::size_t>(span, count) + 2 * kTile + 1) ring *= 2;

  const double total = static_cast<double>(pairs.other.size()) + 2.0 * count;
  workers.resize(static_cast<std::size_t>(threads));
  std::uint32_t tile = 0;
  for (int t = 0; t < threads; ++t) {
    Worker& w = workers[static_cast<std::size_t>(t)];
    w.begin = std::min(tile * kTile, count);
    const double until = total * (t + 1) / threads;
    while (tile < tile_count) {
      const std::uint32_t end = std::min((tile + 1) * kTile, count);
      if (t + 1 < threads && static_cast<double>(pairs.start[end]) + 2.0 * end > until) break;
      ++tile;
    }
    w.end = std::min(tile * kTile, count);
    if (w.ring.size() != ring) w.ring.assign(ring, Accumulator{});
    w.border.clear();
    for (std::uint32_t i = w.begin; i < w.end; ++i)
      for (std::uint32_t p = pairs.start[i]; p < pairs.start[i + 1]; ++p)
        if (pairs.other[p] >= w.end) w.border.push_back({.owner = i, .other = pairs.other[p], .pair = p});
  }
}

void Bed::Impl::fold_losses() {
  for (TileSums& t : tiles) lost_before += losses_of(t.lost), t.lost = Four{};
  for (SurfaceChunk& c : chunks) lost_before += c.lost, c.lost = {};
}

void Bed::Impl::rebuild(const std::function<bool(const Sphere&)>& gone) {
  fold_losses();
  // Spheres leave before the sort; the old lists still count them, so histories are found by the old numbering.
  const std::vector<std::uint32_t> before_removal = take_out(gone);
  require_laws();

  double radius_sum = 0, largest = 0;
  for (const Sphere& s : spheres) {
    if (!(std::isfinite(s.x.x) && std::isfinite(s.x.y) && std::isfinite(s.x.z)))
      throw BedFault("t = " + std::to_string(time) + " s: sphere " + std::to_string(s.id) + ": position is not finite");
    radius_sum += s.r;
    largest = std::max(largest, s.r);
  }
  skin =
      options.skin > 0 ? options.skin : 0.25 * (spheres.empty() ? 1 : radius_sum / static_cast<double>(spheres.size()));
  Grid grid;
  std::vector<std::uint32_t> old_index = sort_spheres(2 * largest + largest_reach() + skin, grid);
  for (std::uint32_t& i : old_index) i = before_removal[i];
  build_pairs(grid, old_index);
  build_entries(old_index);
  divide_work();

  std::uint32_t slot = 0;
  slot_of_id.assign(next_id, 0);
  for (const Sphere& s : spheres) slot_of_id[s.id] = 1;
  for (std::uint32_t& s : slot_of_id) s = s != 0 ? slot++ : 0;

  boundary_radius.resize(boundaries.size());
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Bounds box = bounds(boundaries[b].shape);
    Vec3 far{};
    for (int d = 0; d < 3; ++d) {
      double* component = d == 0 ? &far.x : d == 1 ? &far.y : &far.z;
      *component = std::max(std::abs(box.low[d]), std::abs(box.high[d]));
    }
    // An infinite plane that turns: what counts is how far the bed reaches from its origin.
    boundary_radius[b] = norm(far);
    if (!std::isfinite(boundary_radius[b])) {
      boundary_radius[b] = 0;
      for (const Sphere& s : spheres)
        boundary_radius[b] = std::max(boundary_radius[b], norm(s.x - boundaries[b].pose.position) + s.r + skin);
    }
  }
  single_law = only_law();
  moved = 0;
  stale = false;
  ++rebuilds;
}

}  // namespace subsoil::dem
