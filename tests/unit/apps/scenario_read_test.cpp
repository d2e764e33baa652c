#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "libdem/laws/eepa.hpp"
#include "libdem/laws/hysteretic.hpp"
#include "libdem/laws/linear.hpp"
#include "libdem/laws/luding.hpp"
#include "libdem/laws/variable_restitution.hpp"
#include "libdem/laws/wet.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libsim/scenario/load.hpp"
#include "scenario_samples.hpp"

namespace subsoil::sim::scenario_read_test {
namespace {

using Lines = std::vector<std::string>;

Lines refusals(const std::string& text, const Lines& sets = {}) {
  try {
    load_scenario_text(text, "till.yaml", sets);
  } catch (const ScenarioError& e) {
    return e.lines;
  }
  return {};
}

// ---- what is read --------------------------------------------------------------------------------------------------

TEST(ScenarioRead, SoilSection) {
  const Scenario s = load_scenario_text(sample_soil).scenario;
  EXPECT_EQ(s.gravity, (Vec3{0, -9.81, 0}));
  EXPECT_EQ(s.materials[0].density, 1800);
  const auto& wet = *s.contacts[0].law.get_if<dem::Wet>();
  EXPECT_EQ(wet.K_X, 10e3);
  EXPECT_EQ(wet.dc, 0.002);
  EXPECT_EQ(wet.values, dem::Wet::Values::per_body);
  EXPECT_EQ(s.soil->container->size, (Vec3{0.8, 0.3, 0.4}));
  EXPECT_EQ(s.soil->container->open_after_settling, (Faces{true, false, false, false, false, false}));
  EXPECT_EQ(std::get<EqualRadius>(s.soil->bed->radius).radius, 0.01);
  EXPECT_EQ(s.soil->bed->settle->until_speed, 0.02);
  EXPECT_EQ(std::get<BoxShape>(s.boundaries[0].shape).size, (Vec3{0.1, 0.1, 0.01}));
  EXPECT_EQ(s.boundaries[0].moves[0].velocity, (Vec3{0.5, 0, 0}));
  EXPECT_EQ(s.time.end, 4);
  EXPECT_FALSE(s.time.soil_step);
  EXPECT_FALSE(s.machine);
}

TEST(ScenarioRead, MachinePointsOfTheStartPoseComeIntoBodyAxes) {
  const Scenario s = load_scenario_text(sample_machine).scenario;
  const auto& pin = s.machine->joints[1].element.get<mbd::Revolute>();
  EXPECT_EQ(pin.body_a, 1);
  EXPECT_EQ(pin.body_b, 2);
  // The arm stands at 90 deg with its centre at (1, 2): the world point (1, 1.5) is 0.5 m along its -x axis.
  EXPECT_NEAR(pin.p_b[0], -0.5, 1e-15);
  EXPECT_NEAR(pin.p_b[1], 0, 1e-15);
  EXPECT_NEAR(pin.p_a[0], 1, 1e-15);
  EXPECT_NEAR(pin.p_a[1], 1, 1e-15);
  const auto& driver = s.machine->drivers[0].element.get<mbd::CoordinateDriver>();
  EXPECT_EQ(driver.body, 1);
  EXPECT_EQ(driver.motion.velocity.value(3), 0.5);
  const auto& wheel = s.machine->forces[0].element.get<mbd::WheelOnSoil>();
  EXPECT_EQ(wheel.k_c, 1434810);
  EXPECT_EQ(s.machine->surfaces[0].body_index, 2);
  EXPECT_EQ(s.machine->start.kind, StartKind::towing_equilibrium);
  EXPECT_EQ(s.output.watch[1].of, "arm.angle");
}

TEST(ScenarioRead, FunctionsOfTime) {
  const std::string head =
      "subsoil: 1\ntime: {end: 1 s}\nmachine:\n  bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}\n"
      "  drivers: {d: {coordinate: a.x, position: ";
  const auto position = [&](const std::string& text, double t) {
    const Scenario s = load_scenario_text(head + text + "}}\n").scenario;
    return s.machine->drivers[0].element.get<mbd::CoordinateDriver>().motion.position.value(t);
  };
  EXPECT_DOUBLE_EQ(position("20 mm", 5), 0.02);
  EXPECT_NEAR(position("{harmonic: {amplitude: 3 mm, frequency: 1 Hz}}", 0.25), 0.003, 1e-15);
  EXPECT_DOUBLE_EQ(position("{ramp: {to: 2 m, begin: 1 s, end: 2 s}}", 1.5), 1);
  EXPECT_DOUBLE_EQ(position("{polynomial: {c0: 1 m, c1: 2 m/s}}", 3), 7);
  EXPECT_DOUBLE_EQ(position("{table: [[0 s, 0 m], [1 s, 10 mm], [2 s, 20 mm]]}", 1), 0.01);
  EXPECT_DOUBLE_EQ(position("[1 m, {ramp: {to: 2 m, begin: 1 s, end: 2 s}}]", 3), 3);  // a list is a sum
}

TEST(ScenarioRead, TurnsAboutWorldAxesInTheirOrder) {
  const Rotation r = load_scenario_text(sample_soil, "till.yaml", {"boundaries.plate.rotation={turns: 90 0 90 deg}"})
                         .scenario.boundaries[0]
                         .rotation;
  // x -> x -> y, y -> z -> z, z -> -y -> x: the cyclic turn, 120 deg about (1, 1, 1).
  EXPECT_NEAR(r.angle, 2.0943951023931953, 1e-14);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(r.axis[i], 0.5773502691896258, 1e-14);
}

TEST(ScenarioRead, RadiusDistributions) {
  const auto radius = [](const std::string& text) {
    return load_scenario_text(sample_soil, "till.yaml", {"soil.bed.fill=random", "soil.bed.radius=" + text})
        .scenario.soil->bed->radius;
  };
  EXPECT_EQ(std::get<NormalRadius>(radius("{normal: 10 mm, deviation: 1 mm, minimum: 8 mm, maximum: 12 mm}")).largest,
            0.012);
  EXPECT_EQ(std::get<UniformRadius>(radius("{uniform: 8 12 mm}")).least, 0.008);
  EXPECT_EQ(std::get<TableRadius>(radius("{table: [[8 mm, 0.3], [10 mm, 70 %]]}")).share[1], 0.7);
  EXPECT_EQ(std::get<TableRadius>(radius("{table: {8 mm: 0.3, 10 mm: 0.7}}")).radius[0], 0.008);
}

// ---- includes, anchors, --set --------------------------------------------------------------------------------------

class ScenarioFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("subsoil_scenario_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_ / "parts");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  Lines refusals(const std::string& file) {
    try {
      load_scenario(file);
    } catch (const ScenarioError& e) {
      return e.lines;
    }
    return {};
  }
  std::filesystem::path folder_;
};

TEST_F(ScenarioFiles, IncludeMergesInDepthAndOwnKeysWin) {
  write("parts/base.yaml",
        "time: {end: 4 s, threads: 3}\nmachine:\n  bodies:\n    a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}\n"
        "    b: {mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m}\n");
  const std::string file = write(
      "run.yaml",
      "subsoil: 1\ninclude: parts/base.yaml\ntime: {end: 1 s}\nmachine:\n  bodies:\n    a: {mass: 3 kg}\n    b:\n");
  const Scenario s = load_scenario(file).scenario;
  EXPECT_EQ(s.time.end, 1);
  EXPECT_EQ(s.time.threads, 3);
  ASSERT_EQ(s.machine->bodies.size(), 1u);  // `b:` without value takes the included one away
  EXPECT_EQ(s.machine->bodies[0].mass, 3);
  EXPECT_EQ(s.machine->bodies[0].inertia, 1);
}

TEST_F(ScenarioFiles, ErrorsCarryTheIncludedFilesName) {
  write("parts/base.yaml", "machine:\n  bodies:\n    a: {mass: 1 m, inertia: 1 kg m^2, at: 0 0 m}\n");
  const std::string file = write("run.yaml", "subsoil: 1\ninclude: parts/base.yaml\ntime: {end: 1 s}\n");
  EXPECT_EQ(refusals(file),
            Lines{(folder_ / "parts/base.yaml").string() +
                  ":3:15 machine.bodies.a.mass = 1 m: `m` is a length (m), but needed is a mass (kg), such as kg"});
}

TEST_F(ScenarioFiles, IncludesInARingAreRefused) {
  write("parts/base.yaml", "include: ../run.yaml\n");
  const std::string file = write("run.yaml",
                                 "subsoil: 1\ninclude: parts/base.yaml\ntime: {end: 1 s}\nmachine: {bodies: {a: {mass: "
                                 "1 kg, inertia: 1 kg m^2, at: 0 0 m}}}\n");
  EXPECT_EQ(refusals(file),
            Lines{(folder_ / "parts/base.yaml").string() + ":1:10 include = ../run.yaml: includes itself"});
}

TEST_F(ScenarioFiles, MissingFiles) {
  const std::string file = write("run.yaml",
                                 "subsoil: 1\ninclude: nowhere.yaml\ntime: {end: 1 s}\nmachine: {bodies: {a: {mass: 1 "
                                 "kg, inertia: 1 kg m^2, at: 0 0 m}}}\n");
  EXPECT_EQ(refusals(file), Lines{file + ":2:10 include = nowhere.yaml: there is no such file beside " + file});
  EXPECT_EQ(refusals((folder_ / "none.yaml").string()),
            Lines{(folder_ / "none.yaml").string() + ": cannot be opened; check the name and its permissions"});
}

TEST(ScenarioRead, AnchorsAndMergeKeys) {
  const Scenario s = load_scenario_text(
                         "subsoil: 1\ntime: {end: 1 s}\nmachine:\n  bodies:\n"
                         "    a: &wheel {mass: 25 kg, inertia: 1 kg m^2, at: 0 0 m}\n"
                         "    b: {<<: *wheel, mass: 30 kg}\n    c: *wheel\n")
                         .scenario;
  EXPECT_EQ(s.machine->bodies[1].mass, 30);
  EXPECT_EQ(s.machine->bodies[1].inertia, 1);
  EXPECT_EQ(s.machine->bodies[2].mass, 25);
}

TEST(ScenarioRead, SetOverridesAnyLeaf) {
  const Scenario s = load_scenario_text(sample_soil, "till.yaml",
                                        {"soil.bed.radius=\"12 mm\"", "contacts[1].mu=0.4", "contacts.soil-soil.mu=0.1",
                                         "boundaries.plate.at=1 2 3 m", "output.at=[1 s, 2 s]"})
                         .scenario;
  EXPECT_EQ(std::get<EqualRadius>(s.soil->bed->radius).radius, 0.012);
  EXPECT_EQ(s.contacts[1].law.get_if<dem::Wet>()->friction.mu, 0.4);
  EXPECT_EQ(s.contacts[0].law.get_if<dem::Wet>()->friction.mu, 0.1);
  EXPECT_EQ(s.boundaries[0].at, (Vec3{1, 2, 3}));
  EXPECT_EQ(s.output.at, (std::vector<double>{1, 2}));
}

TEST(ScenarioRead, ErrorsNameTheSet) {
  EXPECT_EQ(refusals(sample_soil, {"soil.bed.radius=12 kg"}),
            Lines{"--set soil.bed.radius = 12 kg: `kg` is a mass (kg), but needed is a length (m), such as m"});
  EXPECT_EQ(refusals(sample_soil, {"soil.bed.radus=12 mm"}),
            Lines{"--set soil.bed.radus = 12 mm: unknown key; did you mean `radius`?"});
  EXPECT_EQ(refusals(sample_soil, {"contacts[7].mu=0.1"}),
            Lines{"--set contacts[7].mu: the list has no item `7`; it has 2, counted from 0"});
  EXPECT_NE(refusals(sample_soil, {"time.end=[2 s]"}).at(0).find("is a list, and one value is needed"),
            std::string::npos);
  // In YAML a list of one entry, 2 s without the sign: a sum of one term where a function of time stands.
  EXPECT_EQ(
      refusals(sample_soil, {"time.end=- 2 s"}),
      Lines{"--set time.end: a dash and a blank begin a list: write -1 m for a negative value, [1 m] for a list"});
  EXPECT_EQ(refusals(sample_soil, {"soil.bed.radius"}),
            Lines{"--set soil.bed.radius: must be path=value, such as soil.bed.radius=\"12 mm\""});
  EXPECT_EQ(refusals(sample_soil, {"title.part=x"}), Lines{"--set title.part: `till` is a value without parts here"});
}

constexpr const char* grain_on_grain = R"(subsoil: 1
materials: {soil: {density: 1800 kg/m^3}}
contacts:
  - {between: [soil, soil], mu: 0.5, LAW}
soil: {bed: {fill: lattice, material: soil, radius: 10 mm, region: {size: 0.1 0.1 0.1 m, at: 0 0 0 m}}}
time: {end: 1 s}
)";

std::string with_law(const std::string& law) {
  std::string text = grain_on_grain;
  return text.replace(text.find("LAW"), 3, law);
}

TEST(ScenarioRead, LawsWithMemory) {
  const auto read = [](const char* law) { return load_scenario_text(with_law(law)).scenario.contacts[0].law; };
  const GivenLaw hscm = read("law: hysteretic, yield strength: 588 kPa, restitution: 0.6, residual overlap: kept");
  EXPECT_EQ(hscm.get_if<dem::Hysteretic>()->yield, 588e3);
  EXPECT_EQ(hscm.get_if<dem::Hysteretic>()->residual, dem::Hysteretic::Residual::kept);
  const GivenLaw luding = read("law: luding, k1: 10 kN/m, k2: 50 kN/m, k_c: 5 kN/m, phi_f: 0.1, damping: 1 N s/m");
  EXPECT_EQ(luding.get_if<dem::Luding>()->k_c, 5e3);
  const GivenLaw eepa = read(
      "law: eepa, n: 1, k1: 10 kN/m^(n), plasticity ratio: 0.6, surface energy: 20 J/m^2, chi: 3, restitution: 0.5, "
      "friction limit: absolute-force");
  EXPECT_EQ(eepa.get_if<dem::Eepa>()->k1, 1e4);
  EXPECT_EQ(eepa.get_if<dem::Eepa>()->limit, dem::AdhesiveLimit::absolute_force);
  const GivenLaw variable = read(
      "law: variable-restitution, normal: linear, k_n: 50 kN/m, E_eff: 10 MPa, S_y: 200 kPa, rho: 1800 kg/m^3, "
      "maximum restitution: 0.95");
  EXPECT_EQ(variable.get_if<dem::VariableRestitution>()->largest, 0.95);
}

TEST(ScenarioRefusals, LawsWithMemory) {
  const auto refused = [](const char* law) { return refusals(with_law(law)); };
  EXPECT_EQ(
      refused("law: hysteretic, restitution: 0.6"),
      Lines{"till.yaml:4:43 contacts[0].law = hysteretic: material `soil` has no yield strength; give it there, or "
            "K1 or yield strength here"});
  EXPECT_EQ(refused("law: hysteretic, K1: 10 kN/m, restitution: 1.2"),
            Lines{"till.yaml:4:81 contacts[0].restitution = 1.2: must be in (0, 1]; for no plastic loss use 1"});
  EXPECT_EQ(refused("law: luding, k1: 50 kN/m, k2: 50 kN/m, k_c: 5 kN/m, phi_f: 0.1, restitution: 1"),
            Lines{"till.yaml:4:5 contacts[0]: k2 must be above k1; for a contact without plasticity take `linear`"});
  EXPECT_EQ(
      refused("law: eepa, plasticity ratio: 0.6, surface energy: 20 J/m^2, restitution: 0.5"),
      Lines{"till.yaml:4:43 contacts[0].law = eepa: material `soil` has no young's modulus and poisson ratio; give "
            "them there, or k1 or E_eff here"});
}

// ---- refusals ------------------------------------------------------------------------------------------------------

TEST(ScenarioRefusals, TheHouseExample) {
  EXPECT_EQ(refusals("subsoil: 1\ntime: {end: 1 s}\nmaterials: {a: {density: 1 kg/m^3}}\ncontacts:\n"
                     "  - between: [a, a]\n    law: linear\n    k_n: 1 kN/m\n    mu: 0.5\n    restitution: 1.3\n"
                     "machine: {bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}\n"),
            Lines{"till.yaml:9:18 contacts[0].restitution = 1.3: must be in (0, 1]; for no damping use 1"});
}

TEST(ScenarioRefusals, CohesionTakesTheQuantitiesOfItsKindOnly) {
  const std::string text =
      "subsoil: 1\ntime: {end: 1 s}\nmaterials: {a: {density: 1 kg/m^3}}\ncontacts:\n"
      "  - {between: [a, a], law: linear, k_n: 1 kN/m, mu: 0.5, restitution: 0.3, cohesion: liquid-bridge,\n"
      "     surface tension: 72 mN/m, contact angle: 20 deg, liquid volume: 1 mm^3}\n"
      "machine: {bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}\n";
  EXPECT_EQ(refusals(text), Lines{});
  const auto linear = *load_scenario_text(text).scenario.contacts[0].law.get_if<dem::Linear>();
  EXPECT_NEAR(linear.cohesion.volume, 1e-9, 1e-24);
  EXPECT_NEAR(linear.cohesion.angle, 20 * 3.14159265358979 / 180, 1e-12);
  EXPECT_EQ(refusals(text, {"contacts[0].cohesion=dmt"}),
            Lines{"till.yaml:5:5 contacts[0]: cohesion: dmt needs `work of adhesion`"});
  EXPECT_EQ(
      refusals(text, {"contacts[0].cohesion=none"}),
      Lines{"till.yaml:5:5 contacts[0]: `surface tension` belongs to cohesion: liquid-bridge, which here is none; "
            "leave it out, or change the word"});
  EXPECT_EQ(refusals(text, {"contacts[0].law=hunt-crosley"}).size(), 1U);
}

TEST(ScenarioRefusals, AllErrorsOfAFileAtOnceInItsOrder) {
  const std::string text =
      "subsoil: 1\n"
      "titel: bad\n"
      "materials:\n"
      "  soil: {density: 1800}\n"
      "contacts:\n"
      "  - {between: [soil, soil], law: linear, k_n: 5 kN, restitution: 1, mu: 0.5}\n"
      "soil:\n"
      "  bed:\n"
      "    fill: latice\n"
      "    material: soil\n"
      "    radius: 10 mm\n"
      "    radius: 12 mm\n"
      "  contaner: {size: 1 1 1 m}\n"
      "time: {end: -1 s}\n";
  EXPECT_EQ(
      refusals(text),
      (Lines{"till.yaml:2:1 titel = bad: unknown key; did you mean `title`?",
             "till.yaml:4:19 materials.soil.density = 1800: has no unit; needed is a density (kg m^-3), such as kg/m^3",
             "till.yaml:6:47 contacts[0].k_n = 5 kN: `kN` is a force (kg m s^-2), but needed is a stiffness (kg s^-2), "
             "such as N/m",
             "till.yaml:9:5 soil.bed.region: is missing; `fill: rest-lattice` needs it",
             "till.yaml:9:11 soil.bed.fill = latice: unknown word; did you mean `lattice`?",
             "till.yaml:12:5 soil.bed.radius: stands twice; first in line 11",
             "till.yaml:13:3 soil.contaner: unknown key; did you mean `container`?",
             "till.yaml:14:13 time.end = -1 s: must be in (0, inf) s"}));
}

TEST(ScenarioRefusals, MissingKeysHaveThePlaceOfTheirMapping) {
  EXPECT_EQ(refusals("subsoil: 1\ntime: {end: 1 s}\nmachine:\n  bodies:\n    a: {inertia: 1 kg m^2, at: 0 0 m}\n"),
            Lines{"till.yaml:5:8 machine.bodies.a.mass: is missing: mass, in kg"});
  EXPECT_EQ(refusals("title: x\nmachine: {bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}\n"),
            (Lines{"till.yaml:1:1 subsoil: is missing: a scenario starts with `subsoil: 1`",
                   "till.yaml:1:1 time.end: is missing: simulated time, in s"}));
  EXPECT_EQ(
      refusals("subsoil: 2\ntime: {end: 1 s}\nmachine: {bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}\n"),
      Lines{"till.yaml:1:10 subsoil = 2: must be in [1, 1]; this program reads format 1"});
  EXPECT_EQ(refusals("subsoil: 1\ntime:\n  end:\nmachine: {bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}\n"),
            Lines{"till.yaml:3:3 time.end: has no value; give one, or leave the key out"});
  EXPECT_EQ(refusals(sample_soil, {"time.end="}),
            Lines{"--set time.end: has no value; give one, or leave the key out"});
}

TEST(ScenarioRefusals, BedsThatNothingBringsToRest) {
  const std::string text =
      "subsoil: 1\n"
      "gravity: 0 m/s^2\n"
      "materials: {soil: {density: 1800 kg/m^3}}\n"
      "contacts: [{between: [soil, soil], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.4}]\n"
      "soil:\n"
      "  container: {size: 100 100 100 mm, at: 0 0 0 m, material: soil}\n"
      "  bed: {fill: random, material: soil, radius: 5 mm, depth: 50 mm}\n"
      "time: {end: 1 s}\n";
  EXPECT_EQ(refusals(text),
            Lines{"till.yaml:7:15 soil.bed.fill = random: pours spheres and lets them come to rest, which "
                  "needs gravity; give `gravity`, or take `fill: lattice`"});
  EXPECT_EQ(refusals(text, {"soil.bed.settle.until=1 mm/s"}),
            Lines{"--set soil.bed.settle: needs gravity to settle in stages; give `stages: no`"});
  EXPECT_EQ(refusals(text, {"gravity=9.81 m/s^2"}), Lines{});
}

/// A laboratory test reads the section `test` and lays its own bed: keys of a scenario's soil are no cure there.
TEST(ScenarioRefusals, UnknownKeysOfATestBelongToTheTest) {
  const auto refused = [](const std::string& key) { return refusals(sample_soil, {"test={" + key + ": 3}"}); };
  EXPECT_EQ(refused("path"), Lines{"--set test.path = 3: unknown key; it belongs at `test.shear.path`"});
  const Lines size = refused("size");
  ASSERT_EQ(size.size(), 1U);
  EXPECT_TRUE(size[0].starts_with("--set test.size = 3: unknown key; known here: material, walls, ")) << size[0];
}

TEST(ScenarioRefusals, ParametersOfAnUnknownLawAreNotReportedOneByOne) {
  EXPECT_EQ(refusals(sample_soil, {"contacts[1].law=wett"}),
            Lines{"--set contacts[1].law = wett: unknown law; did you mean `wet`?"});
}

TEST(ScenarioRefusals, NoYaml) {
  EXPECT_EQ(refusals("subsoil: 1\ntime: [1\n"), Lines{"till.yaml:3:1: no YAML: end of sequence flow not found"});
  EXPECT_EQ(refusals("- 1\n"),
            Lines{"till.yaml: is no scenario; a scenario is a mapping that starts with `subsoil: 1`"});
}

/// One change of a good scenario and the one line that it must give.
struct Change {
  const char *set, *line;
};

TEST(ScenarioRefusals, CrossChecksOfSoil) {
  for (const auto& [set, line] : std::vector<Change>{
           {"contacts[0].between=[soil, sand]",
            "--set contacts[0].between = sand: there is no material of this name; known here: soil, steel"},
           {"boundaries.plate.material=stel",
            "--set boundaries[0].material = stel: there is no material of this name; did you mean `steel`?"},
           {"soil.bed.fill=random", ""},
           {"soil.bed.count=100", "--set soil.bed.count: has no effect with `fill: rest-lattice`; leave it out"},
           {"soil.bed.fill=particles", "till.yaml:20:5 soil.bed.particles: is missing; `fill: particles` needs it"},
           {"soil.bed.radius={uniform: 8 12 mm}",
            "--set soil.bed.radius: a rest-lattice needs spheres of one size; take `fill: random` for a distribution"},
           {"soil.bed.settle={until: 1 m/s, for: 1 s}",
            "--set soil.bed.settle: needs `for` (a time), `until` (a speed) or `to` (a density or a pressure); `for` "
            "and `until` exclude each other"},
           {"soil.container.open=[-x]",
            "till.yaml:17:88 soil.container.open after settling: the face -x is open from the start; take it out of "
            "one of the lists"},
           {"soil.container.size=1 0 1 m", "--set soil.container.size: all lengths must be above zero"},
           {"soil.density=1 kg/m^3",
            "--set soil.density = 1 kg/m^3: unknown key; it belongs at `materials.<name>.density`"},
           {"output.book every=16", "--set output.book every = 16: unknown key; its name is `sample losses every` now"},
           {"output.monitor={f: {formula: 2*v, of: {v: plate.vx}, along: 0 1}}",
            "--set output.monitor.f.along = 0 1: has no effect without `force`, `joint`, `soil force` or `soil "
            "moment`; leave it out"},
           {"contacts[1].mu_d=0.7",
            "--set contacts[1].mu_d = 0.7: must be at most mu = 0.5: friction while slipping does not exceed that at "
            "rest"},
           {"contacts[0].rolling=none",
            "till.yaml:9:54 contacts[0].mu_r = 0.3: has no effect with `rolling: none`; leave one of them out"},
           {"contacts[1]={between: [soil, steel], law: linear, k_n: 1 kN/m, restitution: 0.5, mu: 0.5, k_r: 3 N m/rad}",
            "--set contacts[1].k_r = 3: has no effect without `mu_r`, the limit of rolling; leave it out"},
           {"output.at=[9 s]", "--set output.at = 9 s: is after the end of the run at 4 s"},
           {"output.monitor={f: {soil force: plat}}",
            "--set output.monitor.f = plat: there is no body or boundary of this name; did you mean `plate`?"},
           {"boundaries.plate.moves=[{angular velocity: 0 0 1 rad/s, until: 2 s}, {angular velocity: 0 1 0 rad/s, "
            "from: 1 s}]",
            "--set boundaries[0].moves[1].angular velocity: acts together with that of moves[0] about another axis; "
            "spins at one "
            "time must be parallel: let one end before the other begins"},
           {"boundaries.plate.moves=[{angular velocity: 0 0 1 rad/s, about: 0 0 0 m}, {angular velocity: 0 0 2 rad/s, "
            "about: 1 0 0 m}]",
            "--set boundaries[0].moves[1].about: acts together with that of moves[0] about another point; let one end "
            "before the other begins, or leave one `about` out"},
           {"time.soil step=0 s", "--set time.soil step = 0 s: must be in (0, inf) s"},
           {"boundaries.plate.name=a.b", "--set boundaries[0].name = a.b: a name must not hold . / , [ ] or quotes"}}) {
    const Lines lines = refusals(sample_soil, {set});
    EXPECT_EQ(lines.empty() ? "" : lines.front(), line) << set;
  }
}

/// Of a planar machine the moment about z is wanted.
TEST(ScenarioDefaults, AWatchedMomentIsThatAboutZ) {
  const Scenario s =
      load_scenario_text(sample_soil, "till.yaml",
                         {"output.monitor={f: {soil force: plate}, m: {soil moment: plate}, x: {soil moment: plate, "
                          "along: 1 0}}"})
          .scenario;
  EXPECT_EQ(s.output.watch[0].along, (Vec3{1, 0, 0}));
  EXPECT_EQ(s.output.watch[1].along, (Vec3{0, 0, 1}));
  EXPECT_EQ(s.output.watch[2].along, (Vec3{1, 0, 0}));
  const Scenario copy = load_scenario_text(write_scenario(s), "copy.yaml").scenario;
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(copy.output.watch[i].along, s.output.watch[i].along) << i;
}

TEST(ScenarioRefusals, PairsOfMaterials) {
  EXPECT_EQ(
      refusals(sample_soil, {"contacts[1].between=[soil, soil]"}),
      (Lines{"--set contacts[1].between = [soil, soil]: this pair has a law already, in line 8; keep one of them",
             "till.yaml:8:3 contacts: soil and steel can meet (spheres and the container's walls) but have no law; "
             "add `- between: [soil, steel]`"}));
}

TEST(ScenarioRefusals, CrossChecksOfMachine) {
  for (const auto& [set, line] : std::vector<Change>{
           {"machine.joints.pin={revolute: [sled, arn], at: 0 0 m}",
            "--set machine.joints.pin.revolute = [sled, arn]: there is no body of this name; did you mean `arm`?"},
           {"machine.joints.pin={revolut: [sled, arm], at: 0 0 m}",
            "--set machine.joints.pin = {revolut: [sled, arm], at: 0 0 m}: does not say what it is; did you mean "
            "`revolute`?"},
           {"machine.joints.pin={revolute: [sled, arm]}", "--set machine.joints.pin.at: is missing: the pin, in m"},
           {"machine.joints.pin={revolute: [arm, arm], at: 0 0 m}",
            "--set machine.joints.pin.revolute = [arm, arm]: the two bodies must differ"},
           {"machine.drivers.pull={coordinate: sled.x}",
            "--set machine.drivers.pull: needs exactly one of position, velocity and acceleration as a function of "
            "time; give one, leave the others out"},
           {"machine.drivers.pull={coordinate: sled.z, velocity: 1 m/s}",
            "--set machine.drivers.pull.coordinate = sled.z: must be body.x, body.y or body.angle"},
           {"machine.surfaces.blade.body=arms",
            "--set machine.surfaces.blade.body = arms: there is no body of this name; did you mean `arm`?"},
           {"machine.bodies.arm.angle=90",
            "--set machine.bodies.arm.angle = 90: has no unit; needed is an angle, such as deg or rad"},
           {"machine.forces.pull={force: arm}",
            "--set machine.forces.pull: `pull` is the name of one of machine.drivers too; names in the results must "
            "differ: take another"},
           {"machine.measures={energy: {energy: arm}}",
            "--set machine.measures.energy: `energy` is the name of the energy balance too; names in the results must "
            "differ: take another"},
           {"machine.measures={time: {energy: arm}}",
            "--set machine.measures.time: `time` is the name of the first column too; names in the results must "
            "differ: take another"},
           {"output.monitor={time: {driver: pull}}",
            "--set output.monitor.time: `time` is the name of the first column too; names in the results must differ: "
            "take another"},
           {"machine.forces.rub={joint friction: slid, guide: 0.2 m, mu_s: 0.2, mu_k: 0.1}",
            "--set machine.forces.rub.joint friction = slid: there is no joint of this name; did you mean `slide`?"},
           {"machine.start=rest", "--set machine.start = rest: must be `pose` or {towing equilibrium: 0.5 m/s}"},
           {"gravity=-9.81 m/s^2",
            "--set gravity = -9.81 m/s^2: must not be negative, since one number acts downward (-y); leave out the "
            "sign, or write three numbers"},
           {"output.monitor={p: arn.angle}",
            "--set output.monitor.p = arn.angle: nothing is named `arn`; did you mean `arm`?"},
           {"output.monitor={p: {drivr: pull}}",
            "--set output.monitor.p = {drivr: pull}: does not say what it is; did you mean `driver`?"}}) {
    const Lines lines = refusals(sample_machine, {set});
    EXPECT_EQ(lines.empty() ? "" : lines.front(), line) << set;
  }
}

/// Columns and surfaces of soil and machine: two of one name would be read as each other, or end the run when its
/// frames begin.
TEST(ScenarioRefusals, NamesThatSoilHasAlready) {
  const std::string machine = sample_machine;
  const std::size_t from = machine.find("\nmachine:") + 1, to = machine.find("output:");
  const std::string text = sample_soil + machine.substr(from, to - from);
  const std::string body = "{mass: 1 kg, inertia: 1 kg m^2, at: 0 1 m}";
  const std::string box = "{body: arm, material: steel, box: 20 20 20 mm}";
  const auto refused = [&](const std::string& key, const std::string& value) {
    for (const std::string& line : refusals(text, {"machine.forces.wheel=", key + "=" + value}))
      if (line.find("names in the results must differ") != std::string::npos) return line;
    return std::string();
  };
  for (const char* name : {"container", "soil", "interface", "floor", "wall -x", "plate"}) {
    EXPECT_NE(refused(std::string("machine.bodies.") + name, body), "") << name;
    EXPECT_NE(refused(std::string("machine.surfaces.") + name, box), "") << name;
  }
  for (const char* name : {"arm outline", "machine joints", "machine links", "machine markers"}) {
    EXPECT_NE(refused(std::string("machine.surfaces.") + name, box), "") << name;
    EXPECT_NE(refused("boundaries[0].name", name), "") << name;
  }
  EXPECT_EQ(refused("machine.bodies.bucket", body), "");
  EXPECT_EQ(refused("machine.surfaces.arm", box), "") << "a surface may be called like its body";
  EXPECT_NE(refused("boundaries[0].name", "floor"), "");
  EXPECT_EQ(refused("boundaries[0].name", "lid"), "");
}

TEST(ScenarioRefusals, WheelLawAndParticlesForOneWheel) {
  const std::string machine = sample_machine;
  const std::size_t from = machine.find("\nmachine:") + 1, to = machine.find("output:");
  const std::string text = sample_soil + machine.substr(from, to - from);
  EXPECT_EQ(refusals(text, {"machine.surfaces.blade.touches soil=no"}), Lines{});
  EXPECT_EQ(
      refusals(text),
      Lines{"till.yaml:39:12 machine.forces.wheel: the wheel law carries `arm`, and so would the spheres under its "
            "surface `blade`; leave the law out, or give the surface `touches soil: no`"});
}

TEST(ScenarioRefusals, LaterRefusalsKnowTheirPlace) {
  const Loaded loaded = load_scenario_text(sample_soil, "till.yaml");
  EXPECT_EQ(loaded.where("soil.bed.radius"), "till.yaml:22:13 soil.bed.radius");
  EXPECT_EQ(loaded.where("soil.bed.pitch"), "till.yaml:20:5 soil.bed.pitch");
}

}  // namespace
}  // namespace subsoil::sim::scenario_read_test
