#include "libsim/scenario/given_law.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>

#include "libdem/law_list.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/scenario/friction_faults.hpp"
#include "libsim/scenario/sections/materials.hpp"

/// The only file of the program that includes the contact laws.
namespace subsoil::sim {

template <>
struct TypesOf<GivenLaw> {
  using type = dem::GivenLaw;
};

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

template <class L>
void take_from_materials(L& law, const Material& a, const Material& b) {
  if constexpr (TakesMaterials<L>) {
    if (law.needs_materials()) {
      for (const Material* m : {&a, &b})
        if (!m->young || !m->poisson)
          throw std::invalid_argument("needs young and poisson of material '" + m->name + "', or " +
                                      law.in_place_of_materials + " in this entry");
      law.take_materials(*a.young, *a.poisson, *b.young, *b.poisson);
    }
  }
  if constexpr (TakesYield<L>) {
    if (law.needs_yield()) {
      for (const Material* m : {&a, &b})
        if (!m->yield)
          throw std::invalid_argument("needs yield strength of material '" + m->name + "', or " +
                                      law.in_place_of_yield + " in this entry");
      law.take_yield(*a.yield, *b.yield);
    }
  }
  if constexpr (TakesDensity<L>) law.take_density(a.density, b.density);
}

}  // namespace

namespace {

std::vector<FrictionFault> faults_of(const dem::Friction& f) {
  std::vector<FrictionFault> faults;
  if (f.mu_d > f.mu)
    faults.push_back(
        {"mu_d", f.mu_d,
         fmt::format("must be at most mu = {:g}: friction while slipping does not exceed that at rest", f.mu)});
  if (f.rolling == dem::Rolling::none && f.mu_r != 0)
    faults.push_back({"mu_r", f.mu_r, "has no effect with `rolling: none`; leave one of them out", true});
  const bool spring = f.rolling == dem::Rolling::elastic_plastic;
  if (spring && f.mu_r != 0) return faults;
  const std::string why = std::string("has no effect ") +
                          (spring ? "without `mu_r`, the limit of rolling" : "without `rolling: elastic-plastic`") +
                          "; leave it out";
  if (!std::isnan(f.k_r)) faults.push_back({"k_r", f.k_r, why, true});
  if (!std::isnan(f.c_r)) faults.push_back({"c_r", f.c_r, why, true});
  return faults;
}

}  // namespace

std::vector<FrictionFault> friction_faults(const GivenLaw& given) {
  return std::visit([](const auto& law) { return faults_of(law.friction); }, variant_of(given));
}

GivenLaw::GivenLaw() : law_(std::variant_alternative_t<0, dem::GivenLaw>{}) {}

void declare_law(Fields& fields, GivenLaw& law, const char* key, const char* meaning) {
  fields.kind(key, law, meaning);
}

MaterialNeeds material_needs(const GivenLaw& given) {
  return std::visit(
      []<class L>(const L& law) {
        MaterialNeeds needs{.law = card_of<L>().word.c_str()};
        if constexpr (TakesMaterials<L>)
          if (law.needs_materials()) needs.in_place_of_elastic = L::in_place_of_materials;
        if constexpr (TakesYield<L>)
          if (law.needs_yield()) needs.in_place_of_yield = L::in_place_of_yield;
        return needs;
      },
      variant_of(given));
}

bool makes_fibres(const GivenLaw& given) {
  return std::visit(
      []<class L>(const L& law) {
        if constexpr (requires { law.bond; })
          return law.bond.replaces_contact();
        else
          return false;
      },
      variant_of(given));
}

bool is_cut_by_edges(const GivenLaw& given) {
  return std::visit(
      []<class L>(const L& law) {
        if constexpr (requires { law.bond; })
          return !std::isnan(law.bond.cutting);
        else
          return false;
      },
      variant_of(given));
}

std::optional<double> liquid_volume(const GivenLaw& given) {
  return std::visit(
      []<class L>(const L& law) -> std::optional<double> {
        if constexpr (requires { law.cohesion; })
          if (law.cohesion.kind == dem::Cohesion::Kind::liquid_bridge) return law.cohesion.volume;
        return std::nullopt;
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

}  // namespace subsoil::sim
