#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libsim/document/refusal.hpp"

/// Numbers with units as a scenario writes them: numbers first, then one unit expression (`1 2 3 mm`, `16 kN/m`).
///
/// UDUNITS-2 knows what a name is worth (`kN`, `ft`, `percent`); the sentence around the names is ours, because UDUNITS
/// alone reads `1 2 3 mm` as 6 mm and `N/m^1.5` as something else without a word. Names multiply by blank, `*`, `.` or
/// `·`, divide by `/` from left to right, and take whole, decimal, fractional or symbolic powers: `m2`, `s-1`,
/// `m^1.5`, `m^(3/2)`, `m^(n+1)` with the law's own n. Logarithmic units and units with an offset (degC) are refused.
namespace subsoil::sim {

struct UnitError : Refusal {
  using Refusal::Refusal;
};

/// A unit as size and powers of the base units. The size is kept as a quotient so that 18 mm is exactly 0.018 m.
struct Unit {
  double times = 1, over = 1;
  std::map<std::string, double> powers;  // base symbol (m, kg, s, rad, ...) -> power, none zero

  double to_si(double value) const { return value * times / over; }
  double from_si(double value) const { return value * over / times; }
};

/// `n` stands for the symbol n in powers; a symbolic power without it is refused.
Unit parse_unit(std::string_view text, std::optional<double> n = {});

/// "kg m^2 s^-2", or "1".
std::string dimension_text(const Unit& unit);

/// "a length (m), such as mm": the dimension of a unit, with `expected` as its example.
std::string example(const Unit& wanted, std::string_view expected);

/// Throws UnitError naming both dimensions where they differ. An angle is a dimension here, except that N m may stand
/// for N m/rad.
void check_dimension(const Unit& given, std::string_view given_text, const Unit& wanted, std::string_view expected);

/// Text that reads back to exactly the same SI value(s), in `unit` where that is possible.
std::string format_quantity(double si, const std::string& unit, std::optional<double> n = {});
std::string format_quantities(const double* si, std::size_t count, const std::string& unit);

}  // namespace subsoil::sim
