#pragma once
#include <string>
#include <vector>

#include "libsim/document/document.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/keys/reading.hpp"

namespace subsoil::sim {

struct Scenario;

/// What no single key can know: names that must exist, pairs of materials that need a law, keys that need or exclude
/// each other. Each section checks itself; fills Surface::body_index.
void check(Scenario& scenario, const Places& places, Problems& problems);

using Names = std::vector<std::string>;

template <class T>
Names names_of(const std::vector<T>& values) {
  Names names;
  for (const T& value : values) names.push_back(value.name);
  return names;
}
bool holds(const Names& names, const std::string& name);

/// What the checks of all sections use.
struct Checks {
  const Places& places;
  Problems& problems;
  Names materials;

  void refuse(const std::string& path, const std::string& rule);
  void refuse(const std::string& path, const std::string& value, const std::string& rule);
  void refer(const std::string& path, const std::string& name, const Names& known, const char* what);
  void material(const std::string& path, const std::string& name) { refer(path, name, materials, "material"); }
  void positive(const std::string& path, const Vec3& size);
  void direction(const std::string& path, const Vec3& d);
};

}  // namespace subsoil::sim
