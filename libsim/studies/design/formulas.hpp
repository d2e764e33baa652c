#pragma once
#include <functional>
#include <string>
#include <vector>

/// Formulas of a plan in its parameters and numbers.
namespace subsoil::sim {

struct OptimisePlan;

/// Names in the order in which values are handed over: parameters (in their units), then numbers (SI).
std::vector<std::string> formula_names(const OptimisePlan& plan);

/// Throws std::invalid_argument with what is no formula, or with a name that is not there.
std::function<double(const double*)> design_formula(const std::string& text, const std::vector<std::string>& names);

/// `mass <= 3`, `a + b = 0.5`.
class DesignConstraint {
 public:
  DesignConstraint(const std::string& text, const std::vector<std::string>& names);

  const std::string& text() const { return text_; }
  bool is_equation() const { return sense_ == 0; }
  static bool is_equation(const std::string& text);
  /// Left minus right; of >= right minus left: must be at most zero, or zero.
  double excess(const double* values) const;
  /// The larger of both sides, without sign: what a tolerance is a share of.
  double size(const double* values) const;

 private:
  std::string text_;
  int sense_ = -1;  // -1: <=, 0: =, 1: >=
  std::function<double(const double*)> left_, right_;
};

}  // namespace subsoil::sim
