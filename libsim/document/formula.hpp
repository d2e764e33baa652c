#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libsim/document/grammar.hpp"
#include "libsim/document/jet.hpp"

namespace subsoil::sim {

/// A formula of plain numbers, compiled for evaluation in every step: as written, operation by operation in the order
/// of its text. Only operations on numbers alone are done in advance; nothing cancels and nothing is rearranged.
class Formula {
 public:
  /// Throws UnitError with rule and cure for what is no formula, and for constants without a finite value.
  Formula(std::string_view text, std::span<const std::string> variables);

  /// `at`: values of the variables, in their order. Not finite where the formula has no value.
  double operator()(const double* at) const;
  /// With derivatives along the path of the variables.
  Jet<1> operator()(const Jet<1>* at) const;
  Jet<2> operator()(const Jet<2>* at) const;

 private:
  enum class Do : std::uint8_t {
    number,
    variable,
    negate,
    add,
    subtract,
    multiply,
    divide,
    power,
    // with a number on one side
    add_number,
    number_minus,
    multiply_number,
    divide_number,
    number_over,
    power_number,
    square,
    call_one,
    call_two
  };
  struct Step {
    Do what = Do::number;
    Call call{};
    std::uint32_t variable = 0;
    double number = 0;
  };
  class Compiler;
  template <class Number>
  Number run(const Number* at) const;

  std::vector<Step> steps_;
};

}  // namespace subsoil::sim
