#pragma once
#include <span>
#include <vector>

#include "coupling/simulation.hpp"
#include "libdem/packing/moving_bed.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

struct World;
struct BuildOptions;

/// The window of a moving bed, and whom it follows.
struct MovingSoil {
  dem::MovingBed window;
  std::vector<int> walls;  ///< boundaries that advance with it
  int boundary = -1;       ///< that it follows, or
  int body = 0;            ///< of the machine; 0: nobody, where the bed was stopped on its way to rest
  double start = 0;        ///< x of that at time 0, m

  double x_of_followed(const coupling::Simulation& simulation) const;
  /// Between two steps: advances by a block where what it follows has travelled one more; whether it did.
  bool follow(dem::Bed& bed, const coupling::Simulation& simulation);
};

/// What moves freely in the window.
struct FreeSoil {
  std::size_t spheres = 0;
  double mass = 0;  ///< kg
};
FreeSoil free_soil(const dem::Bed& bed);
/// Spheres and mass of the report: those in the window.
void count_window(World& world);

/// Walls and spheres of a moving bed: one block is made, periodic along x, in a bed of its own, and copied.
/// @param bed options of the world's bed
void build_moving_soil(World& world, const Loaded& loaded, const BuildOptions& options, const dem::BedOptions& bed);
/// Whom it follows, when all surfaces are there.
void find_followed(World& world, const Loaded& loaded);

}  // namespace subsoil::sim
