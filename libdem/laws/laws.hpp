#pragma once
#include <type_traits>
#include <variant>

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

/// What the sweep evaluates: laws that have cohesion are laws of their own, so that the others do not pay for it.
using Law = std::variant<Wet, Linear, HertzMindlin, HuntCrossley, Jkr, Hysteretic, Luding, Eepa, VariableRestitution,
                         CohesiveLinear, CohesiveHertzMindlin, CohesiveHuntCrossley, CohesiveHysteretic>;

/// The law as the sweep evaluates it, what follows from its parameters filled in. Throws std::invalid_argument when
/// they contradict each other.
template <class Given>
Law resolved(const Given& law) {
  if constexpr (requires { law.resolved(); }) {
    auto ready = law.resolved();  // of a cohesive law: the normal law in it
    if constexpr (requires { ready.cohesion; }) {
      if (ready.cohesion.acts()) return Cohesive<decltype(ready)>{ready};
    }
    return ready;
  } else {
    return std::visit([](const auto& l) { return resolved(l); }, law);
  }
}

}  // namespace subsoil::dem
