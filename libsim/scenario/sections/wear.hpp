#pragma once
#include <optional>
#include <string>

#include "libsim/keys/fields.hpp"

/// Load and wear on the triangles of a surface.
namespace subsoil::sim {

struct WearSection {
  std::optional<double> coefficient, hardness;  // Archard: K, H in Pa
  std::optional<double> finnie;                 // k in 1/Pa
  bool has_archard() const { return coefficient && hardness; }
  bool has_finnie() const { return finnie.has_value(); }
};
void describe(Fields& v, WearSection& w);

struct Checks;
void check_wear(Checks& checks, const std::string& path, const std::optional<WearSection>& wear);

}  // namespace subsoil::sim
