#pragma once
#include <array>
#include <string>
#include <vector>

#include "libsim/scenario/given_law.hpp"
#include "libsim/scenario/sections/materials.hpp"

/// The law of each pair of materials that can meet.
namespace subsoil::sim {

/// A value of a law, by the key of law and material, that follows from those of the two materials.
struct Combination {
  std::string key;
  CombinationRule rule;
};

/// The law between two materials; `between` holds names, in the file's order.
struct Contact {
  std::array<std::string, 2> between;
  GivenLaw law;
  std::vector<Combination> combine{};  // done by the reader: the law holds the values
};
void describe(Fields& v, Contact& c);

struct Checks;
struct Scenario;
void check_contacts(Checks& checks, const Scenario& s);

}  // namespace subsoil::sim
