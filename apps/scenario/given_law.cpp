#include "apps/scenario/given_law.hpp"

#include <stdexcept>
#include <string>
#include <variant>

#include "apps/scenario/printer.hpp"
#include "apps/scenario/reader.hpp"
#include "libdem/law_list.hpp"

/// The only file of the program that includes the contact laws.
namespace subsoil::app {
namespace {

template <std::size_t type = 0>
dem::GivenLaw variant_of(const GivenLaw& law) {
  using L = std::variant_alternative_t<type, dem::GivenLaw>;
  if (const L* held = law.get_if<L>()) return *held;
  if constexpr (type + 1 < std::variant_size_v<dem::GivenLaw>)
    return variant_of<type + 1>(law);
  else
    throw std::logic_error("a contact law that libdem/laws/list.cmake does not list");
}

/// Gives the law to a visitor as the variant that it is.
template <class Use>
void use_variant(GivenLaw& law, const Use& use) {
  dem::GivenLaw variant = variant_of(law);
  use(variant);
  law = std::visit([](auto& held) { return GivenLaw(std::move(held)); }, variant);
}

template <class L>
void take_from_materials(L& law, const Material& a, const Material& b) {
  if constexpr (requires { law.take_materials(1., 1., 1., 1.); }) {
    if (law.needs_materials()) {
      for (const Material* m : {&a, &b})
        if (!m->young || !m->poisson)
          throw std::invalid_argument("needs young and poisson of material '" + m->name + "', or " +
                                      law.in_place_of_materials + " in this entry");
      law.take_materials(*a.young, *a.poisson, *b.young, *b.poisson);
    }
  }
  if constexpr (requires { law.take_yield(1., 1.); }) {
    if (law.needs_yield()) {
      for (const Material* m : {&a, &b})
        if (!m->yield)
          throw std::invalid_argument("needs yield strength of material '" + m->name + "', or " +
                                      law.in_place_of_yield + " in this entry");
      law.take_yield(*a.yield, *b.yield);
    }
  }
}

}  // namespace

GivenLaw::GivenLaw() : law_(std::variant_alternative_t<0, dem::GivenLaw>{}) {}

void Reader::kind(const char* key, GivenLaw& value, const char* meaning) {
  use_variant(value, [&](dem::GivenLaw& law) { kind(key, law, meaning); });
}
void Printer::kind(const char* key, GivenLaw& value, const char* meaning) {
  use_variant(value, [&](dem::GivenLaw& law) { kind(key, law, meaning); });
}

MaterialNeeds material_needs(const GivenLaw& given) {
  return std::visit(
      []<class L>(const L& law) {
        MaterialNeeds needs{.law = card_of<L>().word.c_str()};
        if constexpr (requires { law.needs_materials(); })
          if (law.needs_materials()) needs.in_place_of_elastic = L::in_place_of_materials;
        if constexpr (requires { law.needs_yield(); })
          if (law.needs_yield()) needs.in_place_of_yield = L::in_place_of_yield;
        return needs;
      },
      variant_of(given));
}

dem::Law law_between(const GivenLaw& given, const Material& a, const Material& b) {
  return std::visit(
      [&](auto law) {
        take_from_materials(law, a, b);
        return dem::Law(law);
      },
      variant_of(given));
}

}  // namespace subsoil::app
