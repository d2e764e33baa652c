#pragma once
#include <optional>
#include <string>

#include "libsim/keys/fields.hpp"

namespace subsoil::sim {

/// One of two quantities above zero, by its unit.
class EitherQuantity final : public Value {
 public:
  /// @param either what it may be, with examples: "a density (1450 kg/m^3) or a pressure (20 kPa)"
  EitherQuantity(const char* unit, std::optional<double>& value, const char* other_unit, std::optional<double>& other,
                 const char* either)
      : unit_(unit), other_unit_(other_unit), value_(value), other_(other), either_(either) {}
  void read(const Node& node, const ReadScope& scope) override;
  Node print(const PrintScope&) const override;
  std::string what() const override;
  std::string range() const override { return "(0, inf)"; }
  Json schema() const override;

 private:
  const char *unit_, *other_unit_;
  std::optional<double>&value_, &other_;
  const char* either_;
};

}  // namespace subsoil::sim
