#pragma once

#include <array>
#include <cstddef>

#include "libmbd/body.hpp"

namespace subsoil::mbd {

/// One scalar constraint Phi(q, t) = 0 between body a, body b and, for elements with a `body_c`, body c, as a joint or
/// driver hands it over.
///   on_a, on_b, on_c  dPhi/d(x, y, angle) of the bodies: its row of Phi_q
///   gamma       right side of Phi_q q'' = gamma: -(Phi_q q')_q q' - 2 Phi_qt q' - Phi_tt
///   phi_t       dPhi/dt at fixed q; zero but for drivers
/// Multipliers follow M q'' + Phi_q^T lambda = F: the constraint puts -on_a * lambda on a, -on_b * lambda on b, -on_c *
/// lambda on c.
struct Row {
  double phi = 0;
  std::array<double, 3> on_a{}, on_b{};
  double gamma = 0;
  double phi_t = 0;
  std::array<double, 3> on_c{};
};

/// What becomes of constraints that depend on each other: their reactions are the ones of least norm among all that
/// balance, or the machine is refused.
enum class Redundancy { minimum_norm, refuse };

template <std::size_t n>
using Rows = std::array<Row, n>;

}  // namespace subsoil::mbd
