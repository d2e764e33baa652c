#pragma once
#include <string>
#include <vector>

namespace subsoil::sim {

/// The words of a formula (numbers, names, operators, brackets, commas) as text in which every sign behind an operator
/// stands in brackets with its operand: a*-b + c becomes a * (- b) + c, a - -b^2 becomes a - (- b ^ 2). GiNaC's parser
/// takes what follows such a sign for its operand, as far as it goes: a*(-b + c).
std::string with_signs_in_brackets(const std::vector<std::string>& words);

}  // namespace subsoil::sim
