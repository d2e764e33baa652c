#pragma once

#include <array>
#include <cstddef>

#include "libmbd/body.hpp"

namespace subsoil::mbd {

/// One scalar constraint Phi(q, t) = 0 between body a and body b, as a joint or driver hands it over.
///   on_a, on_b  dPhi/d(x, y, angle) of the two bodies: its row of Phi_q
///   on_c        the same of a third body, for elements that have a body_c
///   gamma       right side of Phi_q q'' = gamma: -(Phi_q q')_q q' - 2 Phi_qt q' - Phi_tt
///   phi_t       dPhi/dt at fixed q; zero but for drivers
/// Multipliers follow M q'' + Phi_q^T lambda = F: the constraint puts -on_a * lambda on a and -on_b * lambda on b.
struct Row {
  double phi = 0;
  std::array<double, 3> on_a{}, on_b{};
  double gamma = 0;
  double phi_t = 0;
  std::array<double, 3> on_c{};
};

template <std::size_t n>
using Rows = std::array<Row, n>;

}  // namespace subsoil::mbd
