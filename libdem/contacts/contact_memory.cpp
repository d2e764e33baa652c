#include "libdem/contacts/contact_memory.hpp"

#include <cstring>
#include <type_traits>

#include "libdem/laws/friction.hpp"

namespace subsoil::dem {

PairState PairState::turned_over() const {
  PairState s = *this;
  for (int d = 0; d < 3; ++d) {
    s.xi[d] = -s.xi[d];
    s.rho[d] = -s.rho[d];
    s.dash_t[d] = -s.dash_t[d];
    s.dash_r[d] = -s.dash_r[d];
  }
  return s;
}

bool PairState::empty() const {
  if (xi[0] != 0 || dash_n != 0) return false;  // nearly all that have something
  bool nothing = true;
  const auto look = [&](auto number, int) { nothing = nothing && number == 0; };
  each_field(MemoryShape::whole(), *this, look, look);
  return nothing;
}

MemoryShape MemoryShape::of(const Law& law, bool single) {
  MemoryShape shape = at_surface(law);
  shape.bonds = law->bond() != nullptr;
  shape.rolls = shape.rolls || shape.bonds;  // moments of bonds need what rolling resistance does
  shape.single = single;
  return shape;
}

MemoryShape MemoryShape::at_surface(const Law& law) {
  return {.rolls = law->friction().resists_rolling(),
          .twists = law->friction().resists_twist(),
          .bonds = false,
          .own = law->own_memory(),
          .single = false};
}

namespace {

/// Calls visit(field, its place in the block) for all that a block keeps of a contact.
template <class Real, class State, class Visit>
void each_place(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, State& s, const Visit& visit) {
  each_field(
      shape, s, [&](auto& field, int k) { visit(field, block.state<Real>(k) + lane); },
      [&](auto& field, int k) { visit(field, block.diagnostic(k) + lane); });
}

/// Likewise of its bond.
template <class Real, class Bond, class Visit>
void each_bond_place(const BlockMemory& block, std::uint32_t lane, Bond& b, const Visit& visit) {
  BondMemory<double>::each_state(
      b, [&](auto& field, int k) { visit(field, block.state<Real>(block.first_bond_state + k) + lane); });
  BondMemory<double>::each_diagnostic(
      b, [&](auto& field, int k) { visit(field, block.diagnostic(block.first_bond_diagnostic + k) + lane); });
}

template <class State, class Visit>
void each(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, State& s, const Visit& visit) {
  if (shape.single)
    each_place<float>(block, shape, lane, s, visit);
  else
    each_place<double>(block, shape, lane, s, visit);
}
template <class Bond, class Visit>
void each_of_bond(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, Bond& b, const Visit& visit) {
  if (shape.single)
    each_bond_place<float>(block, lane, b, visit);
  else
    each_bond_place<double>(block, lane, b, visit);
}

constexpr auto take = []<class Real>(auto& field, const Real* at) {
  Real stored;
  std::memcpy(&stored, at, sizeof stored);
  field = static_cast<std::remove_reference_t<decltype(field)>>(stored);
};
constexpr auto give = []<class Real>(const auto& field, Real* at) {
  const auto stored = static_cast<Real>(field);
  std::memcpy(at, &stored, sizeof stored);
};

}  // namespace

PairState read_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane) {
  PairState s;
  each(block, shape, lane, s, take);
  return s;
}

void write_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, const PairState& state) {
  each(block, shape, lane, state, give);
}

BondMemory<double> read_bond(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane) {
  BondMemory<double> b;
  each_of_bond(block, shape, lane, b, take);
  return b;
}

void write_bond(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane,
                const BondMemory<double>& bond) {
  each_of_bond(block, shape, lane, bond, give);
}

}  // namespace subsoil::dem
