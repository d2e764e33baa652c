#include <gtest/gtest.h>

#include <map>
#include <set>

#include "libsim/keys/known_keys.hpp"
#include "libsim/scenario/effects.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/scratch.hpp"

/// Keys without effect: which there are, that each is refused where it has none and taken where it has, and that what
/// is taken does change the bed.
namespace subsoil::sim::scenario_effects_test {
namespace {

using subsoil::test::message_of;

constexpr const char* head = R"(subsoil: 1
materials: {a: {density: 2500 kg/m^3}}
contacts: [{between: [a, a], law: linear, k_n: 20 kN/m, restitution: 0.5, mu: 0.5}]
)";
constexpr const char* alone = R"(subsoil: 1
machine:
  bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}
  joints: {pin: {revolute: [ground, b], at: 0 1 m}}
time: {end: 1 ms}
)";

std::string soil(const std::string& bed, const std::string& more = "time: {end: 1 ms}\n") {
  return std::string(head) +
         "soil:\n  container: {size: 60 80 60 mm, at: 0 0 0 m, material: a}\n  bed: {material: a, " + bed + "}\n" +
         more;
}
const std::string poured = "fill: random, radius: 6 mm, count: 40";
const std::string listed = "fill: particles, particles: [{position: 30 10 30 mm, radius: 6 mm}]";
const std::string grid = "fill: lattice, radius: 5 mm, pitch: 11 mm";

/// A key, its value, and scenarios in which it acts and in which it does not.
struct Case {
  std::string value, acts, idle;
};
const std::map<std::string, Case>& cases() {
  static const std::string dry = soil(listed), rain = soil(poured), rests = soil(grid + ", settle: {for: 1 ms}");
  static const std::string grains = soil("fill: lattice, radius: {uniform: 4 5 mm}, pitch: 11 mm");
  static const std::string plate = soil(listed) + "boundaries: [{name: p, material: a, shape: {box: 5 5 5 mm}}]\n";
  static const std::string with_machine = dry + std::string(alone).substr(11, std::string(alone).find("time:") - 11);
  static const std::string iterated =
      soil(listed, "time: {end: 1 ms, coupling: iterated}\n") + with_machine.substr(dry.size());
  static const std::string by_ida =
      std::string(alone).replace(std::string(alone).find("{end: 1 ms}"), 11, "{end: 1 ms, machine: {integrator: ida}}");
  static const std::map<std::string, Case> all{
      {"soil.bed.seed", {"2", rain, dry}},
      {"soil.bed.shares", {"mass", grains, soil(grid)}},
      {"soil.bed.inside machine", {"carve", plate, dry}},
      {"soil.bed.settle.lowered", {"0.2", rain, rests}},
      {"soil.bed.settle.ramp", {"0.2 s", rain, rests}},
      {"soil.bed.settle.at most", {"4 s", soil(grid + ", settle: {until: 1 mm/s}"), rests}},
      {"soil.active.within", {"10 mm", dry, ""}},
      {"soil.active.below", {"1 mm/s", dry, ""}},
      {"soil.remove below", {"0.1 m", dry, ""}},
      {"time.safety", {"0.5", dry, alone}},
      {"time.accuracy", {"0.05", dry, alone}},
      {"time.coupling", {"iterated", with_machine, alone}},
      {"time.coupling tolerance", {"1 um", iterated, with_machine}},
      {"time.coupling iterations", {"5", iterated, with_machine}},
      {"time.machine.integrator", {"auto", alone, dry}},
      {"time.machine.locate events", {"no", alone, dry}},
      {"time.machine.step", {"1 ms", alone, dry}},
      {"time.machine.order", {"3", with_machine, dry}},
      {"time.machine.rtol", {"1e-6", alone, dry}},
      {"time.machine.atol", {"1e-6", alone, dry}},
      {"time.machine.formulation", {"index 1", by_ida, dry}},
      {"time.machine.soil steps per machine step", {"2", with_machine, alone}},
      {"limits.overlap", {"0.4", dry, alone}},
      {"limits.speed", {"4 m/s", dry, alone}},
      {"limits.soil energy", {"0.4", dry, alone}},
      {"limits.energy", {"0.4", alone, dry}},
      {"output.sample losses every", {"4", dry, alone}},
      {"output.columns", {"[position]", dry, alone}},
      {"output.contact forces", {"yes", dry, alone}},
      {"output.region", {"{at: 0 0 0 m, size: 1 1 1 m}", dry, alone}},
      {"output.series digits", {"all", dry, alone}},
      {"output.frames", {"gathered", "", dry}},
      {"precision", {"mixed", dry, alone}},
  };
  return all;
}

std::string refusal(const std::string& text, const std::vector<std::string>& sets) {
  return message_of<ScenarioError>([&] { load_scenario_text(text, "case.yaml", sets); });
}

TEST(ScenarioEffects, AKeyIsRefusedWhereItHasNoEffectAndTakenWhereItHas) {
  for (const ConditionalKey& key : conditional_keys()) {
    ASSERT_TRUE(cases().contains(key.path)) << key.path << ": give it a case here";
    const Case& one = cases().at(key.path);
    const std::string set = std::string(key.path) + "=" + one.value, why = "has no effect: ";
    const std::vector<std::string> sets{set};
    if (!one.acts.empty()) {
      EXPECT_EQ(refusal(one.acts, sets).find(std::string(key.path) + ": " + why), std::string::npos)
          << key.path << ": " << refusal(one.acts, sets);
    }
    if (!one.idle.empty()) {
      EXPECT_NE(refusal(one.idle, {set}).find(why), std::string::npos) << key.path << ": " << refusal(one.idle, {set});
    }
  }
}

/// Tolerances beside a fixed step were taken without effect. A command line may choose a method beside a file that has
/// the keys of several.
TEST(ScenarioEffects, KeysOfAnotherIntegratorAreRefusedUnlessTheCommandLineChoosesIt) {
  const auto with = [](const std::string& machine) {
    std::string text = alone;
    return text.replace(text.find("{end: 1 ms}"), 11, "{end: 1 ms, machine: {" + machine + "}}");
  };
  EXPECT_NE(refusal(with("step: 1 ms, rtol: 1e-6"), {})
                .find("time.machine.rtol: has no effect: it is of `integrator: "
                      "cvode` and `ida`"),
            std::string::npos);
  EXPECT_NE(refusal(with("integrator: cvode, order: 3"), {}).find("time.machine.order: has no effect"),
            std::string::npos);
  EXPECT_NE(refusal(with("integrator: cvode"), {"time.machine.order=3"}).find("time.machine.order: has no effect"),
            std::string::npos);
  EXPECT_NE(refusal(with("formulation: index 1"), {}).find("it is of `integrator: ida`"), std::string::npos);
  EXPECT_EQ(refusal(with("rtol: 1e-6, atol: 1e-6"), {}), "accepted");
  EXPECT_EQ(refusal(with("integrator: ida, rtol: 1e-6, formulation: index 1"), {}), "accepted");
  EXPECT_EQ(refusal(with("integrator: ida, rtol: 1e-6, formulation: index 1"),
                    {"time.machine.integrator=adams-moulton", "time.machine.order=3"}),
            "accepted");
  EXPECT_EQ(refusal(with("rtol: 1e-6"), {"time.machine.step=0.1 ms"}), "accepted");
}

/// Every key of the sections whose keys depend on each other is either listed as conditional, or here: what refuses it
/// elsewhere, or why it acts wherever it may stand. A new key fails until it is in one of the lists.
TEST(ScenarioEffects, EveryKeyOfTheseSectionsIsClassified) {
  const std::set<std::string> act_always{
      // what says what there is, and where
      "soil.bed.fill", "soil.bed.material", "soil.bed.layers", "soil.bed.settle", "soil.bed.settle.for",
      "soil.bed.settle.until", "soil.bed.settle.to", "soil.bed.settle.stages", "soil.bed.save", "soil.bed.rough floor",
      "soil.container", "soil.surface", "soil.bed", "soil.active", "soil.moving", "soil.clumps", "soil.inlets",
      "soil.bed.fibres",
      // refused by the checks of the bed, with the fill that does not take them
      "soil.bed.radius", "soil.bed.pitch", "soil.bed.region", "soil.bed.count", "soil.bed.depth", "soil.bed.jitter",
      "soil.bed.file", "soil.bed.particles", "soil.bed.clumps", "soil.bed.placed",
      // every run has them
      "time.end", "time.threads", "time.machine", "time.stop when",
      // refused by the checks of the time
      "time.soil step",
      // every run writes rows, frames and a summary
      "output.every", "output.at", "output.series every", "output.series at", "output.forces", "output.precision",
      "output.compression", "output.state every", "output.state", "output.monitor", "output.crossings",
      "output.window"};
  std::set<std::string> conditional;
  for (const ConditionalKey& key : conditional_keys()) conditional.insert(key.path);
  const std::set<std::string> sections{"soil", "soil.bed",     "soil.bed.settle", "soil.active",
                                       "time", "time.machine", "limits",          "output"};
  std::size_t seen = 0;
  for (const KnownKey& key : known_keys()) {
    const std::size_t dot = key.path.rfind('.');
    if (dot == std::string::npos || !sections.contains(key.path.substr(0, dot))) continue;
    ++seen;
    EXPECT_NE(act_always.contains(key.path), conditional.contains(key.path)) << key.path;
  }
  EXPECT_GT(seen, 60U);
}

/// Of the keys of the bed: another value makes another bed, or the key is refused. With a value per key, in each fill.
TEST(ScenarioEffects, AKeyOfTheBedThatIsTakenChangesTheBed) {
  const std::map<std::string, std::string> values{{"radius", "4.5 mm"}, {"shares", "mass"}, {"pitch", "12 mm"},
                                                  {"count", "30"},      {"depth", "40 mm"}, {"seed", "5"},
                                                  {"jitter", "0.2"}};
  const std::map<std::string, std::string> beds{
      {"random", "fill: random, radius: 6 mm, count: 40, settle: {for: 20 ms, stages: no}"},
      {"lattice", grid},
      {"jittered", grid + ", jitter: 0.1"},
      {"drawn", "fill: lattice, radius: {uniform: 4 5 mm}, pitch: 11 mm"},
      {"rest-lattice", "fill: rest-lattice, radius: 5 mm"},
      {"particles", listed}};
  const auto numbers = [](const World& w) {
    std::vector<double> out;
    for (const dem::Sphere& s : w.bed->spheres()) out.insert(out.end(), {s.x.x, s.x.y, s.x.z, s.r});
    return out;
  };
  std::size_t changed = 0, refused = 0;
  for (const auto& [name, bed] : beds) {
    const std::string text = soil(bed);
    const std::vector<double> plain =
        numbers(build_world(load_scenario_text(text, "case.yaml"), {.threads = 1, .restored = {}, .progress = {}}));
    for (const auto& [key, value] : values) {
      const std::string set = "soil.bed." + key + "=" + value;
      try {
        const Loaded loaded = load_scenario_text(text, "case.yaml", {set});
        EXPECT_NE(numbers(build_world(loaded, {.threads = 1, .restored = {}, .progress = {}})), plain)
            << name << ": " << set;
        ++changed;
      } catch (const ScenarioError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(changed, 12U);
  EXPECT_GT(refused, 12U);
}

/// The explicit copy of a run leaves out what has no effect in it: it is read again.
TEST(ScenarioEffects, TheExplicitCopyHoldsNoKeyWithoutEffect) {
  for (const std::string& text : {soil(listed), soil(poured), std::string(alone)}) {
    const std::string copy = write_scenario(load_scenario_text(text, "case.yaml").scenario);
    EXPECT_EQ(message_of<ScenarioError>([&] { load_scenario_text(copy, "copy.yaml"); }), "accepted") << copy;
  }
  EXPECT_EQ(write_scenario(load_scenario_text(soil(listed), "case.yaml").scenario).find("seed"), std::string::npos);
  EXPECT_NE(write_scenario(load_scenario_text(soil(poured), "case.yaml").scenario).find("seed: 1"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::scenario_effects_test
