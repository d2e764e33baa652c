#pragma once
#include <any>
#include <optional>
#include <utility>

#include "libdem/laws/law.hpp"

namespace subsoil::sim {

struct Material;
class Fields;

/// A contact law with its parameters as the file gives them, one of those that libdem lists (libdem/laws/list.cmake).
/// Which these are only given_law.cpp knows: a change in a law compiles that file and none that holds a scenario.
class GivenLaw {
 public:
  GivenLaw();  ///< the first of the list, with nothing given
  template <class L>
  requires requires(const L& law) { law.resolved(); }
  GivenLaw(L law) : law_(std::move(law)) {}

  /// Null when it is another law.
  template <class L>
  const L* get_if() const {
    return std::any_cast<L>(&law_);
  }
  template <class L>
  L* get_if() {
    return std::any_cast<L>(&law_);
  }

 private:
  std::any law_;
};

/// The word of the law under `key`, its parameters beside it.
void declare_law(Fields& fields, GivenLaw& law, const char* key, const char* meaning);

/// What a law takes from both materials when its entry leaves it out.
struct MaterialNeeds {
  const char* law;  ///< its word
  const char* in_place_of_elastic =
      nullptr;                              ///< what the entry may give instead of elastic constants; null: none needed
  const char* in_place_of_yield = nullptr;  ///< likewise of yield strengths
};
MaterialNeeds material_needs(const GivenLaw& law);

/// Whether spheres of this law come as fibres: `bond: fibre`.
bool makes_fibres(const GivenLaw& law);
/// Whether edges cut what it holds together.
bool is_cut_by_edges(const GivenLaw& law);

/// Of one bridge, m^3; nothing where the law has none.
std::optional<double> liquid_volume(const GivenLaw& law);

/// The law between two materials. Throws std::invalid_argument when its parameters contradict each other or a material
/// lacks what it needs.
dem::Law law_between(const GivenLaw& law, const Material& a, const Material& b);

}  // namespace subsoil::sim
