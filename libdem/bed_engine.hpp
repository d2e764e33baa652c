#pragma once
#include <span>

#include "libdem/bed.hpp"

namespace subsoil::dem {

/// A step that an engine takes, from t_n to t_{n+1}.
struct EngineStep {
  double dt = 0, dt_before = 0;  ///< s: this step and the one before it
  bool energy = false;           ///< whether energies at t_n are asked for
  Snapshot* snapshot = nullptr;  ///< to be filled with the state at t_n
};

/// What one step of an engine leaves, summed over all spheres. Energies in J.
struct EngineSums {
  double kinetic = 0, rotational = 0, gravity = 0;  ///< at t_n, of steps that ask for energies
  double stored = 0;                                ///< in contacts, at their last sample
  Losses lost;                                      ///< in this step
  double removed = 0;                               ///< energy that left with spheres in this step
  double pairs = 0, overlap = 0;                    ///< as those of a bed, at their last sample
  double speed2 = 0;                                ///< maximum v.v after the move, m2/s2
  double squares = 0;                               ///< a sum over velocities: NaN where one is
  std::size_t fallen = 0;                           ///< spheres that left in this step
  bool new_lists = false;
};

/// What steps the spheres of a bed in the bed's place, on many processes for instance. The bed keeps boundaries, energy
/// balance, limits and time; spheres and contacts are the engine's from `begin` on, and come back by `collect`.
class BedEngine {
 public:
  virtual ~BedEngine() = default;
  virtual const char* name() const = 0;  ///< with the number of processes
  /// Takes over spheres and contacts of a state; boundaries stand as in the step that follows.
  virtual void begin(const Bed::State& state, const BedOptions& options, std::span<const Boundary> boundaries) = 0;
  /// Boundaries stand at t_n; writes wrench, meshes and contacts of each.
  virtual EngineSums step(const EngineStep& step, std::span<Boundary> boundaries) = 0;
  /// Spheres as they are now and, where wished for, their contacts, with those at surfaces.
  virtual Bed::State collect(bool contacts) = 0;
};

}  // namespace subsoil::dem
