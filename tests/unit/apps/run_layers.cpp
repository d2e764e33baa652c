#include <set>

#include "libdem/laws/hysteretic.hpp"
#include "libdem/laws/jkr.hpp"
#include "libdem/laws/linear.hpp"
#include "libdem/laws/variable_restitution.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Layered beds of every fill, and laws of pairs that follow from their materials.
namespace subsoil::sim::run_layers {
namespace {

using namespace test;

/// Loose over dense; `BED` is the rest of the bed.
constexpr const char* profile = R"(subsoil: 1
materials:
  top: {density: 1200 kg/m^3, restitution: 0.9, mu: 0.4, mu_r: 0.02, yield strength: 300 kPa, work of adhesion: 1 J/m^2}
  pan: {density: 1800 kg/m^3, restitution: 0.4, mu: 0.9, mu_r: 0.08, yield strength: 200 kPa, work of adhesion: 4 J/m^2}
  steel: {density: 7850 kg/m^3}
contacts:
  - &dry {between: [top, top], law: linear, k_n: 50 kN/m, restitution: 0.5, mu: 0.5}
  - {<<: *dry, between: [top, pan]}
  - {<<: *dry, between: [pan, pan]}
  - {<<: *dry, between: [top, steel]}
  - {<<: *dry, between: [pan, steel]}
soil:
  container: {size: 0.1 0.3 0.1 m, at: 0 0 0 m, material: steel}
  bed: {BED}
time: {end: 1 ms}
)";

struct Layered : testing::Test {
  RunDirectory dir;
  std::string text(const std::string& bed) const {
    std::string all = profile;
    return all.replace(all.find("BED"), 3, bed);
  }
  World world(const std::string& bed, bool settle = true) const {
    return build_world(load_scenario(dir.scenario(text(bed)), {}),
                       {.threads = 1, .settle = settle, .restored = {}, .progress = {}});
  }
  std::string refusal(const std::string& bed) const {
    return message_of<std::exception>([&] { world(bed); });
  }
};

constexpr const char* two = "layers: [{thickness: 40 mm, material: top}, {thickness: 60 mm, material: pan}]";

/// Spheres of the pan lie below 60 mm, those of the topsoil above, with their materials' densities. @param step how far
/// a row may lie off, m
void expect_profile(const World& w, double step) {
  std::set<int> materials;
  ASSERT_GT(w.bed->spheres().size(), 10U);
  for (const dem::Sphere& s : w.bed->spheres()) {
    materials.insert(s.material);
    EXPECT_NEAR(dem::density(s), s.material == 0 ? 1200 : 1800, 1e-9);
    if (s.material == 0) {
      EXPECT_GT(s.x.y, 0.06 - step);
    }
    if (s.material == 1) {
      EXPECT_LT(s.x.y, 0.06 + step);
    }
  }
  EXPECT_EQ(materials, (std::set<int>{0, 1}));
}

TEST_F(Layered, ByEveryFill) {
  const std::string layers = std::string(", ") + two;
  expect_profile(world("fill: lattice, radius: 8 mm" + layers), 0.009);
  expect_profile(world("fill: rest-lattice, radius: 8 mm" + layers), 0.009);
  // Rained and levelled: a sphere of the upper layer may lie in a hollow of the lower one, a diameter deep.
  const World rained = world("fill: random, radius: 8 mm, settle: {until: 20 mm/s}" + layers);
  expect_profile(rained, 0.016);
  ASSERT_EQ(rained.soil.layers.size(), 2U);
  EXPECT_EQ(rained.soil.layers[0].first, "top");
  EXPECT_NEAR(rained.soil.layers[1].second.thickness, 0.06, 0.004);
  EXPECT_NEAR(rained.soil.layers[0].second.top, 0.1, 0.002);
}

/// As `check` sees it: the spheres that stand for the rain are of the layers' materials, so that the step is of all
/// laws.
TEST_F(Layered, RainIsLookedAtByAStandIn) {
  expect_profile(world(std::string("fill: random, radius: 8 mm, ") + two, false), 0.009);
}

TEST_F(Layered, ThicknessOrDepthAndTheRestForTheLowest) {
  const std::string fill = "fill: rest-lattice, radius: 8 mm, ";
  for (const char* layers : {"layers: [{depth: 0 40 mm, material: top}, {depth: 40 100 mm, material: pan}]",
                             "depth: 100 mm, layers: [{depth: 0 40 mm, material: top}, {material: pan}]",
                             "region: {size: 0.1 0.1 0.1 m, at: 0 0 0 m}, layers: [{thickness: 40 mm, material: top}, "
                             "{material: pan}]"})
    expect_profile(world(fill + layers), 0.009);
}

TEST_F(Layered, OwnRadiiAndTheBedsForTheOthers) {
  const World w = world(
      "fill: lattice, radius: 8 mm, layers: [{thickness: 40 mm, material: top, radius: 5 mm}, "
      "{thickness: 60 mm, material: pan}]");
  for (const dem::Sphere& s : w.bed->spheres()) EXPECT_DOUBLE_EQ(s.r, s.material == 0 ? 0.005 : 0.008);
  expect_profile(w, 0.009);
}

/// A column of eight spheres of 12.5 mm that ends at 100 mm.
constexpr const char* column =
    "x [mm],y [mm],z [mm],radius [mm]\n50,6.25,50,6.25\n50,18.75,50,6.25\n50,31.25,50,6.25\n50,43.75,50,6.25\n"
    "50,56.25,50,6.25\n50,68.75,50,6.25\n50,81.25,50,6.25\n50,93.75,50,6.25\n";

TEST_F(Layered, SpheresOfAFileByDepth) {
  write_file(dir / "bed.csv", column);
  const std::string file = "fill: file, file: bed.csv, ";
  EXPECT_NE(refusal(file + "radius: 8 mm, " + two).find("has no effect with `fill: file`"), std::string::npos);
  const World w = world(file + two);
  ASSERT_EQ(w.bed->spheres().size(), 8U);
  for (const dem::Sphere& s : w.bed->spheres()) EXPECT_EQ(s.material, s.x.y > 0.06 ? 0 : 1) << s.x.y;
  const std::string shallow =
      refusal(file + "layers: [{thickness: 40 mm, material: top}, {thickness: 30 mm, material: pan}]");
  EXPECT_NE(shallow.find("soil.bed.layers: are 70 mm deep together, the spheres lie down to 100 mm"), std::string::npos)
      << shallow;
}

/// Listed spheres: those that say nothing take the layer's material and density, a stone keeps its own.
TEST_F(Layered, ListedSpheresKeepWhatTheySay) {
  const World w = world(
      "fill: particles, layers: [{thickness: 40 mm, material: top}, {material: pan}], particles: ["
      "{position: 50 90 50 mm, radius: 10 mm}, {position: 50 70 50 mm, radius: 10 mm, material: pan}, "
      "{position: 50 50 50 mm, radius: 10 mm}, {position: 50 30 50 mm, radius: 10 mm, density: 2000 kg/m^3}]");
  ASSERT_EQ(w.bed->spheres().size(), 4U);
  for (const dem::Sphere& s : w.bed->spheres()) {
    EXPECT_EQ(s.material, s.id == 0 ? 0 : 1) << s.id;
    EXPECT_NEAR(dem::density(s), s.id == 0 ? 1200 : s.id == 3 ? 2000 : 1800, 1e-9) << s.id;
  }
}

TEST_F(Layered, RefusalsNamePlaceRuleAndCure) {
  const auto expect = [&](const std::string& bed, const std::string& part) {
    EXPECT_NE(refusal(bed).find(part), std::string::npos) << refusal(bed);
  };
  const std::string fill = "fill: rest-lattice, radius: 8 mm, ";
  expect(fill + "depth: 90 mm, " + two, "soil.bed.depth: the layers are 100 mm deep together, not 90 mm");
  expect(fill + "material: top, " + two, "soil.bed.material: stands beside `layers`");
  expect("fill: random, radius: 8 mm, count: 10, " + std::string(two), "soil.bed.count: stands beside `layers`");
  expect(fill + "layers: [{thickness: 40 mm, material: top}, {thickness: 300 mm, material: pan}]",
         "soil.bed.layers: are 340 mm deep together, the region holds 300 mm");
  expect(fill + "layers: [{thickness: 10 mm, material: top}, {material: pan}]",
         "soil.bed.layers[0]: is 10 mm thick, less than its largest sphere's diameter 16 mm");
  expect(fill + "layers: [{material: top}, {thickness: 40 mm, material: pan}]",
         "soil.bed.layers[0]: needs `thickness` or `depth`");
  expect(fill + "layers: [{depth: 0 40 mm, material: top}, {depth: 50 90 mm, material: pan}]",
         "soil.bed.layers[1].depth: must begin where the layer above ends, at 40 mm");
  expect(fill + "layers: [{thickness: 40 mm, material: topp}, {material: pan}]", "did you mean `top`");
  expect("fill: rest-lattice, layers: [{thickness: 40 mm, material: top, radius: 8 mm}, {material: pan}]",
         "soil.bed.radius: is missing");
  // Layers that do not touch now may be mixed by a tool: every pair needs a law.
  expect(fill + "layers: [{thickness: 40 mm, material: top}, {thickness: 40 mm, material: pan}, {material: steel}]",
         "steel and steel can meet (spheres with each other) but have no law; add `- between: [steel, steel]`");
}

// ---- laws from materials ----

/// The law of the pair top, pan when its entry says this.
dem::Law pair_law(const Layered& t, const std::string& entry) {
  std::string all = t.text("fill: rest-lattice, radius: 8 mm, " + std::string(two));
  const std::string old = "{<<: *dry, between: [top, pan]}";
  all.replace(all.find(old), old.size(), "{between: [top, pan], " + entry + "}");
  const dem::LawTable table = build_laws(load_scenario(t.dir.scenario(all), {}));
  return table.laws[static_cast<std::size_t>(table.of(0, 1))];
}

/// Each rule by its textbook formula, of 0.4 and 0.9 or of the values above.
TEST_F(Layered, PairsCombineByTheRuleThatTheyName) {
  const std::pair<const char*, double> rules[] = {{"arithmetic-mean", 0.65},
                                                  {"geometric-mean", 0.6},
                                                  {"harmonic-mean", 2 / (1 / 0.4 + 1 / 0.9)},
                                                  {"minimum", 0.4},
                                                  {"maximum", 0.9}};
  for (const auto& [rule, value] : rules) {
    const auto law = *pair_law(*this, std::string("law: linear, k_n: 1 kN/m, combine: {restitution: ") + rule +
                                          ", mu: " + rule + "}")
                          .get_if<dem::Linear>();
    EXPECT_DOUBLE_EQ(law.restitution, value) << rule;
    EXPECT_DOUBLE_EQ(law.friction.mu, value) << rule;
    EXPECT_EQ(law.friction.mu_r, 0);
  }
  const auto jkr =
      *pair_law(*this,
                "law: jkr, E_eff: 5 MPa, G_eff: 2 MPa, restitution: 0.5, combine: {mu: minimum, mu_r: geometric-mean, "
                "work of adhesion: geometric-mean}")
           .get_if<dem::Jkr>();
  EXPECT_DOUBLE_EQ(jkr.work, 2);
  EXPECT_DOUBLE_EQ(jkr.friction.mu_r, 0.04);
}

TEST_F(Layered, CombinationsThatCannotBeAreRefused) {
  const auto expect = [&](const std::string& entry, const std::string& part) {
    const std::string said = message_of<std::exception>([&] { pair_law(*this, entry); });
    EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  const std::string linear = "law: linear, k_n: 1 kN/m, ";
  expect(linear + "restitution: 0.5", "contacts[1].mu: is missing");
  expect(linear + "restitution: 0.5, combine: {mu: mean}", "contacts[1].combine.mu = mean: unknown rule");
  expect(linear + "restitution: 0.5, combine: {mu: minimum, k_n: minimum}",
         "contacts[1].combine.k_n = minimum: no value that can be combined");
  expect(linear + "restitution: 0.5, mu: 0.5, combine: {mu: minimum}",
         "contacts[1].combine.mu = minimum: `mu` stands in this entry too; keep the value or the rule");
  expect(linear + "restitution: 0.5, combine: {mu: minimum, mu_t: minimum}",
         "contacts[1].combine.mu_t = minimum: material `top` has no mu_t; give it there, or the pair's mu_t here");
  expect(
      "law: wet, K_X: 10 kN/m, C_X: 5 N s/m, K_Y: 8 kN/m, C_Y: 3 N s/m, K_B: 7 kN/m, dc: 2 mm, dB: 2 mm, "
      "combine: {mu: minimum, restitution: minimum}",
      "contacts[1].combine.restitution: the law has no such value; leave it out");
}

/// The explicit copy holds the numbers with their rule beside them, and reads as the same laws.
TEST_F(Layered, ExplicitCopyHoldsWhatCameOut) {
  std::string all = text("fill: rest-lattice, radius: 8 mm, " + std::string(two));
  const std::string old = "{<<: *dry, between: [top, pan]}";
  all.replace(all.find(old), old.size(),
              "{between: [top, pan], law: linear, k_n: 1 kN/m, restitution: 0.5, combine: {mu: geometric-mean}}");
  const std::string copy = write_scenario(load_scenario(dir.scenario(all), {}).scenario);
  EXPECT_NE(copy.find("geometric-mean of the two materials'"), std::string::npos) << copy;
  EXPECT_EQ(copy.find("combine"), std::string::npos);
  const Loaded again = load_scenario(dir.scenario(copy), {});
  EXPECT_DOUBLE_EQ(again.scenario.contacts[1].law.get_if<dem::Linear>()->friction.mu, 0.6);
  EXPECT_EQ(again.scenario.soil->bed->layers.size(), 2U);
}

/// The body of less strength yields: K1 = 5 r_eff S_y with the smaller one.
TEST_F(Layered, SofterMaterialYields) {
  EXPECT_EQ(pair_law(*this, "law: hysteretic, restitution: 0.5, mu: 0.5").get_if<dem::Hysteretic>()->yield, 200e3);
  const auto variable = *pair_law(*this, "law: variable-restitution, E_eff: 10 MPa, rho: 1800 kg/m^3, mu: 0.5")
                             .get_if<dem::VariableRestitution>();
  EXPECT_EQ(variable.map.S_y, 200e3);
  EXPECT_EQ(pair_law(*this, "law: hysteretic, yield strength: 50 kPa, restitution: 0.5, mu: 0.5")
                .get_if<dem::Hysteretic>()
                ->yield,
            50e3);
  const std::string said =
      message_of<std::exception>([&] { pair_law(*this, "law: hysteretic, restitution: 0.5, K2: 5 kN/m, mu: 0.5"); });
  EXPECT_NE(said.find("either the restitution or K2"), std::string::npos) << said;
}

}  // namespace
}  // namespace subsoil::sim::run_layers
