#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "libdem/laws/bond_memory.hpp"
#include "libdem/laws/law.hpp"

/// What contacts remember from step to step, declared once: kernels, lists, and restarts visit its fields.
///
/// States steer the motion. Diagnostics are what the dashpots pulled at the last recorded step, which only feeds the
/// energy balance, where float's 1e-7 is far below its error; and whether the contact slipped, which laws with two
/// friction coefficients ask for.
namespace subsoil::dem {

inline constexpr std::uint32_t kBlock = 8;  ///< contacts of a block, the lanes of one cache line of doubles

/// T: of states, F: of diagnostics; SIMD vectors in kernels. Vectors in world axes, as seen from i.
template <class T, class F = T>
struct ContactMemory {
  T xi[3];              ///< tangential spring, m
  T rho[3];             ///< rolling spring, rad
  T own[kOwnMemory];    ///< of the law
  T twist;              ///< twisting spring, rad; the same from either side
  F slipping;           ///< 1 or 0
  F dash_n;             ///< normal damping force, N
  F dash_t[3];          ///< N
  F dash_r[3], dash_w;  ///< N m
};

/// Place of `slipping` among the diagnostics.
inline constexpr int kSlipping = 0;

/// Calls state(field, k), k = 0, 1, ..., for the states in the order in which they lie in a block, and
/// diagnostic(field, k) likewise. `has` (MemoryShape, or a kernel's own) states what of it contacts of a law have:
/// rolls, twists (only with rolls), own.
template <class Has, class Memory, class State, class Diagnostic>
[[gnu::always_inline]] constexpr void each_field(const Has& has, Memory& m, const State& state,
                                                 const Diagnostic& diagnostic) {
  int k = 0;
  for (int d = 0; d < 3; ++d) state(m.xi[d], k + d);
  k += 3;
  if (has.rolls) {
    for (int d = 0; d < 3; ++d) state(m.rho[d], k + d);
    k += 3;
  }
  for (int i = 0; i < has.own; ++i) state(m.own[i], k + i);
  if (has.twists) state(m.twist, k + has.own);
  diagnostic(m.slipping, kSlipping);
  diagnostic(m.dash_n, 1);
  for (int d = 0; d < 3; ++d) diagnostic(m.dash_t[d], 2 + d);
  if (has.rolls)
    for (int d = 0; d < 3; ++d) diagnostic(m.dash_r[d], 5 + d);
  if (has.twists) diagnostic(m.dash_w, 8);
}

/// A line of the cache.
struct alignas(64) Line {
  unsigned char bytes[64];
};

/// Which fields each contact of a law keeps, and how they lie in a block.
struct MemoryShape {
  bool rolls = false;
  bool twists = false;  ///< only of those that roll
  bool bonds = false;   ///< likewise
  int own = 0;          ///< the law's numbers, at most kOwnMemory
  bool single = false;  ///< states are float: pairs in mixed precision

  /// Between spheres; at surfaces, which have no bonds, in double.
  static MemoryShape of(const Law& law, bool single);
  static MemoryShape at_surface(const Law& law);
  /// Everything that a contact of any law keeps, as in restarts.
  static constexpr MemoryShape whole() { return {.rolls = true, .twists = true, .own = kOwnMemory}; }

  /// Those of the bond lie behind those of the contact.
  constexpr int first_bond_state() const { return count().states; }
  constexpr int first_bond_diagnostic() const { return count().diagnostics; }
  constexpr std::size_t states() const {
    return static_cast<std::size_t>(first_bond_state() + (bonds ? BondMemory<double>::kStates : 0));
  }
  constexpr std::size_t diagnostics() const {
    return static_cast<std::size_t>(first_bond_diagnostic() + (bonds ? BondMemory<double>::kDiagnostics : 0));
  }
  /// Bytes of the states, and of the diagnostics, of one block.
  constexpr std::size_t state_bytes() const { return states() * kBlock * (single ? sizeof(float) : sizeof(double)); }
  constexpr std::size_t diagnostic_bytes() const { return diagnostics() * kBlock * sizeof(float); }
  /// Lines of a run of blocks.
  constexpr std::size_t lines(std::size_t blocks) const {
    return (blocks * (state_bytes() + diagnostic_bytes()) + sizeof(Line) - 1) / sizeof(Line);
  }

 private:
  struct Count {
    int states = 0, diagnostics = 0;
  };
  constexpr Count count() const {
    Count n;
    ContactMemory<char> any{};
    each_field(
        *this, any, [&](char, int) { ++n.states; }, [&](char, int) { ++n.diagnostics; });
    return n;
  }
};

/// Memory of one block, each field of its eight contacts side by side. A run has first the states of all its blocks,
/// which every step reads and writes, then the diagnostics, which only recorded steps and laws with two friction
/// coefficients touch.
struct BlockMemory {
  unsigned char* states;
  unsigned char* diagnostics;
  int first_bond_state, first_bond_diagnostic;

  /// @param lines of the run, which has so many blocks
  static BlockMemory at(Line* lines, std::size_t blocks, const MemoryShape& shape, std::size_t block) {
    auto* bytes = reinterpret_cast<unsigned char*>(lines);
    return {bytes + shape.state_bytes() * block,
            bytes + shape.state_bytes() * blocks + shape.diagnostic_bytes() * block, shape.first_bond_state(),
            shape.first_bond_diagnostic()};
  }
  /// Of a block further on in the run, without counting the fields of the shape again.
  BlockMemory further(std::size_t blocks, std::size_t state_bytes, std::size_t diagnostic_bytes) const {
    return {states + state_bytes * blocks, diagnostics + diagnostic_bytes * blocks, first_bond_state,
            first_bond_diagnostic};
  }
  /// State k of 8 contacts, Real the shape's type.
  template <class Real>
  Real* state(int k) const {
    return reinterpret_cast<Real*>(states) + static_cast<int>(kBlock) * k;
  }
  float* diagnostic(int k) const { return reinterpret_cast<float*>(diagnostics) + static_cast<int>(kBlock) * k; }
};

/// Memory of one contact outside its block: at rebuilds, in restarts and for contacts with edges.
struct PairState : ContactMemory<double, float> {
  PairState() : ContactMemory{} {}
  PairState turned_over() const;  ///< with i and j exchanged
  bool empty() const;             ///< nothing stored: the contact was beyond the cutoff at the last step
};

/// Memory of one lane, taken from its block or put into it.
PairState read_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane);
void write_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, const PairState& state);
/// Likewise the bond of a lane, of shapes that bond.
BondMemory<double> read_bond(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane);
void write_bond(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, const BondMemory<double>& bond);

}  // namespace subsoil::dem
