#pragma once
#include "libdem/laws/bonded.hpp"
#include "libdem/laws/contact.hpp"
#include "libdem/laws/friction.hpp"

/// The pair kernel of bonded spheres of any law: the bond a SIMD vector at a time, the normal force of the contact lane
/// by lane in doubles, through a pointer. Compiled once for all laws that have no BOND_KERNELS (laws/list.cmake): with
/// kernels of each law seven of them took 130 s of processor time to compile, and bonded spheres are few beside soil.
namespace subsoil::dem {
struct PairJob;
inline namespace SUBSOIL_ISA {

struct AnyBondedLaw {
  static constexpr bool bonds = true;
  static constexpr LawMembers has{.memory = kOwnMemory, .needs_sum = true};
  const void* law;
  NormalForce<double> (*normal_of)(const void* law, const Approach<double>& a, double (&memory)[kOwnMemory]);
  int own_memory;  ///< numbers that the law keeps
  Friction friction;
  Bond bond;

  template <class T>
  [[gnu::noinline]] NormalForce<T> normal(const Approach<T>& a, T (&memory)[kOwnMemory]) const;
};

/// @param mixed whether in mixed precision
void run_any_bonded_law(const AnyBondedLaw& law, bool mixed, PairJob& job);

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
