#include "libdem/neighbours/neighbour_list.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

/// Neighbour search by cells: half list of the pairs within the cutoff and a skin.
namespace subsoil::dem {

namespace {

/// Centres relative to the grid and radii, as the look at a pair needs them: a sixth of the records' bytes, and four
/// spheres at a time. Spheres that are no part of the cells are near none.
class Near {
 public:
  Near(std::span<const Sphere> spheres, const Grid& grid, int threads) {
    const auto number = static_cast<long>(spheres.size());
    for (Buffer<float>* column : {&x_, &y_, &z_, &r_}) {
      column->renew(spheres.size() + kAtOnce);
      std::fill_n(column->data() + spheres.size(), kAtOnce, 0.0f);  // read, and left out
    }
    bool any_large = false;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(|| : any_large)
    for (long i = 0; i < number; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Vec3 x = spheres[k].x - grid.low;
      const bool large = spheres[k].r > grid.fits;
      any_large = any_large || large;
      x_[k] = large ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(x.x);
      y_[k] = static_cast<float>(x.y), z_[k] = static_cast<float>(x.z);
      r_[k] = static_cast<float>(spheres[k].r);
    }
    any_large_ = any_large;
  }

  bool is_large(std::size_t i) const { return std::isnan(x_[i]); }
  bool any_large() const { return any_large_; }  ///< whether any does not fit the cells

  static constexpr std::size_t kAtOnce = 4;
  using Floats = float __attribute__((vector_size(4 * kAtOnce)));
  using Ints = std::int32_t __attribute__((vector_size(4 * kAtOnce)));

  /// One sphere, in all lanes.
  struct Own {
    Floats x, y, z, r;
    const float *xs, *ys, *zs, *rs;  ///< of all
  };
  Own own(std::size_t i) const {
    constexpr Floats one = {1, 1, 1, 1};
    return {x_[i] * one, y_[i] * one, z_[i] * one, r_[i] * one, x_.data(), y_.data(), z_.data(), r_.data()};
  }

  /// Those of begin to end whose gap to the sphere is below the margin, to `out`; returns the end of what is there
  /// then. `out` has room for kAtOnce more than there may be.
  static std::uint32_t* scan(const Own& a, float margin, std::size_t begin, std::size_t end, std::uint32_t* out) {
    const auto look = [&](std::size_t j) {
      const Floats x = a.x - at(a.xs + j), y = a.y - at(a.ys + j), z = a.z - at(a.zs + j);
      const Floats limit = a.r + at(a.rs + j) + margin;
      return lanes_of(x * x + y * y + z * z < limit * limit);
    };
    std::size_t j = begin;
    for (; j + kAtOnce <= end; j += kAtOnce) out = put(look(j), j, out);
    if (j < end) out = put(look(j) & ((1u << (end - j)) - 1), j, out);
    return out;
  }

  /// Gaps to four spheres.
  static Floats gaps(const Own& a, const std::uint32_t* j) {
    const auto four = [&](const float* of) { return Floats{of[j[0]], of[j[1]], of[j[2]], of[j[3]]}; };
    const Floats x = a.x - four(a.xs), y = a.y - four(a.ys), z = a.z - four(a.zs), squared = x * x + y * y + z * z;
    return root(squared) - (a.r + four(a.rs));
  }

  /// Lanes of which a comparison holds, as bits.
  static unsigned lanes_of(const Ints& holds) {
#ifdef __SSE__
    return static_cast<unsigned>(__builtin_ia32_movmskps(std::bit_cast<Floats>(holds)));
#else
    unsigned out = 0;
    for (std::size_t l = 0; l < kAtOnce; ++l) out |= static_cast<unsigned>(holds[l] & 1) << l;
    return out;
#endif
  }

 private:
  /// j and the three after it, those of the lanes alone: all four are written, the next come over what is too much.
  static std::uint32_t* put(unsigned lanes, std::size_t j, std::uint32_t* out) {
    struct Chosen {
      alignas(16) std::int32_t lane[16][4];
      std::uint8_t count[16];
    };
    static constexpr Chosen chosen = [] {
      Chosen c{};
      for (unsigned bits = 0; bits < 16; ++bits)
        for (int l = 0; l < 4; ++l)
          if ((bits >> l & 1) != 0) c.lane[bits][c.count[bits]++] = l;
      return c;
    }();
    Ints four;
    __builtin_memcpy(&four, chosen.lane[lanes], sizeof four);
    four += static_cast<std::int32_t>(j);
    __builtin_memcpy(out, &four, sizeof four);
    return out + chosen.count[lanes];
  }
  static Floats root(const Floats& x) {
#ifdef __SSE__
    return __builtin_ia32_sqrtps(x);
#else
    Floats out;
    for (std::size_t l = 0; l < kAtOnce; ++l) out[l] = std::sqrt(x[l]);
    return out;
#endif
  }
  static Floats at(const float* four) {
    Floats f;
    __builtin_memcpy(&f, four, sizeof f);
    return f;
  }

  Buffer<float> x_, y_, z_, r_;
  bool any_large_ = false;
};

/// Of spheres, the lower number first.
using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// What one thread found: numbers of partners and gaps, of one sphere after the other.
struct Found {
  Buffer<std::uint32_t> j;
  Buffer<float> gap;
  std::size_t count = 0;

  /// Room for so many more.
  void reserve(std::size_t more) {
    if (count + more <= j.size()) return;
    Found longer;
    longer.j.renew(2 * (count + more)), longer.gap.renew(2 * (count + more));
    std::copy_n(j.data(), count, longer.j.data()), std::copy_n(gap.data(), count, longer.gap.data());
    j = std::move(longer.j), gap = std::move(longer.gap);
  }

  /// More partners of the last sphere, whose first is at `before`; all gaps of it are then left to whoever asks.
  void add(std::span<const Pair> more, std::size_t before) {
    reserve(more.size());
    for (const Pair& pair : more) j[count++] = pair.second;
    std::sort(j.data() + before, j.data() + count);
    std::fill(gap.data() + before, gap.data() + count, NeighbourList::kUnknown);
  }
};

/// What the spheres of one cell search: the rest of their own row, then the rows that come later, in the half of the 27
/// cells around that lies above. Cells of a row are neighbours in the sorted order.
struct Around {
  int row = -1, column = -1;           ///< of the cell: as long as they stay its cells follow each other
  std::size_t count = 0;               ///< of the rows that come later
  std::array<std::size_t, 8> first{};  ///< their cells of coordinate 0
  std::size_t end = 0;                 ///< of the spheres of the cell
  std::size_t own_row = 0;             ///< end of what is searched of the own row
  std::size_t most = 0;                ///< number of spheres in the cells
  std::array<std::pair<std::uint32_t, std::uint32_t>, 8> rows;
};

/// What a distance in single precision may be wrong by, relative to the largest coordinate: differences of rounded
/// coordinates err by 2^-23 of them.
constexpr float kRounding = 4e-7f;

/// The neighbours of spheres that fit the cells, from 14 cells each, and of the few that do not, from all cells that
/// they may reach into.
class NeighbourSearch {
 public:
  NeighbourSearch(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads)
      : spheres_(spheres), grid_(grid), cutoff_(cutoff), threads_(threads), near_(spheres, grid, threads) {
    for (std::uint32_t i = 0; near_.any_large() && i < spheres.size(); ++i)
      if (spheres[i].r > grid.fits) large_.push_back(i);
    const double extent = grid.cell * std::max({grid.n[0], grid.n[1], grid.n[2]});
    error_ = kRounding * static_cast<float>(extent + grid.cell);
    margin_ = static_cast<float>(cutoff) + error_, surely_ = static_cast<float>(cutoff) - error_;
  }

  NeighbourList run() {
    const std::size_t count = spheres_.size();
    NeighbourList list;
    list.gap_error = error_;
    list.start.assign(count + 1, 0);
    std::vector<Found> found(static_cast<std::size_t>(threads_));
    const std::vector<Pair> of_large = pairs_of_large();
    const auto first_of = [&](int t) {
      return count * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads_);
    };
#pragma omp parallel for num_threads(threads_) schedule(static, 1)
    for (int t = 0; t < threads_; ++t) {
      Found& mine = found[static_cast<std::size_t>(t)];
      mine.reserve(4 * count / static_cast<std::size_t>(threads_) + 64);
      Around around;
      auto extra = std::lower_bound(of_large.begin(), of_large.end(), Pair{static_cast<std::uint32_t>(first_of(t)), 0});
      for (std::size_t i = first_of(t), end = first_of(t + 1); i < end; ++i) {
        const std::size_t before = mine.count;
        if (i >= around.end) look_around(i, around);
        if (!near_.is_large(i)) small_with_small(i, around, mine);
        const auto of_own = extra;
        while (extra != of_large.end() && extra->first == i) ++extra;
        if (of_own != extra) mine.add({of_own, extra}, before);
        list.start[i + 1] = static_cast<std::uint32_t>(mine.count - before);
      }
    }
    std::partial_sum(list.start.begin(), list.start.end(), list.start.begin());
    list.j.renew(list.start[count]), list.gap.renew(list.start[count]);
#pragma omp parallel for num_threads(threads_) schedule(static, 1)
    for (int t = 0; t < threads_; ++t) {
      Found& mine = found[static_cast<std::size_t>(t)];
      std::copy_n(mine.j.data(), mine.count, list.j.data() + list.start[first_of(t)]);
      std::copy_n(mine.gap.data(), mine.count, list.gap.data() + list.start[first_of(t)]);
      mine = {};
    }
    return list;
  }

 private:
  bool are_near(const Sphere& a, const Sphere& b) const {
    const Vec3 d = a.x - b.x;
    const double limit = a.r + b.r + cutoff_;
    return dot(d, d) < limit * limit;
  }

  void look_around(std::size_t i, Around& out) const {
    const Sphere& s = spheres_[i];
    const int row = grid_.coordinate(s.x, 0), b = grid_.coordinate(s.x, 1), c = grid_.coordinate(s.x, 2);
    if (row != out.row || b != out.column) find_rows(row, b, out);
    const std::size_t c0 = static_cast<std::size_t>(std::max(c - 1, 0));
    const std::size_t c1 = static_cast<std::size_t>(std::min(c + 1, grid_.n[2] - 1));
    const std::uint32_t* const start = grid_.start.data() + grid_.index(row, b, 0);
    out.end = start[c + 1], out.own_row = start[c1 + 1];
    out.most = out.own_row - start[c];
    for (std::size_t k = 0; k < out.count; ++k) {
      out.rows[k] = {grid_.start[out.first[k] + c0], grid_.start[out.first[k] + c1 + 1]};
      out.most += out.rows[k].second - out.rows[k].first;
    }
  }
  void find_rows(int row, int b, Around& out) const {
    out.row = row, out.column = b, out.count = 0;
    const std::size_t own = grid_.index(row, b, 0);
    for (int e = std::max(row - 1, 0); e <= std::min(row + 1, grid_.n[0] - 1); ++e)
      for (int f = std::max(b - 1, 0); f <= std::min(b + 1, grid_.n[1] - 1); ++f)
        if (const std::size_t first = grid_.index(e, f, 0); first > own) out.first[out.count++] = first;
    std::sort(out.first.data(), out.first.data() + out.count);
  }

  /// Partners above i.
  void small_with_small(std::size_t i, const Around& around, Found& mine) const {
    mine.reserve(around.most + 2 * Near::kAtOnce);
    std::uint32_t* const js = mine.j.data() + mine.count;
    float* const gaps = mine.gap.data() + mine.count;
    const Near::Own own = near_.own(i);
    std::uint32_t* end = Near::scan(own, margin_, i + 1, around.own_row, js);
    for (std::size_t k = 0; k < around.count; ++k)
      end = Near::scan(own, margin_, around.rows[k].first, around.rows[k].second, end);
    std::fill_n(end, Near::kAtOnce, static_cast<std::uint32_t>(i));  // looked at, and left out
    const auto count = static_cast<std::size_t>(end - js);
    unsigned unsure = 0;
    for (std::size_t k = 0; k < count; k += Near::kAtOnce) {
      const Near::Floats four = Near::gaps(own, js + k);
      __builtin_memcpy(gaps + k, &four, sizeof four);
      unsure |= Near::lanes_of(four > surely_);
    }
    mine.count += unsure == 0 ? count : keep_near(i, {js, count}, gaps);
  }

  /// Those of a few that are near to the last bit, to their front.
  std::size_t keep_near(std::size_t i, std::span<std::uint32_t> js, float* gaps) const {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < js.size(); ++k)
      if (gaps[k] <= surely_ || are_near(spheres_[i], spheres_[js[k]])) js[kept] = js[k], gaps[kept++] = gaps[k];
    return kept;
  }

  /// Each large sphere with the small ones and with the large ones above it; sorted, lower index first.
  std::vector<Pair> pairs_of_large() const {
    std::vector<Pair> out;
    for (const std::uint32_t i : large_) {
      const Sphere& s = spheres_[i];
      const double far = s.r + grid_.fits + cutoff_;
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

  std::span<const Sphere> spheres_;
  const Grid& grid_;
  double cutoff_;
  int threads_;
  Near near_;
  std::vector<std::uint32_t> large_;
  float error_ = 0;   ///< of a gap, m
  float margin_ = 0;  ///< gap above which no pair is near, m
  float surely_ = 0;  ///< and below which each is
};

}  // namespace

NeighbourList find_neighbours(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads) {
  return NeighbourSearch(spheres, grid, cutoff, threads).run();
}

}  // namespace subsoil::dem
