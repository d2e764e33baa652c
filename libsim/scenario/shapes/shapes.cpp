#include "libsim/scenario/shapes/shapes.hpp"

#include "libsim/scenario/checks.hpp"

namespace subsoil::sim {

void check_shape(Checks& checks, const std::string& path, const Shape& shape) {
  const ShapeFault fault = std::visit([](const auto& given) { return given.fault(); }, shape);
  if (!fault.rule.empty()) checks.refuse(path + "." + fault.key, fault.rule);
}

}  // namespace subsoil::sim
