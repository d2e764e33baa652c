#include "apps/scenario/sections/names.hpp"

#include <fmt/format.h>

#include <map>

#include "apps/scenario/scenario.hpp"

namespace subsoil::app {
namespace {

struct NameChecks : Checks {
  const Scenario& s;
  std::map<std::string, std::string> taken{};  // whose a name is: "a wall of the container"

  void names() {
    own();
    for (std::size_t i = 0; i < s.boundaries.size(); ++i)
      if (const std::string& name = s.boundaries[i].name; !name.empty() && is_free(at("boundaries", i) + ".name", name))
        taken.emplace(name, "a boundary");
    if (s.soil && s.soil->bed) fixed_spheres(s.soil->bed->particles);
    if (s.machine) machine(*s.machine);
    for (const Watch& watch : s.output.watch)
      if (watch.name == "time") is_free("output.watch.time", watch.name);
  }

 private:
  static std::string at(const char* list, std::size_t i) { return fmt::format("{}[{}]", list, i); }

  void own() {
    taken = {{"time", "the first column"}, {"energy", "the energy balance"}};
    if (!s.soil) return;
    for (const char* word : {"soil", "interface"}) taken.emplace(word, "the soil's sums");
    if (s.soil->moving) taken.emplace("window", "the moving bed");
    if (!s.soil->container) return;
    taken.emplace("container", "all walls of the container");
    for (std::size_t face = 0; face < face_names.size(); ++face)
      if (has_wall(*s.soil->container, face)) taken.emplace(wall_name(face), "a wall of the container");
    if (s.soil->bed && s.soil->bed->rough_floor) taken.emplace(rough_floor_name, "the rough floor");
  }

  /// Spheres of one name belong together.
  void fixed_spheres(const std::vector<Particle>& particles) {
    std::map<std::string, std::string> groups;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const std::string& name = particles[i].fixed;
      if (name.empty() || groups.contains(name) || !is_free(at("soil.bed.particles", i) + ".fixed", name)) continue;
      groups.emplace(name, "fixed spheres");
    }
    taken.merge(groups);
  }

  void machine(const MachineSection& m) {
    for (const Surface& surface : m.surfaces) is_free("machine.surfaces." + surface.name, surface.name);
    const auto take = [&](const Names& names, const std::string& family) {
      for (const std::string& name : names)
        if (is_free(fmt::format("machine.{}.{}", family, name), name)) taken.emplace(name, "one of machine." + family);
    };
    take(names_of(m.bodies), "bodies");
    take(names_of(m.markers), "markers");
    take(names_of(m.joints), "joints");
    take(names_of(m.drivers), "drivers");
    take(names_of(m.forces), "forces");
    take(names_of(m.measures), "measures");
    take(names_of(m.controllers), "controllers");
  }

  bool is_free(const std::string& path, const std::string& name) {
    const auto there = taken.find(name);
    if (there == taken.end()) return true;
    refuse(path, fmt::format("`{}` is the name of {} too; names in the results must differ: take another", name,
                             there->second));
    return false;
  }
};

}  // namespace

void check_names(Checks& checks, const Scenario& scenario) { NameChecks{checks, scenario}.names(); }

}  // namespace subsoil::app
