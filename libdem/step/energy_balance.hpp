#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/contacts/surface_contacts.hpp"
#include "libdem/step/sampling.hpp"

namespace subsoil::dem {

/// Running maximum that takes a NaN and keeps it: no later finite value replaces it, so the fault is found.
inline bool exceeds(double value, double largest) { return !(value <= largest) && largest == largest; }

/// What a step leaves of one particle block. Energies in J.
struct BlockSums {
  Losses lost;                                        ///< running, since the lists were built
  double stored = 0;                                  ///< in contacts, in this step
  double kinetic = 0, rotational = 0, potential = 0;  ///< of the spheres, when asked for
  double pairs = 0, overlap = 0;  ///< within the cutoff; maximum share of a radius: of its last sample
  double frozen = 0;              ///< running: taken from spheres that fell asleep
  double speed2 = 0;              ///< maximum v.v after the move, m2/s2
  double squares = 0;             ///< a sum over velocities: NaN where one is
};

/// Energies of bodies at one instant, J.
struct BodyEnergy {
  double kinetic = 0, rotational = 0, potential = 0;
};

/// Energy balance of the bed, and the extremes by which a step is judged.
///
/// | data                       | written by                                                | read by              |
/// |---|---|---|
/// | of_block                   | the worker of the particle block, during the sweep        | `sum_*`, saved state |
/// | lost in surface contacts   | lies with the chunks (SurfaceContacts), before the sweep  | `sum_energy`         |
/// | lost_before, removed       | rebuilds (`fold`), bonds that break, spheres that leave   | `sum_energy`         |
/// | energy                     | `sum_energy`, in steps that ask for it                    | users                |
/// | extremes                   | `sum_extremes`, each step                                 | users, fault check   |
///
/// Sums run over particle blocks, in their order, and in a block over its runs: fixed by the lists alone, so they are
/// the same bits for any number of threads. One record per particle block in place of one per worker: sums by worker
/// would follow the threads.
class EnergyBalance {
 public:
  std::vector<BlockSums> of_block;
  Losses lost_before;        ///< accumulated in lists that are gone, and by bonds that broke
  double removed = 0;        ///< BedEnergy::removed
  double frozen_before = 0;  ///< taken from spheres that fell asleep, in lists that are gone
  struct Extremes {
    double speed2 = 0, overlap = 0;
    double squares = 0;  ///< of velocities
    std::size_t pairs = 0;
  };

  void begin_lists(std::size_t blocks) { of_block.assign(blocks, {}); }
  /// Losses out of lists that are about to go.
  void fold(std::vector<SurfaceChunk>& chunks);
  void reset() { lost_before = {}, removed = frozen_before = 0; }  ///< after `fold`

  /// Which particle blocks this step samples. @param all energies or a snapshot are asked for, or it is the first step:
  /// spheres placed into each other are found at once
  void plan(const BedOptions& options, std::size_t spheres, long step, bool new_lists, bool all);
  Sample sample(std::size_t block) const;
  Sampling& sampling() { return sampling_; }
  const Sampling& sampling() const { return sampling_; }

  void sum_extremes(std::span<const SurfaceChunk> chunks);
  void sum_energy(std::span<const SurfaceChunk> chunks, std::span<const Boundary> boundaries, double work_of_fixed,
                  double work_of_forces, const BodyEnergy& of_clumps);
  Losses lost(std::span<const SurfaceChunk> chunks) const;  ///< since the start
  double frozen() const;                                    ///< since the start
  const BedEnergy& energy() const { return energy_; }       ///< of the last step that asked for it
  const Extremes& extremes() const { return extremes_; }

 private:
  Sampling sampling_;
  bool all_ = true;  ///< in this step, beside what is sampled
  BedEnergy energy_;
  Extremes extremes_;
};

}  // namespace subsoil::dem
