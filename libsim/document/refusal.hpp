#pragma once
#include <stdexcept>
#include <string>

namespace subsoil::sim {

/// What is wrong with a value, and what to do about it; place and key are known to whoever reads it.
struct Refusal : std::invalid_argument {
  explicit Refusal(const std::string& rule) : std::invalid_argument(rule) {}
  Refusal(const std::string& rule, const std::string& remedy)
      : std::invalid_argument(remedy.empty() ? rule : rule + "; " + remedy), cure(remedy) {}
  std::string cure;  ///< empty: the rule implies it
};

}  // namespace subsoil::sim
