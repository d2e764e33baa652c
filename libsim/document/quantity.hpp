#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "libsim/document/units.hpp"

/// Values of a scenario in SI units: numbers before one unit, or arithmetic with parameters.
namespace subsoil::sim {

/// One number and its unit -> SI. `expected` names the wanted dimension; "1" is dimensionless (a number alone, or with
/// a unit worth a number, such as percent). Throws UnitError with rule and cure.
double parse_quantity(std::string_view text, std::string_view expected, std::optional<double> n = {});

/// The same number in `unit` itself: 5 kPa of 5000 Pa.
double parse_quantity_in(std::string_view text, std::string_view unit);

/// As many numbers as asked for before one unit; `count` 0 takes any number of them.
std::vector<double> parse_quantities(std::string_view text, std::string_view expected, std::size_t count,
                                     std::optional<double> n = {});

/// A number without unit, refused unless finite and decimal. For counts as well as dimensionless values.
double parse_number(std::string_view text);

}  // namespace subsoil::sim
