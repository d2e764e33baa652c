#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "libsim/run/input_report.hpp"
#include "libsim/run/overlap_advice.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/scenario/shapes/mesh_file.hpp"
#include "libsim/setup/soil.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Mistakes of a first hour: each is named with its numbers, before anything is computed.
namespace subsoil::sim::mistakes_test {
namespace {

using namespace test;
using subsoil::test::message_of;

constexpr const char* plate = R"(subsoil: 1
materials: {clay: {density: 1800 kg/m^3}}
contacts: [{between: [clay, clay], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.5}]
soil:
  container: {size: 200 200 200 mm, at: 0 0 0 m, material: clay}
  bed: {fill: random, material: clay, radius: 10 mm, count: 300}
boundaries:
  - {name: plate, material: clay, shape: {box: 60 10 60 mm}, at: 100 80 100 mm, moves: [{velocity: 0 -0.2 0 m/s}]}
time: {end: 200 ms}
)";

/// As `check` builds: without settling.
BuildOptions look() {
  BuildOptions options;
  options.threads = 1, options.settle = false;
  return options;
}

/// Read and built as `check` does.
World looked_at(const std::vector<std::string>& sets) {
  const Loaded loaded = load_scenario_text(plate, "plate.yaml", sets);
  return build_world(loaded, look());
}

std::string refusal(const std::vector<std::string>& sets) {
  return message_of<ScenarioError>([&] { looked_at(sets); });
}

/// A bed is poured into the container alone: with its floor open it would fall for as long as it may settle.
TEST(Mistakes, ABedThatSettlesNeedsAFloor) {
  const std::string said = refusal({"soil.container.open=[-y]"});
  EXPECT_NE(said.find("the face -y is open while the bed settles"), std::string::npos) << said;
  EXPECT_NE(said.find("write `open after settling: [-y]`"), std::string::npos) << said;
  EXPECT_NO_THROW(looked_at({"soil.container.open after settling=[-y]"}));
  EXPECT_NO_THROW(looked_at(
      {"soil.container.open=[-y]", "soil.bed={fill: lattice, material: clay, radius: 10 mm}", "boundaries=[]"}));
}

/// A reference without a name has the place of its key, as one to something that is not declared.
TEST(Mistakes, AnEmptyReferenceIsRefusedAtItsKey) {
  for (const char* key : {"soil.container.material", "soil.bed.material", "boundaries[0].material"}) {
    const std::string said = refusal({fmt::format("{}=''", key)});
    EXPECT_NE(said.find(fmt::format("{}: is empty; give the name of a material", key)), std::string::npos) << said;
  }
  const std::string pair = refusal({"contacts[0].between=[clay, '']"});
  EXPECT_NE(pair.find("contacts[0].between"), std::string::npos) << pair;
  EXPECT_NE(pair.find("is empty"), std::string::npos) << pair;
}

/// A column that is not there is refused before the bed settles, which may take minutes.
TEST(Mistakes, AWatchOfNothingIsRefusedBeforeTheBedSettles) {
  const RunDirectory dir;
  const std::string file = dir.scenario(plate);
  EXPECT_NE(
      message_of<ScenarioError>([&] {
        run_scenario(file, dir / "out", {"output.monitor.force={soil force: plat}", "soil.bed.settle.at most=1 us"});
      }).find("did you mean `plate`"),
      std::string::npos)
      << "and not that the bed is not still after 1 us";
}

TEST(Mistakes, ABedIsSavedIntoAFolderThatIsThere) {
  const RunDirectory dir;
  const std::string file = dir / "none/bed.h5";
  EXPECT_NE(refusal({"soil.bed.save=" + file}).find("soil.bed.save = " + file + ": there is no folder"),
            std::string::npos);
  EXPECT_EQ(refusal({"soil.bed.save=" + (dir / "bed.h5").string()}), "accepted");
}

TEST(Mistakes, ARoughFloorLeavesSpheresThatMove) {
  const std::string bed = "soil.bed={fill: lattice, material: clay, radius: 10 mm, pitch: 21 mm, depth: 60 mm, ";
  const std::string gone = "boundaries=[]";
  EXPECT_NE(refusal({gone, bed + "rough floor: 150 mm}"}).find("spheres, so that nothing moves"), std::string::npos);
  EXPECT_EQ(refusal({gone, bed + "rough floor: 12 mm}"}), "accepted");
}

TEST(Mistakes, TooManySpheresAreCountedAndTheUnitIsGuessed) {
  const std::string small = refusal({"soil.bed={fill: random, material: clay, radius: 8 um, depth: 0.1 m}"});
  EXPECT_NE(small.find("spheres of 8e-06 m radius in 0.2 x 0.1 x 0.2 m"), std::string::npos) << small;
  const std::string large = refusal(
      {"soil.container.size=200 200 200 m", "soil.bed={fill: random, material: clay, radius: 10 mm, depth: 0.1 m}"});
  EXPECT_NE(large.find("makes 5.7e+08 spheres"), std::string::npos) << "0.6 x 4000 m^3/4.19e-6 m^3: " << large;
  for (const std::string& message : {small, large})
    EXPECT_NE(message.find("at most 1e+08 spheres: is the unit"), std::string::npos) << message;
  // Of a lattice too; 0.2 x 0.1 x 0.2 m hold 0.6 x 4e-3/2.1e-15 = 1.1e12 of them.
  EXPECT_NE(refusal({"soil.bed={fill: lattice, material: clay, radius: 8 um, depth: 0.1 m}"}).find("makes 1.1e+12"),
            std::string::npos);
}

TEST(Mistakes, ABoreAsWideAsItsCylinder) {
  const std::string message =
      refusal({"boundaries.plate.shape={cylinder: {radius: 50 mm, inner radius: 50 mm, length: 80 mm}}"});
  EXPECT_NE(message.find("shape.cylinder.inner radius: must be below the cylinder's radius"), std::string::npos)
      << message;
}

TEST(Mistakes, MoreSpheresThanTheContainerHolds) {
  // 1e5 spheres of 4.19e-6 m^3 are 0.419 m^3, 52 times the container's 0.008 m^3.
  const std::string message = refusal({"soil.bed.count=100000"});
  EXPECT_NE(message.find("take 0.419 m^3, 52 times what there is"), std::string::npos) << message;
}

TEST(Mistakes, AContainerInMetresForMillimetresIsLookedAtAndWarnedOf) {
  const std::vector<std::string> sets{"soil.container.size=200 200 200 m"};
  const Loaded loaded = load_scenario_text(plate, "plate.yaml", sets);
  const RunDirectory dir;
  const World world = build_world(loaded, look());
  EXPECT_EQ(world.bed->spheres().size(), 300u);
  const auto warnings = input_warnings(loaded, world, dir.scenario(plate), sets);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("is the unit right?"), std::string::npos) << warnings[0];
}

TEST(Mistakes, ADensityThatNoSoilHasIsWarnedOf) {
  const RunDirectory dir;
  const Loaded loaded = load_scenario_text(plate, "plate.yaml", {"materials.clay.density=1.8 kg/m^3"});
  const World world = build_world(loaded, look());
  const auto warnings = input_warnings(loaded, world, dir.scenario(plate), {});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("1.8 g/cm^3 are 1800 kg/m^3"), std::string::npos) << warnings[0];
}

TEST(Mistakes, AWindowBeyondTheEndIsRefused) {
  EXPECT_NE(refusal({"output.window={from: 0.1 s, until: 5 s}"}).find("is after the end of the run at 0.2 s"),
            std::string::npos);
  EXPECT_NE(refusal({"output.window={from: 1 s}"}).find("is not before the end of the run at 0.2 s"),
            std::string::npos);
  EXPECT_EQ(refusal({"output.window={from: 0.1 s, until: 0.2 s}"}), "accepted");
}

TEST(Mistakes, KeysOfOtherProgramsAreTranslated) {
  EXPECT_NE(refusal({"soil.bed.diameter=10 mm"}).find("unknown key; give the `radius`, half of it"), std::string::npos);
  EXPECT_NE(refusal({"boundaries.plate.moves.0.position=1 m"}).find("a move is a `velocity` times a `profile`"),
            std::string::npos);
  EXPECT_NE(refusal({"contacts[0].friction=0.5"}).find("friction is `mu`"), std::string::npos);
}

TEST(Mistakes, LinesThatAreNoYamlSayWhatIsMeant) {
  const auto message = [](const std::string& text) {
    return message_of<ScenarioError>([&] { load_scenario_text(text); });
  };
  EXPECT_NE(message("subsoil: 1\nmaterials:\n\tclay: {density: 1800 kg/m^3}\n").find("indented with a tab"),
            std::string::npos);
  EXPECT_NE(message("subsoil: 1\ntitle: tine: a test\n").find("title: \"tine: a test\""), std::string::npos);
}

// ---- meshes --------------------------------------------------------------------------------------------------------

using Facets = std::vector<std::array<Vec3, 3>>;

/// A box of 60 x 10 x 60 mm, normals outward.
Facets box() {
  const double x = 30, y = 5, z = 30;
  const Vec3 v[] = {{-x, -y, -z}, {x, -y, -z}, {x, y, -z}, {-x, y, -z}, {-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}};
  const int f[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                        {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  Facets out;
  for (const auto& t : f) out.push_back({v[t[0]], v[t[1]], v[t[2]]});
  return out;
}

std::string stl_text(const Facets& facets) {
  std::string text = "solid a\n";
  for (const auto& t : facets) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const Vec3& p : t) text += fmt::format("   vertex {} {} {}\n", p.x, p.y, p.z);
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid a\n";
}

std::string stl_bytes(const Facets& facets) {
  std::string bytes(80, '\0');
  const auto add = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  add(static_cast<std::uint32_t>(facets.size()));
  for (const auto& t : facets) {
    for (int k = 0; k < 3; ++k) add(0.0f);
    for (const Vec3& p : t) add(static_cast<float>(p.x)), add(static_cast<float>(p.y)), add(static_cast<float>(p.z));
    add(std::uint16_t{0});
  }
  return bytes;
}

class Stl : public testing::Test {
 protected:
  std::string file(const std::string& bytes) const {
    write_file(dir_ / "a.stl", bytes);
    return (dir_ / "a.stl").string();
  }
  /// What `check` and `run` warn of when the plate is this mesh.
  std::string warnings(const std::string& bytes, const std::string& unit = "mm") const {
    const std::string set = "boundaries=[{name: plate, material: clay, shape: {mesh: " + file(bytes) +
                            ", unit: " + unit + "}, at: 100 80 100 mm, moves: [{velocity: 0 -0.2 0 m/s}]}]";
    const Loaded loaded = load_scenario_text(plate, "plate.yaml", {set});
    const World world = build_world(loaded, look());
    std::string text;
    for (const std::string& w : surface_warnings(surface_facts(world, loaded.scenario, 0.2), world)) text += w + "\n";
    for (const std::string& w : input_warnings(loaded, world, dir_.scenario(plate), {})) text += w + "\n";
    return text;
  }
  const RunDirectory dir_;
};

TEST_F(Stl, TrianglesWithoutAreaAreDroppedAndCounted) {
  Facets facets = box();
  facets.push_back({facets[0][0], facets[0][0], facets[0][1]});     // two corners at one place
  facets.push_back({Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{2, 0, 0}});  // three on a line
  const MeshFile stl = load_mesh(file(stl_text(facets)), 1e-3);
  EXPECT_EQ(stl.flat, 2u);
  EXPECT_EQ(stl.mesh.triangles().size(), 12u);
  EXPECT_TRUE(stl.mesh.closed());
  EXPECT_NEAR(stl.mesh.volume(), 60e-3 * 10e-3 * 60e-3, 1e-12);
}

TEST_F(Stl, InsideOutAndMixedWindingsAreTurnedAndSaid) {
  Facets facets = box();
  EXPECT_EQ(load_mesh(file(stl_text(facets)), 1e-3).turned, 0u);
  std::swap(facets[3][0], facets[3][1]);
  EXPECT_EQ(load_mesh(file(stl_bytes(facets)), 1e-3).turned, 1u);
  facets = box();
  for (auto& t : facets) std::swap(t[0], t[1]);
  const MeshFile stl = load_mesh(file(stl_bytes(facets)), 1e-3);
  EXPECT_EQ(stl.turned, 12u);
  EXPECT_NEAR(stl.mesh.volume(), 60e-3 * 10e-3 * 60e-3, 1e-11) << "acts outward all the same";
}

TEST_F(Stl, FilesThatAreCutOffAreRefused) {
  const std::string text = stl_text(box()), bytes = stl_bytes(box());
  EXPECT_NE(message_of([&] { load_mesh(file(text.substr(0, text.size() * 2 / 3)), 1e-3); }).find("is cut off"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              load_mesh(file(bytes.substr(0, 400)), 1e-3);
            }).find("declares 12 triangles, which take 684 bytes"),
            std::string::npos);
  EXPECT_NE(message_of([&] { load_mesh(file(std::string("hello, this is no STL file\n")), 1e-3); }).find("no STL file"),
            std::string::npos);
}

TEST_F(Stl, WhatCostsTooMuchOrReachesTooFarIsRefused) {
  const auto refusal = [&](const std::string& bytes) { return message_of([&] { load_mesh(file(bytes), 1e-3); }); };
  // The same triangle 100,000 times: each edge would be compared with each.
  Facets many(100000, box()[0]);
  EXPECT_NE(refusal(stl_bytes(many)).find("100000 triangles meet at the edge from (-0.03, "), std::string::npos);
  std::string bytes = stl_bytes(box());
  bytes.resize(84 + std::size_t{50} * 1000001, '\1');
  const std::uint32_t count = 1000001;
  std::memcpy(bytes.data() + 80, &count, 4);
  EXPECT_NE(refusal(bytes).find("has 1000001 triangles; a mesh may have 1000000"), std::string::npos);
  std::string far = stl_text(box());
  far.replace(far.find("vertex -30"), 10, "vertex 1e200");
  EXPECT_NE(refusal(far).find("face 1 has the vertex 1 at (1e+200, -5, -30), which no metre reaches"),
            std::string::npos)
      << refusal(far);
  // A face of 30,000 corners on three points.
  std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (int i = 0; i < 10000; ++i) corners += " 1 2 3";
  write_file(dir_ / "a.obj", corners + "\n");
  EXPECT_NE(message_of([&] { load_mesh((dir_ / "a.obj").string(), 1); }), "accepted");
}

/// What is no STL file at all hung an earlier reader.
TEST_F(Stl, OtherFilesAreNoMeshes) {
  for (const std::string& bytes : {std::string(400, '4'), std::string("{\"a\": [1, 2, 3]}"), std::string(1000, '\0'),
                                   std::string(84, '\0'), std::string(), "solid " + std::string(400, '9')})
    EXPECT_NE(message_of([&] { load_mesh(file(bytes), 1e-3); }).find("no STL file"), std::string::npos)
        << bytes.substr(0, 20);
  const std::string page = "<html><body>" + std::string(1000, 'x');
  EXPECT_NE(message_of([&] { load_mesh(file(page), 1e-3); }).find("is an HTML or XML file"), std::string::npos);
}

TEST_F(Stl, WhatIsOddAboutAMeshIsWarnedOf) {
  EXPECT_EQ(warnings(stl_text(box())), "");
  Facets facets = box();
  facets.resize(10);
  EXPECT_NE(warnings(stl_text(facets)).find("plate: its mesh is open"), std::string::npos);
  facets = box();
  for (auto& t : facets) std::swap(t[0], t[1]);
  EXPECT_NE(warnings(stl_text(facets)).find("its file is inside out (all 12 normals point inward)"), std::string::npos);
  EXPECT_NE(warnings(stl_text(box()), "um").find("is the unit of its numbers right?"), std::string::npos);
  // In metres the plate swallows the soil: refused, with the guess.
  EXPECT_NE(message_of([&] { warnings(stl_text(box()), "m"); }).find("is the unit of its numbers right?"),
            std::string::npos);
}

// ---- what `check` expects ------------------------------------------------------------------------------------------

TEST(Expected, SpheresOfAPouredBedWithinATwentieth) {
  for (const std::vector<std::string>& sets :
       {std::vector<std::string>{"soil.bed={fill: random, material: clay, radius: 10 mm, depth: 100 mm}"},
        std::vector<std::string>{"soil.bed={fill: random, material: clay, radius: {uniform: 8 12 mm}, depth: 80 mm}"},
        std::vector<std::string>{"soil.bed={fill: random, material: clay, shares: mass, depth: 100 mm, "
                                 "radius: {table: [[5 mm, 30 %], [10 mm, 70 %]]}}"},
        std::vector<std::string>{"soil.bed={fill: random, depth: 100 mm, radius: 8 mm, layers: [{material: clay, "
                                 "thickness: 50 mm, radius: 10 mm}, {material: clay}]}"}}) {
    const Loaded loaded = load_scenario_text(plate, "plate.yaml", sets);

    Loaded without = loaded;
    without.scenario.boundaries.clear();
    const BuildOptions options = look();
    World bed = build_world(without, options);
    const double expected = SoilBuilder(bed, without, options).expected_spheres();
    BuildOptions settled = look();
    settled.settle = true;
    const World made = build_world(without, settled);
    EXPECT_NEAR(expected / static_cast<double>(made.bed->spheres().size()), 1, 0.05) << made.bed->spheres().size();
  }
}

/// The press of a plate by bearing capacity and ten times the mean: p = rho g (33 h + 14.4 w), h = 2 + 1 cm,
/// w = 6 + 2 cm, on (2 r)^2; and the overlap of a linear spring under it.
TEST(Expected, OverlapFollowsFromDepthWidthAndStiffness) {
  const Loaded loaded = load_scenario_text(plate, "plate.yaml", {"gravity=9.81 m/s^2"});
  const World world = build_world(loaded, look());
  const ExpectedOverlap soft = expected_overlap(world, loaded.scenario);
  EXPECT_EQ(soft.tool, "plate");
  const double surface = world.soil.surface_mean, low = 0.080 - 0.005 - 0.2 * 0.2;
  const double depth = surface - low + 0.01, width = 0.06 + 0.02;
  const double p = world.soil.bulk_density * 9.81 * (33 * depth + 0.3 * 48 * width) + world.soil.bulk_density * 0.04;
  EXPECT_NEAR(soft.share, 10 * p * 4e-4 / 10e3 / 0.01, 1e-3 * soft.share);
  // A limit far above it leaves nothing to say; one below names the stiffness that takes half the limit.
  EXPECT_EQ(overlap_text(soft, 1.9).find("k_n"), std::string::npos);
  Loaded strict = loaded;
  strict.scenario.limits.overlap = 0.1;
  const ExpectedOverlap found = expected_overlap(world, strict.scenario);
  const std::string text = overlap_text(found, 0.1);
  EXPECT_NE(text.find("k_n of contacts.clay-clay at least " + fmt::format("{:.3g} kN/m", 10 * soft.share / 0.05)),
            std::string::npos)
      << text;
}

}  // namespace
}  // namespace subsoil::sim::mistakes_test
