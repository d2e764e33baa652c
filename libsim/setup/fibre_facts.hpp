#pragma once
#include <cstddef>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/setup/fibres.hpp"

namespace subsoil::sim {

struct World;

/// Where the fibres of a name lie. Each sphere stands for its share of the mass. It is buried where soil lies above its
/// centre, and its depth is the height of the soil on the vertical line through it: as one sees it from above, of what
/// a tool has left there.
struct FibreFacts {
  double mass = 0;               ///< kg, of the spheres that are there
  double buried = 0;             ///< kg
  double band = 0;               ///< m, thickness of the bands
  std::vector<double> by_depth;  ///< kg buried in each band from the surface down; the last one takes what is deeper
  double mean_depth = 0;         ///< m, of what is buried
  double to_horizontal = 0;      ///< rad, mean angle of intact segments to the horizontal plane
  double to_x = 0;               ///< rad, to the x axis
  double order = 0;  ///< nematic: maximum eigenvalue of the mean of (3 u u - 1)/2; 0 in any direction, 1 parallel
  std::size_t segments = 0;  ///< intact bonds
  std::size_t broken = 0;    ///< bonds, since the run began
  std::size_t cut = 0;       ///< of these by edges

  double on_surface() const { return mass - buried; }
  void archive(Archive& a) {
    a("mass", mass)("buried", buried)("band", band)("by depth", by_depth)("mean depth", mean_depth);
    a("to horizontal", to_horizontal)("to x", to_x)("order", order)("segments", segments)("broken", broken);
    a("cut", cut);
  }
};

/// Of each group of World::fibres.
std::vector<FibreFacts> fibre_facts(const World& world);

/// Of what is there of each group the share that is buried, 0 of nothing. The soil is searched once an instant for all
/// groups, and not at all where none is asked for.
class BuriedFibres {
 public:
  explicit BuriedFibres(const World& world) : world_(world) {}
  void begin_instant() { shares_.clear(); }
  double share(std::size_t group) { return shares()[group]; }

 private:
  const std::vector<double>& shares();

  const World& world_;
  std::vector<double> shares_;  ///< empty: not asked for yet
};
std::size_t broken_bonds(const World& world, const FibreGroup& group);
std::size_t cut_bonds(const World& world, const FibreGroup& group);  ///< by edges

}  // namespace subsoil::sim
