#include "libsim/run/input_report.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Beds that are read from a file: what the bed becomes, and what is refused with its place.
namespace subsoil::sim::run_bed_file {
namespace {

using namespace test;

constexpr const char* from_table = R"(subsoil: 1
materials:
  soil: {density: 1800 kg/m^3}
  stone: {density: 2600 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.5}
  - {<<: *dry, between: [soil, stone]}
  - {<<: *dry, between: [stone, stone]}
  - {<<: *dry, between: [soil, steel]}
  - {<<: *dry, between: [stone, steel]}
soil:
  container: {size: 1 1 1 m, at: 0 0 0 m, material: steel}
  bed: {fill: file, material: soil, file: bed.csv}
time: {end: 1 ms}
)";

struct FromTable : testing::Test {
  RunDirectory dir;
  void table(const std::string& text) const { write_file(dir / "bed.csv", text); }
  World world(const std::vector<std::string>& sets = {}) const {
    return build_world(load_scenario(dir.scenario(from_table), sets), {.threads = 1, .restored = {}, .progress = {}});
  }
  std::string warnings_with(const std::vector<std::string>& sets) const {
    const Loaded loaded = load_scenario(dir.scenario(from_table), sets);
    const World w = build_world(loaded, {.threads = 1, .restored = {}, .progress = {}});
    std::string all;
    for (const std::string& text : input_warnings(loaded, w, dir.scenario(from_table), sets)) all += text + "\n";
    return all;
  }
  std::string refusal() const {
    return message_of<std::exception>([&] { world(); });
  }
};

/// Ids decide the order, whatever the lines'; units are any of the dimension; what is left out comes from the scenario.
TEST_F(FromTable, SpheresAreTheTables) {
  table(
      "id,x [mm],y [m],z [cm],radius [mm],material,vx [km/h],density [g/cm^3]\n"
      "9,250,0.5,50,20,stone,3.6,\n"
      "4,750,0.5,50,10,,,1.2\n");
  const World w = world();
  ASSERT_EQ(w.bed->spheres().size(), 2U);
  const dem::Sphere &soil = w.bed->spheres()[0].id == 0 ? w.bed->spheres()[0] : w.bed->spheres()[1],
                    &stone = w.bed->spheres()[0].id == 0 ? w.bed->spheres()[1] : w.bed->spheres()[0];
  EXPECT_EQ(stone.id, 1U);
  EXPECT_NEAR(dem::norm(soil.x - dem::Vec3{0.75, 0.5, 0.5}), 0, 1e-15);
  EXPECT_NEAR(dem::norm(stone.x - dem::Vec3{0.25, 0.5, 0.5}), 0, 1e-15);
  EXPECT_DOUBLE_EQ(soil.r, 0.01);
  EXPECT_DOUBLE_EQ(stone.v.x, 1);
  EXPECT_NEAR(dem::density(soil), 1200, 1e-9);
  EXPECT_NEAR(dem::density(stone), 2600, 1e-9);
}

/// Spreadsheets put a byte order mark before a CSV's first line.
TEST_F(FromTable, AByteOrderMarkIsLeftOut) {
  table("\xEF\xBB\xBFx [m],y [m],z [m],radius [m]\r\n0.2,0.1,0.5,0.01\r\n");
  const World w = world();
  ASSERT_EQ(w.bed->spheres().size(), 1U);
  EXPECT_DOUBLE_EQ(w.bed->spheres()[0].x.x, 0.2);
}

TEST_F(FromTable, ASavedBedKeepsItsNumbersAndEveryBit) {
  table("x [m],y [m],z [m],radius [m]\n0.2,0.1,0.5,0.01\n0.8,0.3,0.5,0.02\n0.5,0.2,0.5,0.01\n");
  const std::string kept = (dir / "kept.h5").string();
  const World first = world({"soil.bed.save=" + kept}), second = world({"soil.bed.file=" + kept});
  ASSERT_EQ(second.bed->spheres().size(), 3U);
  for (const dem::Sphere& a : first.bed->spheres())
    for (const dem::Sphere& b : second.bed->spheres())
      if (a.id == b.id) {
        EXPECT_EQ(a.x, b.x);
        EXPECT_EQ(a.r, b.r);
      }
}

/// A bed that moved to a datum with its box is kept where it lay in the box as given: taken up again with the same
/// datum it lies on the floor at the same height, and does not hang above it by the shift.
TEST_F(FromTable, ABedMovedToADatumIsKeptWhereItLayInItsBox) {
  table("x [m],y [m],z [m],radius [m]\n0.2,0.01,0.5,0.01\n0.8,0.02,0.5,0.02\n");
  const std::string kept = (dir / "kept.h5").string();
  const World first = world({"soil.surface=0.5 m", "soil.bed.save=" + kept});
  const World second = world({"soil.surface=0.5 m", "soil.bed.file=" + kept});
  ASSERT_NE(first.container_shift, 0.0);
  EXPECT_EQ(second.container_shift, first.container_shift);
  for (const World* w : {&first, &second})
    for (const dem::Sphere& s : w->bed->spheres())
      EXPECT_NEAR(s.x.y - s.r, w->container_shift, 1e-15) << "on the floor, which is shifted from y = 0";
}

/// A saved bed keeps its datum: a scenario that names none has bed and box where the run had them that saved it.
TEST_F(FromTable, ASavedBedKeepsItsDatum) {
  table("x [m],y [m],z [m],radius [m]\n0.2,0.01,0.5,0.01\n0.8,0.02,0.5,0.02\n");
  for (const char* name : {"kept.h5", "kept.csv"}) {
    const std::string kept = (dir / name).string();
    const World first = world({"soil.surface=0.5 m", "soil.bed.save=" + kept});
    const World second = world({"soil.bed.file=" + kept}),
                third = world({"soil.bed.file=" + kept, "soil.surface=0.1 m"});
    EXPECT_EQ(second.container_shift, first.container_shift) << name;
    EXPECT_EQ(second.soil.surface_mean, 0.5) << name;
    EXPECT_EQ(third.soil.surface_mean, 0.1) << name << ": the scenario's datum comes before the file's";
  }
}

TEST_F(FromTable, AMaterialThatNoSphereTakesIsRefused) {
  table("x [m],y [m],z [m],radius [m],material\n0.2,0.1,0.5,0.01,stone\n");
  EXPECT_NE(refusal().find(":14:31 soil.bed.material = soil: is the material of no sphere in"), std::string::npos)
      << refusal();
  EXPECT_NE(refusal().find("which names stone"), std::string::npos) << refusal();
  table("x [m],y [m],z [m],radius [m],material\n0.2,0.1,0.5,0.01,stone\n0.8,0.1,0.5,0.01,\n");
  EXPECT_EQ(world().bed->spheres().size(), 2U);
}

TEST_F(FromTable, SpheresAtOnePlaceAreNamed) {
  table("id,x [m],y [m],z [m],radius [m]\n7,0.2,0.1,0.5,0.01\n3,0.8,0.3,0.5,0.02\n12,0.2,0.1,0.5,0.03\n");
  EXPECT_NE(refusal().find("spheres 7 and 12 have the same centre (0.2, 0.1, 0.5) m"), std::string::npos) << refusal();
}

TEST_F(FromTable, ATableWithAnotherSeparatorIsNamed) {
  table("x [m];y [m];z [m];radius [m]\n0,2;0,1;0,5;0,01\n");
  EXPECT_NE(refusal().find("bed.csv:1: has its fields separated by `;`: must be `,`"), std::string::npos) << refusal();
  table("x [m]\ty [m]\tz [m]\tradius [m]\n0.2\t0.1\t0.5\t0.01\n");
  EXPECT_NE(refusal().find("separated by tabs"), std::string::npos) << refusal();
}

TEST_F(FromTable, ABedThatHangsAboveItsFloorIsWarnedOf) {
  const auto warnings = [&](const std::string& height) {
    table("x [m],y [m],z [m],radius [m]\n0.2," + height + ",0.5,0.01\n");
    return warnings_with({});
  };
  EXPECT_NE(warnings("0.06").find("hangs 50 mm above the container's floor"), std::string::npos) << warnings("0.06");
  EXPECT_EQ(warnings("0.0199").find("hangs"), std::string::npos);
}

TEST_F(FromTable, DensitiesBesideThoseOfTheMaterialsAreWarnedOf) {
  table(
      "x [m],y [m],z [m],radius [m],material\n"
      "0.2,0.02,0.5,0.02,soil\n"
      "0.8,0.02,0.5,0.02,stone\n"
      "0.5,0.02,0.5,0.02,soil\n");
  const std::string kept = (dir / "kept.h5").string(), from = "soil.bed.file=" + kept;
  world({"soil.bed.save=" + kept});
  const std::string sign = "of the file, not";
  EXPECT_EQ(warnings_with({from}).find(sign), std::string::npos);
  const std::string heavier = "materials.soil.density=2000 kg/m^3", said = warnings_with({from, heavier});
  EXPECT_NE(said.find(": 2 spheres of `soil` have the 1800 kg/m^3 of the file, not the 2000 kg/m^3 of `materials.soil"),
            std::string::npos)
      << said;
  EXPECT_EQ(said.find("stone"), std::string::npos) << said;
  EXPECT_NEAR(dem::density(world({from, heavier}).bed->spheres()[0]), 1800, 1e-9) << "as it says";
  EXPECT_EQ(warnings_with({heavier}).find(sign), std::string::npos) << "the table leaves densities to the materials";
}

TEST_F(FromTable, RefusalsNameScenarioFileAndCure) {
  const auto expect = [&](const std::string& text, const std::vector<std::string>& parts) {
    table(text);
    for (const std::string& part : parts) EXPECT_NE(refusal().find(part), std::string::npos) << refusal();
  };
  EXPECT_NE(refusal().find("there is no file"), std::string::npos) << refusal();
  expect("x [m],y [m],z [m],radius [kg]\n0,0,0,1\n", {"case.yaml:", "bed.csv:1", "radius"});
  expect("x [m],y [m],z [m],radius [m]\n", {"bed.csv", "holds no sphere"});
  expect("x [m],y [m],z [m],radius [m],material\n0.5,0.5,0.5,0.01,mud\n",
         {"case.yaml:", "sphere 1", "'mud'", "it has soil, stone, steel"});
  expect("x [m],y [m],z [m],radius [m],material\n0.5,0.5,0.5,0.01,steel\n0.2,0.5,0.5,0.01,soil\n",
         {"case.yaml:", "spheres of steel can meet steel", "add `- between: [steel, steel]`"});
}

/// One sphere of its material meets no other of it: the pair needs no law. With two it does.
TEST(LoneSphere, NeedsNoLawWithItself) {
  const RunDirectory dir;
  const std::string scenario = R"(subsoil: 1
materials: {ball: {density: 2500 kg/m^3}, floor: {density: 2500 kg/m^3}}
contacts: [{between: [ball, floor], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.5}]
soil: {bed: {fill: particles, material: ball, particles: [{position: 0 11 0 mm, radius: 10 mm}]}}
boundaries: [{name: floor, material: floor, shape: {plane: {}}}]
time: {end: 50 ms}
output: {state: none}
)";
  ASSERT_EQ(run_scenario(dir.scenario(scenario), dir / "one"), exit_ok);
  // Down by 1 mm and bounced off: it has lost energy, and none of it to a law that is not there.
  const Series series = read_series(dir / "one/series.csv");
  EXPECT_GT(series.at("soil.damped").back(), 0.0);
  std::string two = scenario;
  const std::string ball = "{position: 0 11 0 mm, radius: 10 mm}";
  two.replace(two.find(ball), ball.size(), ball + ", {position: 50 11 0 mm, radius: 10 mm}");
  EXPECT_NE(message_of<std::exception>([&] {
              load_scenario(dir.scenario(two), {});
            }).find("ball and ball can meet (spheres with each other) but have no law"),
            std::string::npos);
}

/// Before the bed settles, not after.
TEST(BedFile, APathThatCannotBeWrittenIsRefused) {
  const RunDirectory dir;
  std::filesystem::create_directories(dir / "taken");
  const std::string text = dir.scenario(small_pass);
  const std::string said = message_of<ScenarioError>(
      [&] { run_scenario(text, dir / "out", {"soil.bed.save=" + (dir / "taken").string()}); });
  EXPECT_NE(said.find("soil.bed.save = "), std::string::npos) << said;
  EXPECT_NE(said.find(": cannot be written there; name a file in a folder that may be written to"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(dir / "taken"));
  EXPECT_FALSE(std::filesystem::exists(dir / "taken.part"));
}

}  // namespace
}  // namespace subsoil::sim::run_bed_file
