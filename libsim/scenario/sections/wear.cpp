#include "libsim/scenario/sections/wear.hpp"

#include "libsim/scenario/checks.hpp"

namespace subsoil::sim {

void describe(Fields& v, WearSection& w) {
  v.quantity("coefficient", w.coefficient, "1", "[0, 1]",
             "K of Archard's law: worn volume = K/H times normal force times sliding distance; with `hardness`");
  v.quantity("hardness", w.hardness, "Pa", "(0, inf)", "H of Archard's law, of the softer body");
  v.quantity(
      "finnie", w.finnie, "1/Pa", "[0, inf)",
      "k of Finnie's law of erosion: worn volume = k times the work of the contact force, weighted by its angle");
}

void check_wear(Checks& checks, const std::string& path, const std::optional<WearSection>& wear) {
  if (!wear || wear->coefficient.has_value() == wear->hardness.has_value()) return;
  checks.refuse(path + (wear->coefficient ? ".coefficient" : ".hardness"),
                "needs the other of `coefficient` and `hardness`: Archard's law has K/H; give both or neither");
}

}  // namespace subsoil::sim
