#include "libdem/neighbours/neighbour_list.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

/// Neighbour search by cells: half list of the pairs within the cutoff and a skin.
namespace subsoil::dem {

namespace {

/// Centres relative to the grid and radii, as the first look at a pair needs them: a sixth of the records' bytes, and
/// four spheres at a time.
class Near {
 public:
  Near(std::span<const Sphere> spheres, const Vec3& origin, int threads) {
    const auto number = static_cast<long>(spheres.size());
    for (Buffer<float>* column : {&x_, &y_, &z_, &r_}) {
      column->renew(spheres.size() + kAtOnce);
      std::fill_n(column->data() + spheres.size(), kAtOnce, 0.0f);  // read, and left out
    }
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long i = 0; i < number; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Vec3 x = spheres[k].x - origin;
      x_[k] = static_cast<float>(x.x), y_[k] = static_cast<float>(x.y), z_[k] = static_cast<float>(x.z);
      r_[k] = static_cast<float>(spheres[k].r);
    }
  }

  /// Those of begin to end whose gap to sphere i may be below the margin, to `out` from n on; returns how many are
  /// there then. `out` has kAtOnce elements more than may be found.
  std::size_t scan(std::size_t i, float margin, std::size_t begin, std::size_t end, std::uint32_t* out,
                   std::size_t n) const {
    for (std::size_t j = begin; j < end; j += kAtOnce) {
      const Floats x = x_[i] - at(x_, j), y = y_[i] - at(y_, j), z = z_[i] - at(z_, j);
      const Floats limit = r_[i] + at(r_, j) + margin;
      const Ints left = Ints{0, 1, 2, 3} + static_cast<std::int32_t>(j) < static_cast<std::int32_t>(end);
      const Ints near = (x * x + y * y + z * z < limit * limit) & left;
      for (std::size_t l = 0; l < kAtOnce; ++l) {
        out[n] = static_cast<std::uint32_t>(j + l);
        n -= static_cast<std::size_t>(static_cast<std::ptrdiff_t>(near[l]));  // -1 where it is
      }
    }
    return n;
  }

  static constexpr std::size_t kAtOnce = 4;

 private:
  using Floats = float __attribute__((vector_size(4 * kAtOnce)));
  using Ints = std::int32_t __attribute__((vector_size(4 * kAtOnce)));
  static Floats at(const Buffer<float>& column, std::size_t j) {
    Floats f;
    __builtin_memcpy(&f, column.data() + j, sizeof f);
    return f;
  }

  Buffer<float> x_, y_, z_, r_;
};

/// What the spheres of one cell search: the rest of their own row, then the rows that come later, in the half of the 27
/// cells around that lies above. Cells of a row are neighbours in the sorted order.
struct Around {
  std::size_t end = 0;      ///< of the spheres of the cell
  std::size_t own_row = 0;  ///< end of what is searched of the own row
  std::array<std::pair<std::size_t, std::size_t>, 8> rows;
  std::size_t count = 0;
};

/// What a single-precision look may be wrong by, relative to the largest coordinate: differences of rounded coordinates
/// err by 2^-23 of them.
constexpr float kRounding = 4e-7f;

/// The neighbours of spheres that fit the cells, from 14 cells each, and of the few that do not, from all cells that
/// they may reach into.
class NeighbourSearch {
 public:
  NeighbourSearch(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads)
      : spheres_(spheres), grid_(grid), cutoff_(cutoff), threads_(threads), near_(spheres, grid.low, threads) {
    for (std::uint32_t i = 0; i < spheres.size(); ++i)
      if (spheres[i].r > grid.fits) large_.push_back(i);
    const double extent = grid.cell * std::max({grid.n[0], grid.n[1], grid.n[2]});
    margin_ = static_cast<float>(cutoff) + kRounding * static_cast<float>(extent + grid.cell);
  }

  NeighbourList run() {
    const std::size_t count = spheres_.size();
    NeighbourList list;
    list.start.assign(count + 1, 0);
    std::vector<std::vector<std::uint32_t>> found(static_cast<std::size_t>(threads_));
    const std::vector<Pair> of_large = pairs_of_large();
    const auto first_of = [&](int t) {
      return count * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads_);
    };
#pragma omp parallel for num_threads(threads_) schedule(static, 1)
    for (int t = 0; t < threads_; ++t) {
      auto& js = found[static_cast<std::size_t>(t)];
      js.reserve(5 * count / static_cast<std::size_t>(threads_) + 64);
      std::vector<std::uint32_t> maybe;
      Around around;
      for (std::size_t i = first_of(t); i < first_of(t + 1); ++i) {
        const std::size_t before = js.size();
        if (i >= around.end) around = around_cell_of(i);
        if (spheres_[i].r <= grid_.fits) small_with_small(i, around, maybe, js);
        auto extra = std::lower_bound(of_large.begin(), of_large.end(), Pair{static_cast<std::uint32_t>(i), 0});
        if (extra != of_large.end() && extra->first == i) {
          for (; extra != of_large.end() && extra->first == i; ++extra) js.push_back(extra->second);
          std::sort(js.begin() + static_cast<std::ptrdiff_t>(before), js.end());
        }
        list.start[i + 1] = static_cast<std::uint32_t>(js.size() - before);
      }
    }
    std::partial_sum(list.start.begin(), list.start.end(), list.start.begin());
    list.j.renew(list.start[count]);
#pragma omp parallel for num_threads(threads_) schedule(static, 1)
    for (int t = 0; t < threads_; ++t) {
      auto& js = found[static_cast<std::size_t>(t)];
      std::copy(js.begin(), js.end(), list.j.data() + list.start[first_of(t)]);
      js = {};
    }
    return list;
  }

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;

  bool are_near(const Sphere& a, const Sphere& b) const {
    const Vec3 d = a.x - b.x;
    const double limit = a.r + b.r + cutoff_;
    return dot(d, d) < limit * limit;
  }

  Around around_cell_of(std::size_t i) const {
    const Sphere& s = spheres_[i];
    const int row = grid_.coordinate(s.x, 0), b = grid_.coordinate(s.x, 1), c = grid_.coordinate(s.x, 2);
    const int c0 = std::max(c - 1, 0), c1 = std::min(c + 1, grid_.n[2] - 1);
    Around out;
    out.end = grid_.start[grid_.index(row, b, c) + 1];
    out.own_row = grid_.start[grid_.index(row, b, c1) + 1];
    const std::size_t own = grid_.index(row, b, c0);
    for (int e = std::max(row - 1, 0); e <= std::min(row + 1, grid_.n[0] - 1); ++e)
      for (int f = std::max(b - 1, 0); f <= std::min(b + 1, grid_.n[1] - 1); ++f)
        if (const std::size_t first = grid_.index(e, f, c0); first > own) {
          std::size_t k = out.count++;  // ascending
          for (; k > 0 && out.rows[k - 1].first > first; --k) out.rows[k] = out.rows[k - 1];
          out.rows[k] = {first, first + static_cast<std::size_t>(c1 - c0)};
        }
    for (std::size_t k = 0; k < out.count; ++k)
      out.rows[k] = {grid_.start[out.rows[k].first], grid_.start[out.rows[k].second + 1]};
    return out;
  }

  /// Partners above i.
  void small_with_small(std::size_t i, const Around& around, std::vector<std::uint32_t>& maybe,
                        std::vector<std::uint32_t>& js) const {
    std::size_t most = around.own_row - i + Near::kAtOnce, n = 0;
    for (std::size_t k = 0; k < around.count; ++k) most += around.rows[k].second - around.rows[k].first;
    if (maybe.size() < most) maybe.resize(2 * most);
    n = near_.scan(i, margin_, i + 1, around.own_row, maybe.data(), n);
    for (std::size_t k = 0; k < around.count; ++k)
      n = near_.scan(i, margin_, around.rows[k].first, around.rows[k].second, maybe.data(), n);
    const Sphere& s = spheres_[i];
    for (std::size_t k = 0; k < n; ++k)
      if (spheres_[maybe[k]].r <= grid_.fits && are_near(s, spheres_[maybe[k]])) js.push_back(maybe[k]);
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
  float margin_ = 0;
};

}  // namespace

NeighbourList find_neighbours(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads) {
  return NeighbourSearch(spheres, grid, cutoff, threads).run();
}

}  // namespace subsoil::dem
