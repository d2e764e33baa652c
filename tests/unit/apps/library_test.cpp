#include "libsim/document/library.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libdem/laws/contact.hpp"
#include "libdem/laws/eepa.hpp"
#include "libdem/laws/linear.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/run/input_report.hpp"
#include "libsim/scenario/given_law.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/laws.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// The library of materials: what a scenario that names one gets.
namespace subsoil::sim::library_test {
namespace {

using namespace test;
using subsoil::test::message_of;

/// A bed of two spheres on a plate.
std::string on_steel(const std::string& soil, const std::string& contacts = "") {
  return "subsoil: 1\nmaterials: {soil: " + soil + ", share: library steel}\n" + contacts +
         "soil: {bed: {fill: particles, material: soil, particles: [{position: 0 0.01 0 m, radius: 10 mm}, {position: "
         "0 "
         "0.03 0 m, radius: 10 mm}]}}\n"
         "boundaries: [{name: plate, material: share, shape: {box: 0.1 0.01 0.1 m}, at: 0 -0.005 0 m}]\n"
         "time: {end: 1 ms}\n";
}

std::vector<std::string> soils() {
  std::vector<std::string> out;
  for (const LibraryMaterial& m : library())
    if (m.is_soil()) out.push_back(m.name);
  return out;
}

class LibrarySoil : public testing::TestWithParam<std::string> {};

TEST_P(LibrarySoil, HasDensityAndLawsWithItselfAndWithSteelThatBearItsSpheres) {
  const Loaded loaded = load_scenario_text(on_steel("library " + GetParam()));
  const Scenario& s = loaded.scenario;
  ASSERT_EQ(s.contacts.size(), 2u);
  EXPECT_GT(s.materials[0].density, 1000);
  EXPECT_LT(s.materials[0].density, 3000);
  const double r = parse_quantity(library_material(GetParam()).radius, "m");
  for (const Contact& c : s.contacts) {
    const dem::Law law = law_between(c.law, s.materials[0], s.materials[c.between[1] == "soil" ? 0 : 1]);
    EXPECT_NO_THROW(law->refuse_collapse(r)) << c.between[1];
    double memory[dem::kOwnMemory] = {};
    const double mass = s.materials[0].density * dem::sphere_volume(r);
    // A tenth of a radius bears more than a column of 1 m above the sphere does.
    EXPECT_GT(
        law->normal({.overlap = 0.1 * r, .rate = 0, .root_m = std::sqrt(mass), .r_eff = r, .elapsed = 1e-6}, memory)
            .force,
        1 / (2 * r) * mass * 9.81);
  }
}

TEST_P(LibrarySoil, SaysItsSourceAndWhatTestsGave) {
  const LibraryMaterial& m = library_material(GetParam());
  EXPECT_GT(m.source.size(), 20u);
  ASSERT_FALSE(m.tests.empty());
  for (const LibraryTest& t : m.tests) EXPECT_NE(t.measured.find("+-"), std::string::npos) << t.number;
  EXPECT_NE(library_table().find(GetParam() + " "), std::string::npos);
  EXPECT_NE(library_text(m).find(m.source), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(All, LibrarySoil, testing::ValuesIn(soils()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Library, HasTheSoilsThatAreWanted) {
  for (const char* name : {"sandy-loam-10mm", "compact-sandy-loam-10mm", "clay-10mm", "dry-sand-10mm", "wet-sand-10mm",
                           "gravel-10mm", "wheat-10mm", "steel"})
    EXPECT_NO_THROW(library_material(name)) << name;
}

TEST(Library, AnUnknownNameIsRefusedWithItsPlaceAndTheNearestOne) {
  const std::string message = message_of<ScenarioError>([] { load_scenario_text(on_steel("library dry-sant-10mm")); });
  EXPECT_EQ(
      message,
      "scenario.yaml:2:19 materials.soil = library dry-sant-10mm: the library has no material of this name; did you "
      "mean `dry-sand-10mm`?; `subsoil materials` lists them");
}

TEST(Library, OwnValuesAndOwnContactsStay) {
  const std::string own = "contacts: [{between: [share, soil], law: linear, k_n: 7 kN/m, restitution: 0.5, mu: 0.9}]\n";
  const Loaded loaded = load_scenario_text(on_steel("{library: dry-sand-10mm, density: 2500 kg/m^3}", own));
  EXPECT_EQ(loaded.scenario.materials[0].density, 2500);
  ASSERT_EQ(loaded.scenario.contacts.size(), 2u);
  EXPECT_EQ(loaded.scenario.contacts[0].law.get_if<dem::Linear>()->k_n, 7e3);
  EXPECT_EQ(loaded.scenario.contacts[1].between[1], "soil");
}

TEST(Library, PathsOfSetLeadIntoItAndMayChooseFromIt) {
  const Loaded changed =
      load_scenario_text(on_steel("library dry-sand-10mm"), "scenario.yaml", {"contacts.soil-share.mu=0.77"});
  EXPECT_EQ(changed.scenario.contacts[1].law.get_if<dem::Linear>()->friction.mu, 0.77);
  const Loaded chosen =
      load_scenario_text(on_steel("{density: 1 kg/m^3}"), "scenario.yaml", {"materials.soil=library clay-10mm"});
  EXPECT_NE(chosen.scenario.contacts[0].law.get_if<dem::Eepa>(), nullptr);
}

/// The scenario's own choice leaves nothing behind: neither density nor law.
TEST(Library, AMaterialChosenByASetBringsItsOwnDensityAndLaw) {
  const auto emitted = [](const std::string& material, const std::vector<std::string>& sets) {
    const Loaded loaded = load_scenario_text(on_steel(material), "scenario.yaml", sets);
    EXPECT_EQ(loaded.scenario.contacts.size(), 2u);
    return std::pair(loaded.scenario.materials[0].density,
                     loaded.scenario.contacts[0].law.get_if<dem::Eepa>() != nullptr);
  };
  const double clay = load_scenario_text(on_steel("library clay-10mm")).scenario.materials[0].density;
  for (const char* set :
       {"materials.soil=library clay-10mm", "materials.soil.library=clay-10mm", "materials.soil={library: clay-10mm}"})
    for (const char* own : {"library dry-sand-10mm", "{library: dry-sand-10mm}"}) {
      const auto [density, law] = emitted(own, {set});
      EXPECT_EQ(density, clay) << own << ", " << set;
      EXPECT_TRUE(law) << own << ", " << set << ": the law of clay is eepa, that of dry sand linear";
    }
}

TEST(Library, SpheresOfAnotherRadiusAreWarnedOf) {
  const RunDirectory dir;
  const auto warnings = [&](const std::vector<std::string>& sets) {
    const std::string file = dir.scenario(on_steel("library dry-sand-10mm"));
    const Loaded loaded = load_scenario(file, sets);
    BuildOptions options;
    options.threads = 1;
    const World world = build_world(loaded, options);
    return input_warnings(loaded, world, file, sets);
  };
  EXPECT_TRUE(warnings({}).empty());
  const auto found = warnings({"soil.bed.particles[0].radius=5 mm", "soil.bed.particles[1].radius=5 mm"});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("was measured with spheres of 10 mm, these have 5 mm"), std::string::npos) << found[0];
}

}  // namespace
}  // namespace subsoil::sim::library_test
