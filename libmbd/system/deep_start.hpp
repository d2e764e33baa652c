#pragma once

#include <string>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A contact, stop or end of a cylinder that a machine starts beyond: what it stores there, the motion begins with.
struct DeepStart {
  std::string force;
  double depth = 0;      ///< beyond where the law begins (m, or rad)
  bool angular = false;  ///< of an angle
  double energy = 0;     ///< stored there (J)
  double push = 0;       ///< a bound from below on its force, 2 energy/depth (N, N m)
  double weight = 0;     ///< of the whole machine, of a moment times its length (N, N m)
};

/// Those of the state set last, after loads(), that no weight explains: they push with more than four times the weight
/// of the whole machine, twice what a weight does that is set down at once, and more than half of it is unbalanced.
/// `acceleration`: q'' of that state.
std::vector<DeepStart> deep_starts(const System& system, const Eigen::VectorXd& acceleration);

}  // namespace subsoil::mbd
