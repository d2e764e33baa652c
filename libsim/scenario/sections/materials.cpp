#include "libsim/scenario/sections/materials.hpp"

#include <algorithm>
#include <cmath>

#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"

namespace subsoil::sim {

double combined(CombinationRule rule, double a, double b) {
  switch (rule) {
    case CombinationRule::arithmetic_mean:
      return 0.5 * (a + b);
    case CombinationRule::geometric_mean:
      return std::sqrt(a * b);
    case CombinationRule::harmonic_mean:
      return a + b > 0 ? 2 * a * b / (a + b) : 0;
    case CombinationRule::minimum:
      return std::min(a, b);
    case CombinationRule::maximum:
      return std::max(a, b);
  }
  return a;
}

namespace {

/// Says where values came from; they stand beside it when the reader sees them (library.hpp).
class LibraryName final : public Compound {
 public:
  void read(Reader& reader, const Field& field) override { reader.know(field.key); }
  void print(Printer&, const Field&) const override {}
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "name", "left out", "", field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    schema.add(field, text_form());
    schema.excuse("", {{"required", Json::array({field.key})}});
    schema.may_be_text("^library +[^ ]");
  }
};

}  // namespace

void describe(Fields& v, Material& m) {
  LibraryName library;
  v.visit_compound({"library",
                    "material of the program's library (`subsoil materials`) that gives what is left out here, and the "
                    "contact laws with itself and with the library's steel; `NAME: library sandy-loam-10mm` says no "
                    "more than this"},
                   library);
  v.quantity("density", m.density, "kg/m^3", "(0, inf)", "density of the material itself, not of the bulk");
  v.quantity("young's modulus", m.young, "Pa", "(0, inf)", "needed by laws that compute their stiffness from it");
  v.quantity("poisson ratio", m.poisson, "1", "(-1, 0.5]", "needed by laws that compute their stiffness from it");
  v.quantity("yield strength", m.yield, "Pa", "(0, inf)",
             "needed by laws that leave theirs out; of two bodies the one of less strength yields");
  for (const Combinable& c : combinables) v.quantity(c.key, m.*c.value, c.unit, c.range, c.meaning);
}

}  // namespace subsoil::sim
