#include "libsim/post/unit_factor.hpp"

#include <stdexcept>

#include "libsim/document/quantity.hpp"

namespace subsoil::sim {

std::optional<double> unit_factor(const std::string& from, const std::string& to) {
  if (from == to) return 1;
  try {
    return parse_quantity_in(from == "1" ? "1" : "1 " + from, to);
  } catch (const std::invalid_argument&) {
    return {};
  }
}

}  // namespace subsoil::sim
