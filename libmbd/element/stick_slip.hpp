#pragma once

#include <array>
#include <cmath>

#include "libmbd/element/force.hpp"

namespace subsoil::mbd {

/// Dry friction of two surfaces that slide on each other or stick, its force F on b along the way s (m) at v = s'
/// (m/s), for a limit G = mu N (N) and the stiffness k (N/m) of surfaces at rest on each other:
///   slides (sigma = +-1, the sense of v)  F = -sigma G             until v = 0, where it sticks
///   sticks                                F = -k (s - s_0) - d v   until |F| = G
/// Both ends are events, located in time. Surfaces that slide are strained by their friction, so the spring does not
/// begin at 0: s_0 is such that F holds the surfaces at rest as they begin to stick, s'' = 0, or as much of F as G
/// allows (`System::grip`). Nothing swings then. Later jumps of the load are damped by d [N s/m] >= 0, critical if
/// left out: 2 (k m)^(1/2), with m the inertia against F along s at that instant (s'' = F/m), and where a joint has
/// opened or closed since, at that one.
/// Where nothing presses them yet (G = 0) surfaces stick only while s'' = 0, else they slide in its sense: |F| - G is
/// zero there without passing through it, so that no root would show the end of sticking.
/// Source: Karnopp 1985, J. Dyn. Sys. Meas. Control 107, 100, with a spring in place of his exact rest.
struct StickSlip {
  int sliding = 0;      ///< 0 sticks, else the sense in which it slides
  double stuck_at = 0;  ///< s_0 (m)
  double damping = 0;   ///< d (N s/m)

  static constexpr double rest_speed = 1e-9;  // m/s
  /// Of G that the spring begins with at the most: surfaces that cannot be held have to be seen sliding.
  static constexpr double most_of_grip = 1 - 1e-4;

  bool sticks() const { return sliding == 0; }
  double spring(double k, double s, double v) const { return -k * (s - stuck_at) - damping * v; }
  double stored(double k, double s) const { return 0.5 * k * (s - stuck_at) * (s - stuck_at); }

  /// Falls through 0 where it changes between sliding and sticking.
  double hold(double k, double s, double v, double limit) const {
    // A speed of rounding's size, as it begins to slide, is not the end of sliding.
    return sticks() ? limit - std::abs(spring(k, s, v)) : sliding * v + 1e-12;
  }
  /// The heat is the strain that sliding gives back.
  Changeover pass_event(double k, double s, double v) {
    if (sliding * v < -rest_speed) {  // an impact has turned it
      sliding = -sliding;
      return {0, true};
    }
    if (!sticks()) {
      sliding = 0, stuck_at = s;
      return {};
    }
    sliding = (std::abs(v) > rest_speed ? v : -spring(k, s, v)) > 0 ? 1 : -1;
    return {stored(k, s), true};
  }
  /// Sticks from now on with that force on b, and damped by `given`, NaN: critically for that mass along s. Returns
  /// what its spring stores (J).
  double grip(double k, double s, double v, double force, double mass, double given) {
    damp(k, mass, given);
    stuck_at = s + (force + damping * v) / k;
    return stored(k, s);
  }
  /// From now on damped as by `grip`, for that mass.
  void damp(double k, double mass, double given) { damping = std::isnan(given) ? 2 * std::sqrt(k * mass) : given; }
  /// Slides from now on.
  void slide(int sense) { sliding = sense; }
  /// Slides if it moves, else sticks where it is.
  void begin(double s, double v, double given) {
    sliding = std::abs(v) < rest_speed ? 0 : v > 0 ? 1 : -1;
    stuck_at = s, damping = std::isnan(given) ? 0 : given;
  }
  std::array<double, 3> memory() const { return {static_cast<double>(sliding), stuck_at, damping}; }
  void set_memory(const std::array<double, 3>& m) { sliding = static_cast<int>(m[0]), stuck_at = m[1], damping = m[2]; }
};

}  // namespace subsoil::mbd
