#pragma once
#include <algorithm>
#include <array>
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
/// again from these places and needs them to the last bit) and when paths say no more (`measure`); belongs to
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
    slabs_.resize(static_cast<std::size_t>(grid_.n[0]));
    against_.resize((slabs_.size() + 1) * boundaries);
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
  /// What was measured before a restart. @param next reads one number
  template <class Next>
  Found found_again(double parted, double gone, std::size_t boundaries, const Next& next) {
    const std::span<double> against = of_slab(slabs_.size(), boundaries);
    for (double& x : against) x = next();
    return {.parted = parted, .gone = gone, .against = against};
  }

  /// @param boundaries their ways since the lists were built
  /// @return valid until the next is measured
  template <class Centre>
  Found measure(std::span<const Vec3> boundaries, int threads, const Centre& centre) {
    // Of two spheres that parted by more than half the skin one went more than a quarter of it: few cells have such.
    // Ways are worked out again for the neighbours of these: to keep those of all cells would take longer.
    const double far = 0.25 * skin_;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (int a = 0; a < grid_.n[0]; ++a) {
      Slab slab{.parted = 2 * far, .gone = 0, .against = of_slab(static_cast<std::size_t>(a), boundaries.size())};
      std::fill(slab.against.begin(), slab.against.end(), 0.0);
      for (int b = 0; b < grid_.n[1]; ++b)
        for (int c = 0; c < grid_.n[2]; ++c) {
          const Bounds of_cell = ways(grid_.index(a, b, c), centre);
          if (of_cell.empty()) continue;
          if (include(of_cell, boundaries, slab) > far)
            slab.parted = std::max(slab.parted, parted_around(of_cell, a, b, c, centre));
        }
      slabs_[static_cast<std::size_t>(a)] = slab;
    }
    return of_all(boundaries.size());
  }

 private:
  struct Slab {
    double parted, gone;
    std::span<double> against;
  };
  /// After the last slab that of all together.
  std::span<double> of_slab(std::size_t slab, std::size_t boundaries) {
    return std::span(against_).subspan(slab * boundaries, boundaries);
  }

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

  /// Of a cell and those up to two away from it. Spheres of cells that are farther apart were more than two cells from
  /// each other: they touch only when they have come nearer by a sphere's diameter and the skin twice over, which none
  /// does that is within the skin of its place.
  template <class Centre>
  double parted_around(const Bounds& own, int a, int b, int c, const Centre& centre) const {
    // Around a periodic side one more, since the last cell may end short.
    const auto from = [&](int k, int axis) { return k >= 2 ? k - 2 : grid_.around[axis] ? k - 3 : 0; };
    const auto to = [&](int k, int axis) {
      const int last = grid_.n[axis] - 1;
      return k + 2 <= last ? k + 2 : grid_.around[axis] ? k + 3 : last;
    };
    const auto cell = [&](int k, int axis) {
      const int n = grid_.n[axis];
      return k < 0 ? std::max(k + n, 0) : k < n ? k : std::min(k - n, n - 1);
    };
    double parted = 0;
    for (int i = from(a, 0); i <= to(a, 0); ++i)
      for (int j = from(b, 1); j <= to(b, 1); ++j)
        for (int k = from(c, 2); k <= to(c, 2); ++k)
          if (const Bounds other = ways(grid_.index(cell(i, 0), cell(j, 1), cell(k, 2)), centre); !other.empty())
            parted = std::max(parted, own.farthest(other));
    return parted;
  }

  /// Returns the longest way of its spheres.
  static double include(const Bounds& of_cell, std::span<const Vec3> boundaries, Slab& found);
  Found of_all(std::size_t boundaries);

  Grid grid_;
  double skin_ = 0;
  Buffer<std::array<double, 3>> was_;  ///< centres when the lists were built
  std::vector<Slab> slabs_;            ///< cells across the longest side of the grid
  std::vector<double> against_;        ///< of each slab, then of all together, by boundary
};

}  // namespace subsoil::dem
