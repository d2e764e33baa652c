#include "libdem/step/energy_balance.hpp"

#include <algorithm>

namespace subsoil::dem {

void EnergyBalance::fold(std::vector<SurfaceChunk>& chunks) {
  for (BlockSums& b : of_block) {
    lost_before += b.lost, b.lost = {};
    frozen_before += b.frozen, b.frozen = 0;
  }
  for (SurfaceChunk& c : chunks) lost_before += c.lost, c.lost = {};
}

void EnergyBalance::plan(const BedOptions& options, std::size_t spheres, long step, bool new_lists, bool all) {
  constexpr std::size_t few = 5000;
  constexpr int sampled = 32;
  const int every = options.sample_every > 0 ? options.sample_every : spheres <= few ? 1 : sampled;
  sampling_.begin(every, step, new_lists);
  all_ = all;
}

Sample EnergyBalance::sample(std::size_t block) const {
  Sample of = sampling_.of(block);
  if (all_) of.record = of.accumulate = true;
  return of;
}

void EnergyBalance::sum_extremes(std::span<const SurfaceChunk> chunks) {
  extremes_ = {};
  double pairs = 0;
  for (const BlockSums& b : of_block) {
    extremes_.speed2 = std::max(extremes_.speed2, b.speed2);
    extremes_.overlap = std::max(extremes_.overlap, b.overlap);
    extremes_.squares += b.squares;
    pairs += b.pairs;
  }
  extremes_.pairs = static_cast<std::size_t>(pairs);
  for (const SurfaceChunk& c : chunks)
    if (exceeds(c.max_overlap, extremes_.overlap)) extremes_.overlap = c.max_overlap;
}

void EnergyBalance::sum_energy(std::span<const SurfaceChunk> chunks, std::span<const Boundary> boundaries,
                               double work_of_fixed, double work_of_forces, const BodyEnergy& of_clumps) {
  energy_ = {.lost = lost_before, .removed = removed, .frozen = frozen()};
  for (const BlockSums& b : of_block) {
    energy_.kinetic += b.kinetic;
    energy_.rotational += b.rotational;
    energy_.gravity += b.potential;
    energy_.stored += b.stored;
    energy_.lost += b.lost;
  }
  energy_.kinetic += of_clumps.kinetic, energy_.rotational += of_clumps.rotational;
  energy_.gravity += of_clumps.potential;
  for (const SurfaceChunk& c : chunks) energy_.stored += c.stored, energy_.lost += c.lost;
  energy_.force_work = work_of_forces;
  energy_.boundary_work = work_of_fixed;
  for (const Boundary& b : boundaries) energy_.boundary_work += b.work;
}

Losses EnergyBalance::lost(std::span<const SurfaceChunk> chunks) const {
  Losses lost = lost_before;
  for (const BlockSums& b : of_block) lost += b.lost;
  for (const SurfaceChunk& c : chunks) lost += c.lost;
  return lost;
}

double EnergyBalance::frozen() const {
  double sum = frozen_before;
  for (const BlockSums& b : of_block) sum += b.frozen;
  return sum;
}

}  // namespace subsoil::dem
