#pragma once
#include <type_traits>
#include <variant>

#include "libdem/laws/bonded.hpp"
#include "libdem/laws/cohesive.hpp"
#include "libdem/laws/eepa.hpp"
#include "libdem/laws/hertz_mindlin.hpp"
#include "libdem/laws/hunt_crossley.hpp"
#include "libdem/laws/hysteretic.hpp"
#include "libdem/laws/jkr.hpp"
#include "libdem/laws/linear.hpp"
#include "libdem/laws/luding.hpp"
#include "libdem/laws/variable_restitution.hpp"
#include "libdem/laws/wet.hpp"

/// The lists of contact laws: a new law is its own file and one word in each. Reader, checker, explain, documentation
/// and the sweep all work from them.
namespace subsoil::dem {

/// What a user gives.
using GivenLaw =
    std::variant<Wet, Linear, HertzMindlin, HuntCrossley, Jkr, Hysteretic, Luding, Eepa, VariableRestitution>;

using CohesiveLinear = Cohesive<Linear>;
using CohesiveHertzMindlin = Cohesive<HertzMindlin>;
using CohesiveHuntCrossley = Cohesive<HuntCrossley>;
using CohesiveHysteretic = Cohesive<Hysteretic>;
using BondedLinear = Bonded<Linear>;
using BondedHertzMindlin = Bonded<HertzMindlin>;

/// What the sweep evaluates: laws that have cohesion or bonds are laws of their own, so that the others do not pay for
/// it.
using Law = std::variant<Wet, Linear, HertzMindlin, HuntCrossley, Jkr, Hysteretic, Luding, Eepa, VariableRestitution,
                         CohesiveLinear, CohesiveHertzMindlin, CohesiveHuntCrossley, CohesiveHysteretic, BondedLinear,
                         BondedHertzMindlin>;

/// Throws std::invalid_argument for what a bond cannot have beside it.
template <class Normal>
void refuse_beside_bond(const Normal& law) {
  if (law.cohesion.acts())
    throw std::invalid_argument("a bond and cohesion in one law: not offered; leave one of them out");
  // Of a stretched pair levers of the radius would not reach the bond: torques would not balance.
  if (law.friction.lever != Lever::mid_overlap)
    throw std::invalid_argument("lever: a bond needs mid-overlap, else angular momentum is not kept");
}

/// The law as the sweep evaluates it, what follows from its parameters filled in. Throws std::invalid_argument when
/// they contradict each other.
template <class Given>
Law resolved(const Given& law) {
  if constexpr (requires { law.resolved(); }) {
    auto ready = law.resolved();  // of a cohesive or bonded law: the normal law in it
    if constexpr (requires { ready.bond; }) {
      if (ready.bond.acts()) {
        refuse_beside_bond(ready);
        return Bonded<decltype(ready)>{ready};
      }
    }
    if constexpr (requires { ready.cohesion; }) {
      if (ready.cohesion.acts()) return Cohesive<decltype(ready)>{ready};
    }
    return ready;
  } else {
    return std::visit([](const auto& l) { return resolved(l); }, law);
  }
}

}  // namespace subsoil::dem
