#include "libdem/neighbours/neighbour_list.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

/// Neighbour search by cells: half list of the pairs within the cutoff and a skin.
namespace subsoil::dem {

namespace {

/// Centre relative to the grid and radius, as the first look at a pair needs them: a quarter of the record's bytes.
struct Near {
  float x, y, z, r;
};

/// What a single-precision look may be wrong by, relative to the largest coordinate: differences of rounded coordinates
/// err by 2^-23 of them.
constexpr float kRounding = 4e-7f;

/// The neighbours of spheres that fit the cells, from 14 cells each, and of the few that do not, from all cells that
/// they may reach into.
class NeighbourSearch {
 public:
  NeighbourSearch(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads)
      : spheres_(spheres), grid_(grid), cutoff_(cutoff), threads_(threads) {
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
      for (std::size_t i = first_of(t); i < first_of(t + 1); ++i) {
        const std::size_t before = js.size();
        if (spheres_[i].r <= grid_.fits) small_with_small(i, maybe, js);
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

  /// Partners above i in the half of the 27 cells around it that lies above its own place.
  void small_with_small(std::size_t i, std::vector<std::uint32_t>& maybe, std::vector<std::uint32_t>& js) const {
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
  Buffer<Near> near_;
  std::vector<std::uint32_t> large_;
  float margin_ = 0;
};

}  // namespace

NeighbourList find_neighbours(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads) {
  return NeighbourSearch(spheres, grid, cutoff, threads).run();
}

}  // namespace subsoil::dem
