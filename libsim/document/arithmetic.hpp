#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libsim/document/units.hpp"

/// Formulas (document/grammar.hpp) in the values of a scenario: `2*a + 30 mm`, `sqrt(3)*l`, `-b/2`, with dimensions.
///
/// A unit binds to the number, constant or bracket before it: `2*30 mm` is 60 mm, `1/2 m` is 0.5 1/m and `(1/2) m` half
/// a metre. A name behind a number is a unit, any other a parameter.
/// Dimensions: any of sqrt, abs, sign, min, max, hypot and of the base of pow; angles or plain numbers of sin, cos and
/// tan; plain numbers of the others.
///
/// The value of asin, acos, atan, atan2 is an angle.
namespace subsoil::sim {

/// A number in SI units and its powers of the base units.
struct Amount {
  double value = 0;
  std::map<std::string, double> powers{};
};

/// The parameters of the document that is read: from its making to its end they stand for their amounts in every value
/// that this thread reads. One at a time.
class ParametersInScope {
 public:
  ParametersInScope();
  ~ParametersInScope();
  ParametersInScope(const ParametersInScope&) = delete;
  ParametersInScope& operator=(const ParametersInScope&) = delete;
};

/// Adds a parameter to the scope; of no effect without one. Throws UnitError for a name that would hide a unit or
/// function.
void add_parameter(const std::string& name, const Amount& amount);

/// Whether scenarios are written in this unit, so that no parameter has its name.
bool is_common_unit(std::string_view name);

bool has_parameters();
/// Whether a parameter in scope stands in `text`.
bool names_parameter(std::string_view text);
/// Whether `text` can be nothing but arithmetic: a parameter, a +, a product or quotient of numbers or brackets.
bool is_arithmetic(std::string_view text);

/// Whether a value that was read since names it.
bool parameter_is_used(const std::string& name);

/// A formula whose parameters, but for names of `variables`, are their numbers in base units, so that it means the same
/// where they are not known. Throws UnitError for one with a unit unless the formula's value is in base units (`si`).
std::string with_numbers(const std::string& formula, const std::vector<std::string>& variables, bool si);

/// Throws UnitError: unknown names, dimensions that do not fit, text that is no arithmetic.
Amount evaluate_arithmetic(std::string_view text, std::optional<double> n = {});

/// A text of all digits that means this amount: "0.0295 m^1 s^-1".
std::string in_base_units(const Amount& amount);

}  // namespace subsoil::sim
