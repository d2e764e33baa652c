#pragma once
#include <array>
#include <vector>

#include "libdem/buffer.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/grid.hpp"

namespace subsoil::dem {

/// How far spheres have come since the lists were built, measured. What steps add up is a bound on paths: two spheres
/// that a tool pushes the same way are taken to have come apart by twice its path.
class Drift {
 public:
  struct Found {
    /// Most that two spheres moved against each other, m, of which one may have come to touch the other; no less than
    /// half the skin.
    double parted = 0;
    double gone = 0;              ///< longest way of a sphere
    std::vector<double> against;  ///< most that a sphere moved against each boundary, m
  };

  /// centre(i) of sphere i, in the order of the grid's cells.
  template <class Centre>
  void begin(Grid grid, double skin, std::size_t count, int threads, const Centre& centre) {
    grid_ = std::move(grid), skin_ = skin;
    was_.renew(count);
    const auto number = static_cast<long>(count);
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long k = 0; k < number; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Vec3 x = centre(i) - grid_.low;
      was_[i] = {static_cast<float>(x.x), static_cast<float>(x.y), static_cast<float>(x.z)};
    }
  }

  /// @param boundaries their ways since the lists were built
  template <class Centre>
  Found measure(const std::vector<Vec3>& boundaries, int threads, const Centre& centre) const {
    const auto cells = static_cast<long>(grid_.start.size()) - 1;
    std::vector<Bounds> ways(static_cast<std::size_t>(cells));
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long k = 0; k < cells; ++k) {
      const auto cell = static_cast<std::size_t>(k);
      for (std::size_t i = grid_.start[cell]; i < grid_.start[cell + 1]; ++i)
        ways[cell].include(centre(i) - grid_.low - Vec3{was_[i][0], was_[i][1], was_[i][2]});
    }
    return compare(ways, boundaries, threads);
  }

 private:
  Found compare(const std::vector<Bounds>& ways, const std::vector<Vec3>& boundaries, int threads) const;
  double parted_around(const std::vector<Bounds>& ways, int a, int b, int c) const;

  Grid grid_;
  double skin_ = 0;
  Buffer<std::array<float, 3>> was_;  ///< centres when the lists were built, from the grid's low corner
};

}  // namespace subsoil::dem
