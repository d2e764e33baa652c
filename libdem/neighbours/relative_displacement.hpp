#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <span>
#include <utility>
#include <vector>

#include "libdem/base/buffer.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/neighbours/grid.hpp"

namespace subsoil::dem {

/// How far spheres have moved against each other since the lists were built, measured. What steps add up is a bound on
/// paths: two spheres that a tool pushes the same way are taken to have come apart by twice its path.
///
/// Written at rebuilds (`begin`: 24 bytes per sphere; floats would do for measuring, but a restart builds the lists
/// again from these places and needs them to the last bit) and when paths no longer suffice (`measure`); belongs to
/// RebuildCriterion.
class RelativeDisplacement {
 public:
  struct Found {
    /// Most that two spheres moved against each other, m, of which one may have come to touch the other; no less than
    /// half the skin.
    double parted = 0;
    double gone = 0;                  ///< longest way of a sphere
    std::span<const double> against;  ///< most that a sphere moved against each boundary, m
  };

  /// Also takes the memory for what will be measured. centre(i) of sphere i, in the order of the grid's cells.
  template <class Centre>
  void begin(Grid grid, double skin, std::size_t count, std::size_t boundaries, int threads, const Centre& centre) {
    grid_ = std::move(grid), skin_ = skin;
    was_.renew(count);
    layers_.resize(static_cast<std::size_t>(cubes(0)));
    cubes_.resize(layers_.size() * static_cast<std::size_t>(cubes(1) * cubes(2)));
    against_.resize((layers_.size() + 1) * boundaries);
    const auto number = static_cast<long>(count);
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long k = 0; k < number; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Vec3 x = centre(i);
      was_[i] = {x.x, x.y, x.z};
    }
  }
  /// Centres when the lists were built.
  Vec3 was(std::size_t i) const { return {was_[i][0], was_[i][1], was_[i][2]}; }
  std::size_t size() const { return was_.size(); }
  /// What was measured before a restart: `against` as set_found() has it then.
  Found room_for_found(double parted, double gone, std::size_t boundaries) {
    return {.parted = parted, .gone = gone, .against = of_layer(layers_.size(), boundaries)};
  }
  void set_found(std::span<const double> against) {
    std::copy(against.begin(), against.end(), of_layer(layers_.size(), against.size()).begin());
  }

  /// What `begin` has set; what was measured since is found again.
  void copy(const RelativeDisplacement& from) {
    grid_ = from.grid_, skin_ = from.skin_;
    was_.copy(from.was_);
    cubes_.resize(from.cubes_.size()), layers_.resize(from.layers_.size()), against_.resize(from.against_.size());
  }

  /// @param boundaries their ways since the lists were built
  /// @param enough when `parted` is above it, nobody asks by how much: the rest is left out
  /// @return valid until the next is measured
  template <class Centre>
  Found measure(std::span<const Vec3> boundaries, double enough, int threads, const Centre& centre) {
    const int layers = cubes(0);
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (int a = 0; a < layers; ++a) layers_[static_cast<std::size_t>(a)] = measure_layer(a, boundaries, centre);
    // Of two spheres that parted by more than half the skin one went more than a quarter of it.
    std::atomic<double> parted = 0.5 * skin_;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (int a = 0; a < layers; ++a)
      if (layers_[static_cast<std::size_t>(a)].gone > 0.25 * skin_) compare_layer(a, enough, centre, parted);
    return of_all(parted, boundaries.size());
  }

 private:
  static constexpr int kCube = 4;    ///< cells along an edge of a cube, by which those that move alike are passed over
  static constexpr int kMargin = 2;  ///< how many cells apart spheres of a pair may have been, and one more:
  static constexpr int kAround = kMargin + 1;  ///< across a periodic side, since the last cell may end short

  /// Cubes with the same first coordinate.
  struct Layer {
    double gone;
    std::span<double> against;
  };
  /// After the last layer that of all together.
  std::span<double> of_layer(std::size_t layer, std::size_t boundaries) {
    return std::span(against_).subspan(layer * boundaries, boundaries);
  }

  /// Cells or cubes along an axis, ends included; across a periodic side numbers run on.
  struct Range {
    int first, last;
  };
  int cubes(int axis) const { return (grid_.n[axis] + kCube - 1) / kCube; }
  Range cells_of(int cube, int axis) const { return {kCube * cube, std::min(kCube * (cube + 1), grid_.n[axis]) - 1}; }
  Range around(Range cells, int axis) const {
    const int end = grid_.n[axis] - 1;
    return {cells.first >= kMargin ? cells.first - kMargin
            : grid_.around[axis]   ? cells.first - kAround
                                   : 0,
            cells.last + kMargin <= end ? cells.last + kMargin
            : grid_.around[axis]        ? cells.last + kAround
                                        : end};
  }
  /// Of a number that ran on.
  int cell(int k, int axis) const {
    const int n = grid_.n[axis];
    return k < 0 ? std::max(k + n, 0) : k < n ? k : std::min(k - n, n - 1);
  }
  std::size_t cube_index(int a, int b, int c) const {
    return (static_cast<std::size_t>(a) * static_cast<std::size_t>(cubes(1)) + static_cast<std::size_t>(b)) *
               static_cast<std::size_t>(cubes(2)) +
           static_cast<std::size_t>(c);
  }
  struct Cells {
    Range of[3];
    /// use(a, b, c) of each.
    template <class Use>
    void each(const Use& use) const {
      for (int a = of[0].first; a <= of[0].last; ++a)
        for (int b = of[1].first; b <= of[1].last; ++b)
          for (int c = of[2].first; c <= of[2].last; ++c) use(a, b, c);
    }
  };
  /// Numbers of the cubes along an axis in which cells lie.
  struct Cubes {
    std::array<int, kCube + 2 * kAround> of;
    std::size_t count = 0;
    const int* begin() const { return of.data(); }
    const int* end() const { return of.data() + count; }
  };
  Cubes cubes_of(Range cells, int axis) const;
  Cells around(const Cells& cells) const {
    return {{around(cells.of[0], 0), around(cells.of[1], 1), around(cells.of[2], 2)}};
  }
  Cells cells_of_cube(int a, int b, int c) const { return {{cells_of(a, 0), cells_of(b, 1), cells_of(c, 2)}}; }

  template <class Centre>
  Bounds ways(std::size_t cell, const Centre& centre) const {
    Bounds out;
    for (std::size_t i = grid_.start[cell]; i < grid_.start[cell + 1]; ++i) {
      const Vec3 then = was(i) - grid_.low;
      out.include(centre(i) - grid_.low -
                  Vec3{static_cast<float>(then.x), static_cast<float>(then.y), static_cast<float>(then.z)});
    }
    return out;
  }

  template <class Centre>
  Layer measure_layer(int a, std::span<const Vec3> boundaries, const Centre& centre) {
    Layer layer{.gone = 0, .against = of_layer(static_cast<std::size_t>(a), boundaries.size())};
    std::fill(layer.against.begin(), layer.against.end(), 0.0);
    for (int b = 0; b < cubes(1); ++b)
      for (int c = 0; c < cubes(2); ++c) {
        Bounds all;
        cells_of_cube(a, b, c).each([&](int i, int j, int k) {
          const Bounds of_cell = ways(grid_.index(i, j, k), centre);
          if (of_cell.empty()) return;
          include(of_cell, boundaries, layer);
          all.include(of_cell);
        });
        cubes_[cube_index(a, b, c)] = all;
      }
    return layer;
  }

  template <class Centre>
  void compare_layer(int a, double enough, const Centre& centre, std::atomic<double>& parted) const {
    for (int b = 0; b < cubes(1); ++b)
      for (int c = 0; c < cubes(2); ++c) {
        const double before = parted.load(std::memory_order_relaxed);
        if (before > enough) return;
        if (!may_part(a, b, c, before)) continue;
        const double here = parted_around(cells_of_cube(a, b, c), before, centre);
        for (double most = before; here > most && !parted.compare_exchange_weak(most, here);) {
        }
      }
  }

  /// Whether a sphere of a cube and one of its surroundings may have parted by more than is known.
  bool may_part(int a, int b, int c, double known) const;

  /// Of the cells of a cube and those up to two away from them; `known` if none parted by more. Spheres of cells that
  /// are farther apart were more than two cells from each other: they touch only when they have come nearer by a
  /// sphere's diameter and the skin twice over, which none does that is within the skin of its place.
  template <class Centre>
  double parted_around(const Cells& cube, double known, const Centre& centre) const {
    constexpr int width = kCube + 2 * kAround;
    std::array<Bounds, width * width * width> ways_of;  // of all that are read: worked out once
    const Cells near = around(cube);
    const auto place = [&](int a, int b, int c) -> Bounds& {
      const int i = a - near.of[0].first, j = b - near.of[1].first, k = c - near.of[2].first;
      return ways_of[static_cast<std::size_t>((i * width + j) * width + k)];
    };
    near.each(
        [&](int a, int b, int c) { place(a, b, c) = ways(grid_.index(cell(a, 0), cell(b, 1), cell(c, 2)), centre); });
    double squared = 0;
    cube.each([&](int a, int b, int c) {
      const Bounds own = place(a, b, c);
      if (own.empty() || own.farthest(Vec3{}) <= 0.25 * skin_) return;
      around(Cells{{{a, a}, {b, b}, {c, c}}}).each([&](int i, int j, int k) {
        const Bounds& other = place(i, j, k);
        if (!other.empty()) squared = std::max(squared, own.farthest_squared(other));
      });
    });
    return std::max(known, std::sqrt(squared));
  }

  static void include(const Bounds& of_cell, std::span<const Vec3> boundaries, Layer& found);
  Found of_all(double parted, std::size_t boundaries);

  Grid grid_;
  double skin_ = 0;
  Buffer<std::array<double, 3>> was_;  ///< centres when the lists were built
  std::vector<Bounds> cubes_;          ///< of the ways of all spheres of a cube of cells
  std::vector<Layer> layers_;          ///< across the longest side of the grid
  std::vector<double> against_;        ///< of each layer, then of all together, by boundary
};

}  // namespace subsoil::dem
