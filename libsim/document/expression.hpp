#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "libmbd/base/function.hpp"

namespace subsoil::sim {

/// A formula (document/grammar.hpp) in t (s) as a function of time, its value times `size` (SI units per unit of the
/// formula). Derivatives are exact (document/jet.hpp).
/// Integrals are Gauss-Kronrod sums to 1e-14 of the integral of |f|.
/// Throws UnitError with rule and cure for what is no formula; a formula without a finite value where it is asked ends
/// the run.
mbd::ExpressionFunction make_expression(const std::string& text, const std::string& unit, double size);

/// A formula in three numbers of these names, in SI units.
std::function<double(double, double, double)> make_formula(const std::string& text,
                                                           const std::array<const char*, 3>& names);

/// A formula in numbers of these names, in SI units; takes as many values in their order. Not finite where it has no
/// value.
std::function<double(const double*)> make_formula_of(const std::string& text, const std::vector<std::string>& names);

}  // namespace subsoil::sim
