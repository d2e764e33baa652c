#include "libsim/scenario/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <variant>

#include "libsim/scenario/integrator_choice.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {
namespace {

bool has_own_bed(const Scenario& s) { return s.soil && s.soil->bed; }
bool has_spheres(const Scenario& s) { return s.soil && (s.soil->bed || !s.soil->inlets.empty()); }
const BedSection& bed(const Scenario& s) { return *s.soil->bed; }
bool is_made(const Scenario& s) { return has_own_bed(s) && bed(s).fill <= Fill::random; }

/// A radius that is drawn from a distribution; left out in a layer, it is the bed's.
bool is_drawn(const RadiusDistribution& radius) { return !std::holds_alternative<EqualRadius>(radius); }
bool draws_radii(const Scenario& s) {
  return is_made(s) && (is_drawn(bed(s).radius) || std::any_of(bed(s).layers.begin(), bed(s).layers.end(),
                                                               [](const Layer& l) { return is_drawn(l.radius); }));
}
bool draws_numbers(const Scenario& s) {
  if (!has_own_bed(s)) return false;
  const auto& fibres = bed(s).fibres;
  if (std::any_of(fibres.begin(), fibres.end(), [](const FibreSection& f) { return !f.seed; })) return true;
  return is_made(s) && (bed(s).fill == Fill::random || bed(s).jitter != 0 || !bed(s).clumps.empty() || draws_radii(s));
}

Settle settle_of(const Scenario& s) { return bed(s).settle.value_or(Settle{}); }
bool settles_in_stages(const Scenario& s) { return has_own_bed(s) && settle_of(s).staged(bed(s).fill); }
bool waits_for_rest(const Scenario& s) {
  return settles_in_stages(s) || (has_own_bed(s) && (!settle_of(s).duration || bed(s).fill == Fill::random));
}

/// Something that a sphere could be inside of.
bool has_solids(const Scenario& s) {
  return !s.boundaries.empty() ||
         (s.machine && std::any_of(s.machine->surfaces.begin(), s.machine->surfaces.end(),
                                   [](const Surface& surface) { return surface.touches_soil; }));
}

bool has_bed(const Scenario& s) { return s.has_bed(); }
bool has_machine(const Scenario& s) { return s.machine.has_value(); }
bool has_machine_in_soil(const Scenario& s) { return s.machine && s.has_bed(); }
bool iterates(const Scenario& s) { return has_machine_in_soil(s) && s.time.coupling == CouplingWord::iterated; }

/// Whether the machine is integrated by one of these.
template <mbd::IntegratorKind... Kinds>
bool integrates_by(const Scenario& s) {
  return !s.machine || ((integrator_of(s) == Kinds) || ...);  // without a machine another entry refuses the key
}
constexpr auto by_adams_moulton = integrates_by<mbd::IntegratorKind::adams_moulton>;
constexpr auto by_ida = integrates_by<mbd::IntegratorKind::ida>;
constexpr auto by_variable_steps = integrates_by<mbd::IntegratorKind::cvode, mbd::IntegratorKind::ida>;

constexpr const char* no_spheres = "there are no spheres";
constexpr const char* no_bed = "there is neither soil nor a boundary";
constexpr const char* no_machine = "there is no machine";
constexpr const char* no_machine_in_soil = "there is no machine in soil";
constexpr const char* not_iterated = "it is of `time.coupling: iterated`";

constexpr std::array<ConditionalKey, 38> keys{{
    {"soil.bed.seed", draws_numbers, "the fill draws no random number: every seed gives the same bed"},
    {"soil.bed.shares", draws_radii, "the radii are not drawn from a distribution"},
    {"soil.bed.inside machine", has_solids, "there is neither a machine's surface nor a boundary"},
    {"soil.bed.settle.lowered", settles_in_stages, "the bed does not settle in stages"},
    {"soil.bed.settle.lowered", [](const Scenario& s) { return has_own_bed(s) && !settle_of(s).density; },
     "a bed that is compacted to a density is poured with all its friction"},
    {"soil.bed.settle.ramp", settles_in_stages, "the bed does not settle in stages"},
    {"soil.bed.settle.at most", waits_for_rest, "the bed settles for a given time"},
    {"soil.active.within", has_spheres, no_spheres},
    {"soil.active.below", has_spheres, no_spheres},
    {"soil.remove below", [](const Scenario& s) { return has_spheres(s) && s.soil->container.has_value(); },
     "there is no container that a sphere could fall out of"},
    // With soil also beside a `soil step`, which a command line may give for the one that they choose.
    {"time.safety", has_bed, no_bed},
    {"time.accuracy", has_bed, no_bed},
    {"time.coupling", has_machine_in_soil, no_machine_in_soil},
    {"time.coupling tolerance", iterates, not_iterated},
    {"time.coupling iterations", iterates, not_iterated},
    {"time.machine.integrator", has_machine, no_machine},
    {"time.machine.locate events", has_machine, no_machine},
    {"time.machine.step", has_machine, no_machine},
    {"time.machine.order", has_machine, no_machine},
    {"time.machine.rtol", has_machine, no_machine},
    {"time.machine.atol", has_machine, no_machine},
    {"time.machine.formulation", has_machine, no_machine},
    {"time.machine.order", by_adams_moulton, "it is of `integrator: adams-moulton`", true},
    {"time.machine.rtol", by_variable_steps, "it is of `integrator: cvode` and `ida`", true},
    {"time.machine.atol", by_variable_steps, "it is of `integrator: cvode` and `ida`", true},
    {"time.machine.formulation", by_ida, "it is of `integrator: ida`", true},
    {"time.machine.soil steps per machine step", has_machine_in_soil, no_machine_in_soil},
    {"limits.overlap", has_bed, no_bed},
    {"limits.speed", has_bed, no_bed},
    {"limits.soil energy", has_bed, no_bed},
    {"limits.energy", has_machine, no_machine},
    {"output.sample losses every", has_bed, no_bed},
    {"output.columns", has_bed, no_bed},
    {"output.contact forces", has_bed, no_bed},
    {"output.region", has_bed, no_bed},
    {"output.series digits", has_bed, "a machine without soil is written with all digits"},
    {"output.frames", [](const Scenario& s) { return s.engine == SoilEngine::liggghts; },
     "it is of `engine: liggghts`, which works on many processes"},
    {"precision", has_bed, no_bed},
}};

/// What chooses the integrator; see integrator_of.
constexpr std::array<std::string_view, 4> chooses_method{"analysis", "time.machine.integrator", "time.machine.step",
                                                         "time.machine.order"};

/// A command line may choose a method beside a file that has the keys of several.
bool method_is_set_apart(std::string_view key, const Places& places) {
  return std::any_of(chooses_method.begin(), chooses_method.end(), [&](std::string_view by) {
    const std::string path(by);
    return by != key && places.contains(path) && place_of(places, path).file == Place::command_line;
  });
}

/// Takes one key, with all below it, out of a document.
void erase(Node& node, std::string_view path) {
  const std::size_t dot = path.find('.');
  const std::string_view head = path.substr(0, dot);
  const auto at =
      std::find_if(node.entries.begin(), node.entries.end(), [&](const Node::Entry& e) { return e.key == head; });
  if (at == node.entries.end()) return;
  if (dot == std::string_view::npos)
    node.entries.erase(at);
  else
    erase(at->value, path.substr(dot + 1));
}

}  // namespace

std::span<const ConditionalKey> conditional_keys() { return keys; }

void check_effects(const Scenario& s, const Places& places, Problems& problems) {
  for (const ConditionalKey& key : keys)
    if (places.contains(key.path) && !key.acts(s) && !(key.of_method && method_is_set_apart(key.path, places)))
      problems.add(place_of(places, key.path), key.path, fmt::format("has no effect: {}; leave it out", key.otherwise));
}

void drop_without_effect(Node& document, const Scenario& s) {
  for (const ConditionalKey& key : keys)
    if (!key.acts(s)) erase(document, key.path);
}

}  // namespace subsoil::sim
