#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libsim/document/units.hpp"

/// The grammar of every formula of a scenario: values with units (`2*a + 30 mm`), functions of time, formulas of
/// measures, output variables and parameters of a study.
///
///   sum      term, then + or - and a term
///   term     power, then * or / and a power, each with its signs
///   power    operand, then ^, signs and an operand, or superscripts: t^2, t², t^-2
///   operand  number, constant, name, ( sum ), function( sum, sum )
///   unit     behind a number, a constant or a closing bracket, as far as it goes; where the language has units
///
/// A sign binds less than a power: -t^2 is -(t^2). Powers in a row are refused, since programs differ in their order.
/// A formula has at most 10,000 characters and 100 levels of brackets, so that reading is bounded in time and depth.
namespace subsoil::sim {

enum class Call : std::uint8_t {
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  sinh,
  cosh,
  tanh,
  exp,
  log,
  sqrt,
  abs,
  sign,
  atan2,
  hypot,
  min,
  max,
  pow
};
struct FormulaFunction {
  std::string_view name;
  Call call;
  int arguments;
};
inline constexpr std::array<FormulaFunction, 19> formula_functions{{{"sin", Call::sin, 1},
                                                                    {"cos", Call::cos, 1},
                                                                    {"tan", Call::tan, 1},
                                                                    {"asin", Call::asin, 1},
                                                                    {"acos", Call::acos, 1},
                                                                    {"atan", Call::atan, 1},
                                                                    {"sinh", Call::sinh, 1},
                                                                    {"cosh", Call::cosh, 1},
                                                                    {"tanh", Call::tanh, 1},
                                                                    {"exp", Call::exp, 1},
                                                                    {"log", Call::log, 1},
                                                                    {"sqrt", Call::sqrt, 1},
                                                                    {"pow", Call::pow, 2},
                                                                    {"atan2", Call::atan2, 2},
                                                                    {"abs", Call::abs, 1},
                                                                    {"sign", Call::sign, 1},
                                                                    {"hypot", Call::hypot, 2},
                                                                    {"min", Call::min, 2},
                                                                    {"max", Call::max, 2}}};
bool is_formula_function(std::string_view word);
bool is_formula_constant(std::string_view word);

/// A formula in postfix order: operands come before what takes them from a stack.
struct Operation {
  enum class Kind : std::uint8_t { number, name, unit, negate, add, subtract, multiply, divide, power, call };
  Kind kind = Kind::number;
  Call call{};
  std::size_t name = 0;     ///< index among the names of the language
  double number = 0;        ///< a number, or the value of a constant
  std::string_view unit{};  ///< behind the value below it; part of the text that was read
};

/// What a formula may name. A name of these hides a constant.
struct FormulaLanguage {
  std::span<const std::string> names{};
  bool units = false;  ///< values of a scenario; the names are its parameters
};

/// A name that the language does not have.
struct UnknownName : UnitError {
  UnknownName(std::string_view which, const std::string& text) : UnitError(text), name(which) {}
  std::string name;
};

/// Throws UnitError with rule and cure for what is no formula, UnknownName for a name that is not there.
std::vector<Operation> read_formula(std::string_view text, const FormulaLanguage& language);

/// Takes superscript digits and their sign off the front; NaN where they are no number.
double take_superscripts(std::string_view& text);

/// Value of a function; the second argument is ignored where it has one. NaN stays NaN.
double value_of(Call call, double x, double y = 0);

}  // namespace subsoil::sim
