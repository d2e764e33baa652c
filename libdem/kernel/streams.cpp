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

MemoryShape MemoryShape::of(const Law& law, bool single) {
  return {.rolls = dem::rolls(law),
          .own = std::visit([]<class L>(const L&) { return own_memory<L>(); }, law),
          .single = single};
}

namespace {

/// Calls visit(number of the state, its place in the block) for all that a block keeps.
template <class Real, class State, class Visit>
void each_number(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, State& s, const Visit& visit) {
  visit(s.slipping, block.note(0) + lane);
  visit(s.dash_n, block.note(1) + lane);
  for (int k = 0; k < shape.own; ++k) visit(s.own[k], block.number<Real>(block.first_own + k) + lane);
  for (int d = 0; d < 3; ++d) {
    visit(s.xi[d], block.number<Real>(d) + lane);
    visit(s.dash_t[d], block.note(2 + d) + lane);
    if (!shape.rolls) continue;
    visit(s.rho[d], block.number<Real>(3 + d) + lane);
    visit(s.dash_r[d], block.note(5 + d) + lane);
  }
}

template <class State, class Visit>
void each(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, State& s, const Visit& visit) {
  if (shape.single)
    each_number<float>(block, shape, lane, s, visit);
  else
    each_number<double>(block, shape, lane, s, visit);
}

}  // namespace

PairState read_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane) {
  PairState s;
  each(block, shape, lane, s, []<class Real>(auto& number, const Real* at) {
    Real stored;
    std::memcpy(&stored, at, sizeof stored);
    number = stored;
  });
  return s;
}

void write_lane(const BlockMemory& block, const MemoryShape& shape, std::uint32_t lane, const PairState& state) {
  each(block, shape, lane, state, []<class Real>(const auto& number, Real* at) {
    const auto stored = static_cast<Real>(number);
    std::memcpy(at, &stored, sizeof stored);
  });
}

}  // namespace subsoil::dem
