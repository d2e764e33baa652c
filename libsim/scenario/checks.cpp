#include "libsim/scenario/checks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libsim/scenario/scenario.hpp"
#include "libsim/scenario/sections/engine.hpp"
#include "libsim/scenario/sections/fibres.hpp"
#include "libsim/scenario/sections/names.hpp"

namespace subsoil::sim {

bool holds(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void Checks::refuse(const std::string& path, const std::string& rule) {
  problems.add(place_of(places, path), path, rule);
}

void Checks::refuse(const std::string& path, const std::string& value, const std::string& rule) {
  problems.add(place_of(places, path), path, value, rule);
}

void Checks::refer(const std::string& path, const std::string& name, const Names& known, const char* what) {
  if (name.empty() || holds(known, name)) return;
  refuse(path, name, fmt::format("there is no {} of this name{}", what, suggestion(name, known)));
}

void Checks::positive(const std::string& path, const Vec3& size) {
  if (size.x <= 0 || size.y <= 0 || size.z <= 0) refuse(path, "all lengths must be above zero");
}

void Checks::direction(const std::string& path, const Vec3& d) {
  if (d == Vec3{}) refuse(path, "a direction must not be the zero vector");
}

void check(Scenario& s, const Places& places, Problems& problems) {
  Checks checks{places, problems, names_of(s.materials)};
  if (!s.soil && !s.machine && s.boundaries.empty())
    checks.refuse("scenario", "there is nothing to simulate; give `soil`, `machine` or both");
  if (s.soil) check_soil(checks, s);
  check_boundaries(checks, s);
  if (s.machine) check_machine(checks, s);
  check_cutting(checks, s);
  check_names(checks, s);
  check_contacts(checks, s);
  check_time(checks, s);
  check_output(checks, s);
  check_engine(checks, s);
}

}  // namespace subsoil::sim
