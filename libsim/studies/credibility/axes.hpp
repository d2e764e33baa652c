#pragma once
#include <string>
#include <vector>

#include "libsim/scenario/load.hpp"
#include "libsim/studies/sweep/study.hpp"

/// `subsoil credibility`: how far the numbers of a scenario depend on what is not physics.
namespace subsoil::sim {

/// One change of a scenario, all else as given.
struct Axis {
  std::string name;               ///< "step", "bin along the travel", "packing 2", ...
  std::string change;             ///< in words: "half the step"
  std::vector<std::string> sets;  ///< path=value
  double spheres = 1, steps = 1;  ///< factors on the cost
  bool packing = false;           ///< one of the packings that give the scatter
  bool refinement = false;        ///< halves a grid: a convergence index can be stated
};

/// An axis that this scenario does not have, and why.
struct AbsentAxis {
  std::string name, why;
};

struct Axes {
  std::vector<Axis> axes;  ///< the first is the scenario as given
  std::vector<AbsentAxis> absent;
  bool base_is_packing = false;  ///< the scenario as given is one of the packings: a random bed, or a shaken lattice
};

/// As given; half the step; twice the stiffness (all contacts, attraction as before); half the radius; twice the bin
/// along and across the travel, twice the bed below; three packings; twice the coupling step; the iterated
/// exchange. Throws ScenarioError for a scenario without a bed: it has none of these.
Axes credibility_axes(const Loaded& loaded);

/// Of the axes those that begin with one of these words (`bin` for all three, `packing`); the scenario as given stays,
/// the others are named as left out. All without words. Throws std::invalid_argument for a word that is no axis.
void keep_axes(Axes& axes, const std::vector<std::string>& words);

}  // namespace subsoil::sim
