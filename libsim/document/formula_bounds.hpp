#pragma once
#include <span>
#include <string>

namespace subsoil::sim {

/// Refuses formulas that are short to write and long to work out, before GiNaC, which evaluates exactly, sees them:
/// brackets nested more than 100 deep, whole numbers that powers make longer than 100,000 bits (10^(10^10)), second
/// derivatives of more than 200,000 terms, numbers beyond double precision, functions with empty brackets. `formula`
/// holds numbers, names, + - * / ^ ( ) and commas alone. Throws UnitError, for what is no
/// formula too: GiNaC can crash over one, or go on for ever. A variable may have the name of a constant, pi or e.
void check_formula_bounds(const std::string& formula, std::span<const std::string> variables);

}  // namespace subsoil::sim
