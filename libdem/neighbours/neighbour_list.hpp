#pragma once
#include <cstdint>
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
/// Written by `find_neighbours`; read by the layout of contacts, which forgets it: what steps work on are blocks. Four
/// bytes a pair, and it lives during a rebuild only.
struct NeighbourList {
  std::vector<std::uint32_t> start{0};
  Buffer<std::uint32_t> j;
};

/// @param spheres sorted by the cells of `grid` @param cutoff maximum gap of a pair, m: of its law, and the skin
NeighbourList find_neighbours(std::span<const Sphere> spheres, const Grid& grid, double cutoff, int threads);

}  // namespace subsoil::dem
