#include "apps/commands/quantity_option.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "libsim/document/quantity.hpp"

namespace subsoil::sim {

double quantity_option(const char* option, const std::string& text, const char* unit, bool positive) {
  try {
    const double value = parse_quantity(text, unit);
    if (positive && !(value > 0)) throw std::invalid_argument("must be above 0");
    return value;
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{} {}: {}", option, text, error.what()));
  }
}

}  // namespace subsoil::sim
