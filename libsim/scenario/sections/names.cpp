#include "libsim/scenario/sections/names.hpp"

#include <fmt/format.h>

#include <map>

#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {
namespace {

struct NameChecks : Checks {
  const Scenario& s;
  std::map<std::string, std::string> taken{};  // whose a name is: "a wall of the container"

  void names() {
    own();
    group(s.boundaries, "boundaries", "name", &BoundarySection::name, "a boundary");
    if (s.soil && s.soil->bed)
      group(s.soil->bed->particles, "soil.bed.particles", "fixed", &Particle::fixed, "fixed spheres");
    if (s.soil && s.soil->bed)
      for (const FibreSection& f : s.soil->bed->fibres)
        if (is_free("soil.bed.fibres." + f.name, f.name)) taken.emplace(f.name, "fibres");
    if (s.soil)
      for (const InletSection& inlet : s.soil->inlets)
        if (is_free("soil.inlets." + inlet.name, inlet.name)) taken.emplace(inlet.name, "an inlet");
    if (s.machine) machine(*s.machine);
    for (const Watch& watch : s.output.watch)
      if (watch.name == "time") is_free("output.monitor.time", watch.name);
  }

 private:
  void own() {
    taken = {{"time", "the first column"}, {"energy", "the energy balance"}};
    if (s.machine) {
      for (const char* drawn : {"joints", "links", "markers"})
        taken.emplace(fmt::format("machine {}", drawn), fmt::format("the drawing of the machine's {}", drawn));
      for (const std::string& body : names_of(s.machine->bodies))
        taken.emplace(body + " outline", "the drawing of body " + body);
    }
    if (!s.soil) return;
    for (const char* word : {"soil", "interface"}) taken.emplace(word, "the soil's sums");
    if (s.soil->moving) taken.emplace("window", "the moving bed");
    if (!s.soil->container) return;
    taken.emplace("container", "all walls of the container");
    for (const std::string& wall : wall_names(*s.soil->container)) taken.emplace(wall, "a wall of the container");
    if (s.soil->bed && s.soil->bed->rough_floor) taken.emplace(rough_floor_name, "the rough floor");
  }

  /// Of a list whose members may share a name: fixed spheres belong together, boundaries are checked by their section.
  template <class Member>
  void group(const std::vector<Member>& members, const char* list, const char* key, std::string Member::*name,
             const char* whose) {
    std::map<std::string, std::string> fresh;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::string& word = members[i].*name;
      if (!word.empty() && !fresh.contains(word) && is_free(fmt::format("{}[{}].{}", list, i, key), word))
        fresh.emplace(word, whose);
    }
    taken.merge(fresh);
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

}  // namespace subsoil::sim
