#include "libsim/studies/design/formulas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "libsim/document/expression.hpp"
#include "libsim/studies/design/plan.hpp"

namespace subsoil::sim {

std::vector<std::string> formula_names(const OptimisePlan& plan) {
  std::vector<std::string> names;
  for (const DesignParameter& p : plan.parameters) names.push_back(p.name);
  for (const SweepNumber& n : plan.numbers) names.push_back(n.name);
  return names;
}

std::function<double(const double*)> design_formula(const std::string& text, const std::vector<std::string>& names) {
  if (text.find_first_not_of(' ') == std::string::npos)
    throw std::invalid_argument("is no formula: nothing stands there");
  return make_formula_of(text, names);
}

DesignConstraint::DesignConstraint(const std::string& text, const std::vector<std::string>& names) : text_(text) {
  const std::size_t equal = text.find('=');
  if (equal == std::string::npos || equal == 0 || text.find('=', equal + 1) != std::string::npos)
    throw std::invalid_argument(
        fmt::format("`{}` is no constraint; write a formula, <=, >= or =, and a formula", text));
  const char before = text[equal - 1];
  sense_ = before == '<' ? -1 : before == '>' ? 1 : 0;
  left_ = design_formula(text.substr(0, sense_ == 0 ? equal : equal - 1), names);
  right_ = design_formula(text.substr(equal + 1), names);
}

bool DesignConstraint::is_equation(const std::string& text) {
  return text.find("<=") == std::string::npos && text.find(">=") == std::string::npos;
}

double DesignConstraint::excess(const double* values) const {
  const double off = left_(values) - right_(values);
  return sense_ > 0 ? -off : off;
}

double DesignConstraint::size(const double* values) const {
  return std::max(std::abs(left_(values)), std::abs(right_(values)));
}

}  // namespace subsoil::sim
