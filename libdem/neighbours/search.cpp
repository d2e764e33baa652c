#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "libdem/neighbours/grid.hpp"
#include "libdem/particles/statistics.hpp"
#include "libdem/step/bed_impl.hpp"

/// Contact search: spheres sorted by cell, half list of neighbours within reach plus a skin, list of spheres near each
/// boundary.
namespace subsoil::dem {

double Bed::Impl::largest_reach() const {
  double reach = 0;
  for (const double r : law_reach) reach = std::max(reach, r);
  return reach;
}

/// Returns for each sphere that stays its place before; nothing if all do.
std::vector<std::uint32_t> Bed::Impl::take_out(const std::function<bool(const Sphere&)>& gone) {
  std::vector<std::uint32_t> kept;
  const auto count = static_cast<long>(spheres.size());
  bool any = static_cast<bool>(gone);
#pragma omp parallel for num_threads(threads) schedule(static) reduction(|| : any)
  for (long i = 0; i < count; ++i) any = any || spheres[static_cast<std::size_t>(i)].x.y < options.floor_drop;
  if (!any) return kept;
  slot_of_id.clear();
  kept.reserve(spheres.size());
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    const Sphere& s = spheres[i];
    const bool fell = s.x.y < options.floor_drop;
    if (!fell && !(gone && gone(s))) {
      if (kept.size() < i) spheres[kept.size()] = s;
      kept.push_back(i);
      continue;
    }
    removed_energy += kinetic_energy_of(s) - s.m * dot(options.gravity, s.x);
    if (fell) ++removed;
  }
  spheres.resize(kept.size());
  return kept;
}

void Bed::Impl::require_laws(const std::vector<char>& present) const {
  for (int a = 0; a < laws.materials; ++a)
    for (int b = a; b < laws.materials; ++b)
      if (present[static_cast<std::size_t>(a)] && present[static_cast<std::size_t>(b)] && laws.of(a, b) < 0)
        throw std::invalid_argument("no contact law between materials " + std::to_string(a) + " and " +
                                    std::to_string(b) + ", and spheres of both are in the bed");
}

/// How many strips the bed is cut into. Two slabs of 1500 spheres with their sums take half of a second-level cache of
/// 1 MB, beside what streams through it; cut into strips with slabs of 600 a step of 520,000 spheres takes 7 to 15 %
/// less, of 1200 and 900 not quite so much, of 450 no more than of 900: seams cost more than they save.
int Bed::Impl::strips_of(const Grid& grid, std::size_t count) const {
  if (options.strips > 0) return std::min(options.strips, grid.n[1]);
  constexpr double too_many = 1500, cut_to = 600;
  constexpr int narrowest = 8;  // cells
  const double in_slab = static_cast<double>(count) / grid.n[0];
  if (in_slab < too_many) return 1;
  return std::clamp(static_cast<int>(std::lround(in_slab / cut_to)), 1, std::max(1, grid.n[1] / narrowest));
}

/// Stable counting sort by cell. Returns for each new place the place before.
std::vector<std::uint32_t> Bed::Impl::sort_spheres(double cell, const Bounds& box, Grid& grid) {
  const std::size_t count = spheres.size();
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
  grid.cut(strips_of(grid, count));
  const std::size_t cells = grid.cells();
  Buffer<std::uint32_t> cell_of;
  cell_of.renew(count);
  grid.start.assign(cells + 1, 0);
  const auto number = static_cast<long>(count);
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long i = 0; i < number; ++i)
    cell_of[static_cast<std::size_t>(i)] =
        static_cast<std::uint32_t>(grid.index(spheres[static_cast<std::size_t>(i)].x));
  for (std::size_t i = 0; i < count; ++i) ++grid.start[cell_of[i] + 1];
  std::partial_sum(grid.start.begin(), grid.start.end(), grid.start.begin());
  std::vector<std::uint32_t> next(grid.start.begin(), grid.start.end() - 1), old_index(count);
  for (std::size_t i = 0; i < count; ++i) old_index[next[cell_of[i]]++] = static_cast<std::uint32_t>(i);
  Buffer<Sphere> before;
  before.renew(count);
#pragma omp parallel num_threads(threads)
  {
#pragma omp for schedule(static)
    for (long i = 0; i < number; ++i) before[static_cast<std::size_t>(i)] = spheres[static_cast<std::size_t>(i)];
#pragma omp for schedule(static)
    for (long i = 0; i < number; ++i)
      spheres[static_cast<std::size_t>(i)] = before[old_index[static_cast<std::size_t>(i)]];
  }
  return old_index;
}

namespace {

/// Centre relative to the grid and radius, as the first look at a pair needs them: a quarter of the record's bytes.
struct Near {
  float x, y, z, r;
};

/// What a single-precision look may be wrong by, relative to the largest coordinate: differences of rounded coordinates
/// err by 2^-23 of them.
constexpr float kRounding = 4e-7f;

}  // namespace

namespace {

/// The neighbours of spheres that fit the cells, from 14 cells each, and of the few that do not, from all cells that
/// they may reach into.
class PairSearch {
 public:
  PairSearch(const Spheres& spheres, const Grid& grid, double reach, int threads)
      : spheres_(spheres), grid_(grid), reach_(reach), threads_(threads) {
    const auto number = static_cast<long>(spheres.size());
    near_.renew(spheres.size());
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long i = 0; i < number; ++i) {
      const Sphere& s = spheres[static_cast<std::size_t>(i)];
      const Vec3 x = s.x - grid.low;
      near_[static_cast<std::size_t>(i)] = {static_cast<float>(x.x), static_cast<float>(x.y), static_cast<float>(x.z),
                                            static_cast<float>(s.r)};
    }
    for (std::uint32_t i = 0; i < spheres.size(); ++i)
      if (spheres[i].r > grid.fits) large_.push_back(i);
    const double extent = grid.cell * std::max({grid.n[0], grid.n[1], grid.n[2]});
    margin_ = static_cast<float>(reach) + kRounding * static_cast<float>(extent + grid.cell);
  }

  HalfList run() {
    const std::size_t count = spheres_.size();
    HalfList list;
    list.start.assign(count + 1, 0);
    std::vector<std::vector<std::uint32_t>> found(static_cast<std::size_t>(threads_));
    const std::vector<Pair> of_large = pairs_of_large();
    const auto first_of = [&](int t) {
      return count * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads_);
    };
#pragma omp parallel for num_threads(threads_) schedule(static, 1)
    for (int t = 0; t < threads_; ++t) {
      auto& others = found[static_cast<std::size_t>(t)];
      others.reserve(5 * count / static_cast<std::size_t>(threads_) + 64);
      std::vector<std::uint32_t> maybe;
      for (std::size_t i = first_of(t); i < first_of(t + 1); ++i) {
        const std::size_t before = others.size();
        if (spheres_[i].r <= grid_.fits) small_with_small(i, maybe, others);
        auto extra = std::lower_bound(of_large.begin(), of_large.end(), Pair{static_cast<std::uint32_t>(i), 0});
        if (extra != of_large.end() && extra->first == i) {
          for (; extra != of_large.end() && extra->first == i; ++extra) others.push_back(extra->second);
          std::sort(others.begin() + static_cast<std::ptrdiff_t>(before), others.end());
        }
        list.start[i + 1] = static_cast<std::uint32_t>(others.size() - before);
      }
    }
    std::partial_sum(list.start.begin(), list.start.end(), list.start.begin());
    list.other.renew(list.start[count]);
#pragma omp parallel for num_threads(threads_) schedule(static, 1)
    for (int t = 0; t < threads_; ++t) {
      auto& others = found[static_cast<std::size_t>(t)];
      std::copy(others.begin(), others.end(), list.other.data() + list.start[first_of(t)]);
      others = {};
    }
    return list;
  }

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;

  bool are_near(const Sphere& a, const Sphere& b) const {
    const Vec3 d = a.x - b.x;
    const double limit = a.r + b.r + reach_;
    return dot(d, d) < limit * limit;
  }

  /// Partners above i in the half of the 27 cells around it that lies above its own place.
  void small_with_small(std::size_t i, std::vector<std::uint32_t>& maybe, std::vector<std::uint32_t>& others) const {
    const Near a = near_[i];
    std::size_t n = 0;
    const auto scan = [&](std::size_t begin, std::size_t end) {
      if (maybe.size() < n + (end - begin)) maybe.resize(n + (end - begin));
      for (std::size_t j = begin; j < end; ++j) {
        const Near& b = near_[j];
        const float x = a.x - b.x, y = a.y - b.y, z = a.z - b.z, limit = a.r + b.r + margin_;
        maybe[n] = static_cast<std::uint32_t>(j);
        n += x * x + y * y + z * z < limit * limit;
      }
    };
    // The rest of the own row, then the rows that come later: cells of a row are neighbours in the sorted order.
    const Sphere& s = spheres_[i];
    const int row = grid_.coordinate(s.x, 0), b = grid_.coordinate(s.x, 1), c = grid_.coordinate(s.x, 2);
    const int c0 = std::max(c - 1, 0), c1 = std::min(c + 1, grid_.n[2] - 1);
    scan(i + 1, grid_.start[grid_.index(row, b, c1) + 1]);
    std::array<std::pair<std::size_t, std::size_t>, 8> later;  // rows, as cells
    std::size_t rows = 0;
    const std::size_t own = grid_.index(row, b, c0);
    for (int e = std::max(row - 1, 0); e <= std::min(row + 1, grid_.n[0] - 1); ++e)
      for (int f = std::max(b - 1, 0); f <= std::min(b + 1, grid_.n[1] - 1); ++f)
        if (const std::size_t first = grid_.index(e, f, c0); first > own) {
          std::size_t k = rows++;  // ascending
          for (; k > 0 && later[k - 1].first > first; --k) later[k] = later[k - 1];
          later[k] = {first, first + static_cast<std::size_t>(c1 - c0)};
        }
    for (std::size_t k = 0; k < rows; ++k) scan(grid_.start[later[k].first], grid_.start[later[k].second + 1]);
    for (std::size_t k = 0; k < n; ++k)
      if (spheres_[maybe[k]].r <= grid_.fits && are_near(s, spheres_[maybe[k]])) others.push_back(maybe[k]);
  }

  /// Each large sphere with the small ones and with the large ones above it; sorted, lower index first.
  std::vector<Pair> pairs_of_large() const {
    std::vector<Pair> out;
    for (const std::uint32_t i : large_) {
      const Sphere& s = spheres_[i];
      const double far = s.r + grid_.fits + reach_;
      int from[3], to[3];
      for (int k = 0; k < 3; ++k) {
        const double at = s.x[grid_.axis[k]];
        Vec3 edge{};
        edge[grid_.axis[k]] = at - far, from[k] = grid_.coordinate(edge, k);
        edge[grid_.axis[k]] = at + far, to[k] = grid_.coordinate(edge, k);
      }
      for (int row = from[0]; row <= to[0]; ++row)
        for (int b = from[1]; b <= to[1]; ++b)
          for (std::size_t j = grid_.start[grid_.index(row, b, from[2])];
               j < grid_.start[grid_.index(row, b, to[2]) + 1]; ++j)
            if (spheres_[j].r <= grid_.fits && are_near(s, spheres_[j]))
              out.push_back(std::minmax(i, static_cast<std::uint32_t>(j)));
    }
    // Few by the choice of `fits`: all with all.
    for (std::size_t a = 0; a < large_.size(); ++a)
      for (std::size_t b = a + 1; b < large_.size(); ++b)
        if (are_near(spheres_[large_[a]], spheres_[large_[b]])) out.push_back({large_[a], large_[b]});
    std::sort(out.begin(), out.end());
    return out;
  }

  const Spheres& spheres_;
  const Grid& grid_;
  double reach_;
  int threads_;
  Buffer<Near> near_;
  std::vector<std::uint32_t> large_;
  float margin_ = 0;
};

/// Radius up to which spheres share the grid of cells. A few large ones among many small would make cells that hold
/// hundreds each; up to one in fifty, and no more than can be tried all with all, look for their neighbours themselves.
double radius_that_fits(const Spheres& spheres, double smallest, double largest) {
  constexpr std::size_t one_in = 50, at_most = 2000;
  constexpr double worth_it = 1.5;  // largest over the chosen radius
  if (largest <= worth_it * smallest) return largest;
  const std::size_t few = std::min(spheres.size() / one_in, at_most);
  if (few == 0) return largest;
  std::vector<double> radii;
  radii.reserve(spheres.size());
  for (const Sphere& s : spheres) radii.push_back(s.r);
  const auto at = radii.end() - 1 - static_cast<std::ptrdiff_t>(few);
  std::nth_element(radii.begin(), at, radii.end());
  return largest > worth_it * *at ? *at : largest;
}

}  // namespace

HalfList find_pairs(const Spheres& spheres, const Grid& grid, double reach, int threads) {
  return PairSearch(spheres, grid, reach, threads).run();
}

void Bed::Impl::fold_losses() {
  for (Tile& t : tiles) lost_before += t.lost, t.lost = {};
  for (SurfaceChunk& c : chunks) lost_before += c.lost, c.lost = {};
}

/// How far a boundary reaches from its origin, for the path of its points when it turns.
void Bed::Impl::measure_boundaries(const ParticleStatistics& census) {
  const double reaches = census.largest + skin;  // while the lists hold
  const Vec3 around{reaches, reaches, reaches};
  const Bounds bed{census.box.low - around, census.box.high + around};
  boundary_radius.resize(boundaries.size());
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Bounds box = bounds(boundaries[b].shape);
    boundary_radius[b] = box.farthest(Vec3{});
    if (std::isfinite(boundary_radius[b])) continue;
    // An infinite plane that turns: what counts is how far the bed reaches from its origin.
    boundary_radius[b] = spheres.empty() ? 0 : bed.farthest(boundaries[b].pose.position);
  }
}

void Bed::Impl::number_slots() {
  if (slot_of_id.size() == next_id) return;
  std::uint32_t slot = 0;
  slot_of_id.assign(next_id, 0);
  for (const Sphere& s : spheres) slot_of_id[s.id] = 1;
  for (std::uint32_t& s : slot_of_id) s = s != 0 ? slot++ : 0;
}

void Bed::Impl::clear_lists() {
  tiles.clear(), runs.clear(), blocks.clear(), shapes.clear(), wake.clear(), lines.clear();
  plane_runs.clear(), plane_blocks.clear(), plane_lines.clear();
  entries.clear(), candidates.clear(), entry_order.clear(), chunks.clear();
  waiting.clear(), waiting_surfaces.clear();
  stale = true;
}

void Bed::Impl::put_aside() {
  fold_losses();
  if (tiles.empty()) return;  // there are no lists; what waits goes on waiting
  std::vector<PairHistories> of_pairs = pair_histories();
  std::vector<SurfaceHistory> of_surfaces = surface_histories();
  clear_lists();
  waiting = std::move(of_pairs), waiting_surfaces = std::move(of_surfaces);
}

void Bed::Impl::rebuild(const std::function<bool(const Sphere&)>& gone) {
  fold_losses();
  sync_from_mixed();
  // Spheres leave before the sort; histories still count them, so they are found by the numbering before.
  const std::size_t count_before = spheres.size();
  const std::vector<std::uint32_t> before_removal = take_out(gone);
  const ParticleStatistics census = particle_statistics(spheres, laws.materials, threads, time);
  require_laws(census.present);
  // Longer, and the lists grow, though most of what is added sleeps; shorter, and they are built more often: under a
  // plough 0.25 costs 13 %, 0.6 costs 40 % more.
  skin = options.skin > 0 ? options.skin : 0.4 * census.mean;
  // Only now, when nothing refuses the bed any more: what a failed rebuild had put aside would meet other lists later.
  if (!tiles.empty()) {
    std::vector<SurfaceHistory> of_surfaces = surface_histories();
    std::swap(runs, old.runs), std::swap(blocks, old.blocks);
    std::swap(shapes, old.shapes), std::swap(lines, old.lines);
    clear_lists();
    waiting_surfaces = std::move(of_surfaces);
  }
  update_reach(census.largest);
  const double reach_and_skin = largest_reach() + skin;
  Grid grid;
  grid.fits = radius_that_fits(spheres, census.smallest, census.largest);
  const std::vector<std::uint32_t> old_index = sort_spheres(2 * grid.fits + reach_and_skin, census.box, grid);
  std::vector<std::uint32_t> new_index(count_before, kGone);
  const auto count = static_cast<long>(old_index.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long i = 0; i < count; ++i) {
    const std::uint32_t was = old_index[static_cast<std::size_t>(i)];
    new_index[before_removal.empty() ? was : before_removal[was]] = static_cast<std::uint32_t>(i);
  }

  {
    HalfList list = find_pairs(spheres, grid, reach_and_skin, threads);
    build_runs(list, grid);
    find_seams();
    put_pairs(list, new_index);
  }
  old.runs.clear();
  build_surfaces();
  put_surfaces(waiting_surfaces, new_index);
  waiting = {}, waiting_surfaces = {};
  steps_divided = 0;
  divide_work();
  measure_boundaries(census);
  begin_validity(std::move(grid), census.largest);

  number_slots();
  sync_to_mixed();
  ++rebuilds;
}

}  // namespace subsoil::dem
