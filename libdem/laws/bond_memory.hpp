#pragma once

namespace subsoil::dem {

/// What a bonded pair remembers; scalars, and vectors as seen from i, world axes. `bond.hpp` has the law.
template <class T>
struct BondMemory {
  T shear[3] = {}, bend[3] = {}, twist{};                ///< m, rad, rad
  T reference{};                                         ///< delta_0, m
  T released{};                                          ///< of one that broke: the energy that it stored, J
  T state{};                                             ///< kNoBond ...
  T dash_n{}, dash_t[3] = {}, dash_r[3] = {}, dash_w{};  ///< dashpots at the last recorded step, N and N m

  /// Visits what steers the motion with its place 0, 1, ...; `released` comes last, for whoever leaves it out.
  template <class Visit>
  static constexpr void each_state(auto& b, const Visit& visit) {
    for (int d = 0; d < 3; ++d) visit(b.shear[d], d), visit(b.bend[d], 3 + d);
    visit(b.twist, 6), visit(b.reference, 7), visit(b.state, 8);
    visit(b.released, kReleased);
  }
  /// Likewise what only the energy balance needs.
  template <class Visit>
  static constexpr void each_diagnostic(auto& b, const Visit& visit) {
    visit(b.dash_n, 0), visit(b.dash_w, 1);
    for (int d = 0; d < 3; ++d) visit(b.dash_t[d], 2 + d), visit(b.dash_r[d], 5 + d);
  }
  static constexpr int kReleased = 9, kStates = 10, kDiagnostics = 8;

  /// With i and j exchanged: angles about n and along it stay as they are.
  BondMemory turned_over() const {
    BondMemory b = *this;
    for (int d = 0; d < 3; ++d)
      b.shear[d] = -b.shear[d], b.bend[d] = -b.bend[d], b.dash_t[d] = -b.dash_t[d], b.dash_r[d] = -b.dash_r[d];
    return b;
  }
};

/// A number of the contact like the others. A bond that broke reports it for one step, until the bed has counted it.
inline constexpr double kNoBond = 0, kBonded = 1, kBrokeInTension = 2, kBrokeInShear = 3, kBrokeByEdge = 4;
/// Holds, and breaks in the next step: an edge has cut through.
inline constexpr double kCutThrough = 1.25;
/// Whether it holds or did up to this step; whether it broke in it.
inline bool is_intact(double state) { return state > 0.5 && state < 1.5; }
inline bool has_broken(double state) { return state > 1.5; }

}  // namespace subsoil::dem
