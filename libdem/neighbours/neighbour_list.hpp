#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "libdem/base/buffer.hpp"
#include "libdem/neighbours/grid.hpp"
#include "libdem/particles/particles.hpp"

/// The room of the neighbour search. A rebuild sorts the spheres by cell (cell_sort.hpp), lists every pair that may
/// come to touch before the next one (here), and lays these out as blocks of contacts (contacts/contact_store.hpp); how
/// long a list holds is decided by RebuildCriterion (rebuild_criterion.hpp).
namespace subsoil::dem {

/// Half Verlet list: every pair of spheres nearer than cutoff and skin, once. Partners of sphere i are j[start[i]] ..
/// j[start[i + 1]], ascending and above i.
///
/// Written by `find_neighbours`; read by the layout of contacts, which forgets it: what steps work on are blocks. Eight
/// bytes a pair, and it lives during a rebuild only.
struct NeighbourList {
  std::vector<std::uint32_t> start{0};
  Buffer<std::uint32_t> j;
  Buffer<float> gap;    ///< between the surfaces, m; kUnknown where nobody has looked in single precision
  float gap_error = 0;  ///< maximum error of `gap`, m: whoever needs no more does not look at the spheres again

  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

  /// Leaves out all pairs of which keep(i, j) is false.
  template <class Keep>
  void keep_if(const Keep& keep) {
    std::uint32_t kept = 0, begin = 0;
    for (std::uint32_t i = 0; i + 1 < start.size(); ++i) {
      const std::uint32_t end = start[i + 1];
      for (std::uint32_t k = begin; k < end; ++k)
        if (keep(i, j[k])) j[kept] = j[k], gap[kept++] = gap[k];
      begin = end;
      start[i + 1] = kept;
    }
    j.shorten(kept), gap.shorten(kept);
  }
};

/// @param spheres sorted by the cells of `grid` @param cutoff maximum gap of a pair, m: of its law, and the skin
NeighbourList find_neighbours(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads);

}  // namespace subsoil::dem
