#include "libsim/setup/laws.hpp"

#include <fmt/format.h>

#include <cmath>

namespace subsoil::sim {

int material_index(const Scenario& scenario, const std::string& name) {
  for (std::size_t i = 0; i < scenario.materials.size(); ++i)
    if (scenario.materials[i].name == name) return static_cast<int>(i);
  throw std::invalid_argument("no material '" + name + "'");
}

dem::LawTable build_laws(const Loaded& loaded) {
  const Scenario& s = loaded.scenario;
  dem::LawTable table;
  table.materials = static_cast<int>(s.materials.size());
  table.index.assign(s.materials.size() * s.materials.size(), -1);
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const Contact& contact = s.contacts[i];
    const int a = material_index(s, contact.between[0]), b = material_index(s, contact.between[1]);
    const Material &ma = s.materials[static_cast<std::size_t>(a)], &mb = s.materials[static_cast<std::size_t>(b)];
    const std::string where = loaded.where(fmt::format("contacts[{}].law", i));
    try {
      table.laws.push_back(law_between(contact.law, ma, mb));
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(where + ": " + error.what());
    }
    const int n = table.materials, at = static_cast<int>(table.laws.size()) - 1;
    table.index[static_cast<std::size_t>(a * n + b)] = table.index[static_cast<std::size_t>(b * n + a)] = at;
  }
  return table;
}

}  // namespace subsoil::sim
