#include "libdem/contacts/blocks.hpp"

#include <cstring>

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
  bool nothing = dash_n == 0 && slipping == 0 && twist == 0 && dash_w == 0;
  for (const double number : own) nothing = nothing && number == 0;
  for (int d = 0; d < 3; ++d) nothing = nothing && xi[d] == 0 && rho[d] == 0 && dash_t[d] == 0 && dash_r[d] == 0;
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

/// Calls visit(number of the state, its place in the block) for all that a block keeps.
template <class Real, class State, class Visit>
void each_number(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, State& s, const Visit& visit) {
  visit(s.slipping, block.note(0) + lane);
  visit(s.dash_n, block.note(1) + lane);
  for (int k = 0; k < shape.own; ++k) visit(s.own[k], block.number<Real>(shape.first_own() + k) + lane);
  for (int d = 0; d < 3; ++d) {
    visit(s.xi[d], block.number<Real>(d) + lane);
    visit(s.dash_t[d], block.note(2 + d) + lane);
    if (!shape.rolls) continue;
    visit(s.rho[d], block.number<Real>(3 + d) + lane);
    visit(s.dash_r[d], block.note(5 + d) + lane);
  }
  if (!shape.twists) return;
  visit(s.twist, block.number<Real>(shape.twist()) + lane);
  visit(s.dash_w, block.note(8) + lane);
}

/// Likewise for the bond.
template <class Real, class Bond, class Visit>
void each_number_of_bond(const BlockMemory& block, std::uint32_t lane, Bond& b, const Visit& visit) {
  BondMemory<double>::each_number(
      b, [&](auto& number, int k) { visit(number, block.number<Real>(block.first_bond + k) + lane); });
  BondMemory<double>::each_note(b,
                                [&](auto& note, int k) { visit(note, block.note(block.first_bond_note + k) + lane); });
}

template <class State, class Visit>
void each(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, State& s, const Visit& visit) {
  if (shape.single)
    each_number<float>(block, shape, lane, s, visit);
  else
    each_number<double>(block, shape, lane, s, visit);
}
template <class Bond, class Visit>
void each_of_bond(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, Bond& b, const Visit& visit) {
  if (shape.single)
    each_number_of_bond<float>(block, lane, b, visit);
  else
    each_number_of_bond<double>(block, lane, b, visit);
}

constexpr auto take = []<class Real>(auto& number, const Real* at) {
  Real stored;
  std::memcpy(&stored, at, sizeof stored);
  number = static_cast<std::remove_reference_t<decltype(number)>>(stored);
};
constexpr auto give = []<class Real>(const auto& number, Real* at) {
  const auto stored = static_cast<Real>(number);
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
