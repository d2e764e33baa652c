#include "libdem/kernel/streams.hpp"

#include <cstring>

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
  bool nothing = dash_n == 0 && slipping == 0;
  for (const double number : own) nothing = nothing && number == 0;
  for (int d = 0; d < 3; ++d) nothing = nothing && xi[d] == 0 && rho[d] == 0 && dash_t[d] == 0 && dash_r[d] == 0;
  return nothing;
}

MemoryShape MemoryShape::of(const Law& law) {
  return {.rolls = dem::rolls(law), .own = std::visit([]<class L>(const L&) { return own_memory<L>(); }, law)};
}

namespace {

/// Calls visit(number of the state, its place in the block) for all that a block keeps.
template <class State, class Visit>
void each_number(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, State& s, const Visit& visit) {
  visit(s.slipping, block.note(0) + lane);
  visit(s.dash_n, block.note(1) + lane);
  for (int k = 0; k < shape.own; ++k) visit(s.own[k], block.own(k) + lane);
  for (int d = 0; d < 3; ++d) {
    visit(s.xi[d], block.xi(d) + lane);
    visit(s.dash_t[d], block.note(2 + d) + lane);
    if (!shape.rolls) continue;
    visit(s.rho[d], block.rho(d) + lane);
    visit(s.dash_r[d], block.note(5 + d) + lane);
  }
}

}  // namespace

PairState read_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane) {
  PairState s;
  each_number(block, shape, lane, s, [](auto& number, const auto* at) { std::memcpy(&number, at, sizeof *at); });
  return s;
}

void write_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, const PairState& state) {
  each_number(block, shape, lane, state, [](const auto& number, auto* at) { std::memcpy(at, &number, sizeof *at); });
}

}  // namespace subsoil::dem
