#pragma once
#include <cstdint>
#include <string>

#include "libsim/studies/design/in_step.hpp"
#include "libsim/studies/design/plan.hpp"

namespace subsoil::sim {

/// How a search ended.
struct SearchEnd {
  std::string words;
  long evaluations = 0;
};

/// The method that a plan's `auto` means.
SearchMethod method_of(const OptimisePlan& plan);
const char* word_of(SearchMethod method);

/// One search from a start, u in [0, 1] per parameter. Objective and constraints are divided by their size at the
/// start. A design that gives no numbers counts as worse than all before.
///   bobyqa     quadratic models by interpolation, bounds only (Powell 2009)
///   cobyla     linear models, constraints (Powell 1994); for objectives with kinks, such as a maximum
///   slsqp      sequential quadratic programming (Kraft 1994), gradients by central differences, side by side
///   isres      evolution strategy over the whole box with constraints (Runarsson & Yao 2005); needs thousands of runs
///   surrogate  a Latin hypercube side by side, then kriging of objective and constraints (surrogate.hpp); its optimum
///              is run, until it leads to a design that has been run
/// All but the last by NLopt.
SearchEnd search_optimum(const OptimisePlan& plan, const Design& start, std::uint64_t seed, const Ask& ask);

}  // namespace subsoil::sim
