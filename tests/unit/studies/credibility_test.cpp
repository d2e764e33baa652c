#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "libdem/laws/wet.hpp"
#include "libsim/setup/world.hpp"
#include "libsim/studies/credibility/verdict.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/scratch.hpp"

/// `subsoil credibility`: each axis changes what it says and nothing else, and verdicts are those of the rule.
namespace subsoil::sim::credibility_test {
namespace {

const Axis& axis(const Axes& axes, const std::string& name) {
  const auto found = std::find_if(axes.axes.begin(), axes.axes.end(), [&](const Axis& a) { return a.name == name; });
  if (found == axes.axes.end()) throw std::runtime_error("no axis " + name);
  return *found;
}

class Changed {
 public:
  Changed() : axes_(credibility_axes(loaded_)) {}
  const Scenario& given() const { return loaded_.scenario; }
  const Axes& axes() const { return axes_; }
  Scenario by(const std::string& name) const {
    return load_scenario_text(test::small_pass, "pass.yaml", axis(axes_, name).sets).scenario;
  }

 private:
  Loaded loaded_ = load_scenario_text(test::small_pass, "pass.yaml");
  Axes axes_;
};

TEST(CredibilityAxes, ChangeWhatTheySay) {
  const Changed c;
  EXPECT_EQ(c.axes().axes.front().sets.size(), 0U);
  const auto step = [](const Scenario& s) {
    return build_world({s, {}}, {.threads = 1, .settle = false}).step.soil_step;
  };
  EXPECT_DOUBLE_EQ(step(c.by("step")), 0.5 * step(c.given()));
  const auto law = [](const Scenario& s, std::size_t k) { return *s.contacts[k].law.get_if<dem::Wet>(); };
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_DOUBLE_EQ(law(c.by("stiffness"), k).K_X, 2 * law(c.given(), k).K_X);
    EXPECT_DOUBLE_EQ(law(c.by("stiffness"), k).K_Y, 2 * law(c.given(), k).K_Y);
    EXPECT_DOUBLE_EQ(law(c.by("stiffness"), k).K_B, law(c.given(), k).K_B) << "attraction as before";
  }
  EXPECT_DOUBLE_EQ(std::get<EqualRadius>(c.by("radius").soil->bed->radius).radius, 0.005);
}

/// Every way in which a law is given its stiffness; what attracts stays, also where it is given as a share of a
/// stiffness.
TEST(CredibilityAxes, StiffnessIsDoubledHoweverItIsGiven) {
  struct Case {
    std::string law;
    std::vector<std::string> sets;  // wanted, of the pair grain-grain
  };
  const Case cases[] = {
      {"law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.5", {"k_n=20000 N/m"}},
      {"law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.5, bond: parallel, bond modulus: 20 MPa, bond tensile "
       "strength: "
       "200 kPa, bond shear strength: 200 kPa",
       {"k_n=20000 N/m", "bond modulus=40000000 Pa"}},
      {"law: hertz-mindlin, E_eff: 3 MPa, G_eff: 1 MPa, restitution: 0.5, mu: 0.5",
       {"E_eff=6000000 Pa", "G_eff=2000000 Pa"}},
      {"law: hertz-mindlin, restitution: 0.5, mu: 0.5", {}},  // from the materials
      {"law: hunt-crossley, n: 1, c: 10 kN/m, b: 0.5 s/m, mu: 0.5", {"c=20000 N/m^(n)"}},
      {"law: eepa, n: 1, k1: 5 kN/m, plasticity ratio: 0.75, adhesive ratio: 0.2, restitution: 0.5, mu: 0.5",
       {"k1=10000 N/m^(n)", "adhesive ratio=0.1"}},
      {"law: luding, k1: 5 kN/m, k2: 20 kN/m, k_c: 1 kN/m, phi_f: 0.05, restitution: 0.5, mu: 0.5",
       {"k1=10000 N/m", "k2=40000 N/m"}},
      {"law: hysteretic, K1: 5 kN/m, K2: 20 kN/m, damping factor: 0.2, mu: 0.5", {"K1=10000 N/m", "K2=40000 N/m"}},
      // K1 = 5 r_eff S_y
      {"law: hysteretic, yield strength: 588 kPa, restitution: 0.6, mu: 0.5", {"yield strength=1176000 Pa"}},
      {"law: hysteretic, restitution: 0.6, mu: 0.5", {"yield strength=200000 Pa"}},  // from the materials
      {"law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.5, mu_r: 0.1, k_r: 0.02 N m/rad",
       {"k_n=20000 N/m", "k_r=0.04 N m/rad"}}};
  for (const Case& c : cases) {
    const std::string text =
        "subsoil: 1\nmaterials: {grain: {density: 2000 kg/m^3, young's modulus: 10 MPa, poisson ratio: 0.3, yield "
        "strength: 100 kPa}}\n"
        "contacts: [{between: [grain, grain], " +
        c.law +
        "}]\nsoil: {container: {size: 0.2 0.2 0.2 m, at: 0 0 0 m, material: grain}, bed: {fill: random, material: "
        "grain, "
        "radius: 10 mm}}\ntime: {end: 1 s}\n";
    const Axes axes = credibility_axes(load_scenario_text(text, "law.yaml"));
    const std::vector<std::string>& sets = axis(axes, "stiffness").sets;
    std::vector<std::string> wanted;
    for (const std::string& set : c.sets) wanted.push_back("contacts.grain-grain." + set);
    wanted.push_back("materials.grain.young's modulus=20000000 Pa");
    EXPECT_EQ(sets, wanted) << c.law;
    EXPECT_NO_THROW(load_scenario_text(text, "law.yaml", sets)) << c.law;
  }
}

/// The tool comes from -x: the near face, the surface and the middle must stay where they are.
TEST(CredibilityAxes, BinGrowsAwayFromTheTool) {
  const Changed c;
  const Container given = *c.given().soil->container, along = *c.by("bin along the travel").soil->container,
                  below = *c.by("bin below").soil->container, across = *c.by("bin across").soil->container;
  EXPECT_DOUBLE_EQ(along.size.x, 2 * given.size.x);
  EXPECT_DOUBLE_EQ(along.at.x, given.at.x);
  EXPECT_DOUBLE_EQ(below.size.y, 2 * given.size.y);
  EXPECT_DOUBLE_EQ(below.at.y + below.size.y, given.at.y + given.size.y);
  EXPECT_DOUBLE_EQ(across.size.z, 2 * given.size.z);
  EXPECT_DOUBLE_EQ(across.at.z + 0.5 * across.size.z, given.at.z + 0.5 * given.size.z);
  EXPECT_DOUBLE_EQ(across.size.x, given.size.x);
}

/// Floor plus depth is where the surface is: a bed that is shallower than its walls are high must not sink away from
/// the tool.
TEST(CredibilityAxes, ADeeperBedKeepsItsSurfaceAndItsRims) {
  const char* beds[] = {"depth: 40 mm",
                        "depth: 40 mm, region: {size: 80 90 80 mm, at: 0 0 0 m}",
                        "",
                        "depth: 40 mm, layers: [{thickness: 10 mm, material: a}, {material: a}]",
                        "layers: [{thickness: 10 mm, material: a}, {thickness: 30 mm, material: a}]",
                        "layers: [{depth: 0 10 mm, material: a}, {depth: 10 40 mm, material: a}]"};
  for (const std::string bed : beds) {
    const bool layered = bed.find("layers") != std::string::npos;
    const std::string text =
        "subsoil: 1\nmaterials: {a: {density: 2500 kg/m^3}}\n"
        "contacts: [{between: [a, a], law: linear, k_n: 5 kN/m, restitution: 0.4, mu: 0.5}]\n"
        "soil: {container: {size: 80 100 80 mm, at: 0 20 0 mm, material: a}, bed: {fill: random, radius: 5 mm" +
        std::string(layered ? "" : ", material: a") + (bed.empty() ? "" : ", " + bed) + "}}\ntime: {end: 1 ms}\n";
    const Loaded given = load_scenario_text(text, "deep.yaml");
    const Loaded deep = load_scenario_text(text, "deep.yaml", axis(credibility_axes(given), "bin below").sets);
    const auto &before = *given.scenario.soil, &after = *deep.scenario.soil;
    const double by = bed.empty() ? 0.1 : 0.04;
    EXPECT_NEAR(before.container->at.y - after.container->at.y, by, 1e-12) << bed;
    EXPECT_NEAR(after.container->size.y - before.container->size.y, by, 1e-12) << bed;
    const auto thickness = [](const BedSection& b) {
      double sum = 0;
      for (const Layer& l : b.layers) sum += l.depth ? (*l.depth)[1] - (*l.depth)[0] : l.thickness.value_or(0);
      return sum;
    };
    if (after.bed->depth) {
      EXPECT_NEAR(*after.bed->depth - *before.bed->depth, by, 1e-12) << bed;
    }
    if (layered && !after.bed->depth) {
      EXPECT_NEAR(thickness(*after.bed) - thickness(*before.bed), by, 1e-12) << bed;
    }
    if (after.bed->region) {
      EXPECT_NEAR(before.bed->region->at.y - after.bed->region->at.y, by, 1e-12) << bed;
    }
  }
}

TEST(CredibilityAxes, ThreePackingsDifferAndWhatIsAbsentIsNamed) {
  const Changed c;
  long seeds[3];
  for (int k = 1; k <= 3; ++k) {
    const Scenario s = c.by("packing " + std::to_string(k));
    seeds[k - 1] = s.soil->bed->seed;
    EXPECT_GT(s.soil->bed->jitter, 0) << "a lattice is one packing";
  }
  EXPECT_TRUE(seeds[0] != seeds[1] && seeds[1] != seeds[2] && seeds[0] != seeds[2]);
  EXPECT_EQ(c.by("coupling step").time.machine.soil_steps, 2);
  EXPECT_EQ(c.by("iterated coupling").time.coupling, CouplingWord::iterated);
  EXPECT_EQ(c.axes().absent.size(), 0U);
}

TEST(CredibilityAxes, AreChosenByTheWordTheyBeginWith) {
  const Changed c;
  Axes some = c.axes();
  keep_axes(some, {"bin", "step"});
  std::vector<std::string> names;
  for (const Axis& a : some.axes) names.push_back(a.name);
  EXPECT_EQ(names, (std::vector<std::string>{"as given", "step", "bin along the travel", "bin below", "bin across"}));
  EXPECT_EQ(some.axes.size() + some.absent.size(), c.axes().axes.size() + c.axes().absent.size());
  const std::string words = test::message_of([&] { keep_axes(some, {"size"}); });
  EXPECT_NE(words.find("size: no axis of this scenario; there are step, bin along"), std::string::npos) << words;
}

TEST(CredibilityAxes, NeedABed) {
  EXPECT_NE(
      test::message_of([] { credibility_axes(load_scenario(test::config("pendulum"))); }).find("soil.bed: is missing"),
      std::string::npos);
}

TEST(CredibilityNumbers, OfAColumnThatTheSeriesHasNotAreRefusedBeforeAnythingRuns) {
  const test::Scratch folder;
  const std::string said = (folder / "said").string(), out = (folder / "out").string();
  const std::string command = subsoil::test::program() + " credibility " + test::config("plate-load") +
                              " --numbers nope --out " + out + " > " + said + " 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_NE(test::text_of(said).find("--numbers = nope: series.csv has no such column"), std::string::npos)
      << test::text_of(said);
  EXPECT_FALSE(std::filesystem::exists(out));
}

PointResult result(double value, double half) {
  PointResult r;
  r.end = PointResult::End::reached;
  r.value = {value}, r.half_width = {half};
  return r;
}

/// Where neither draft nor pull is watched, the means of what is: the last row of a record that swings is no number of
/// the run.
TEST(CredibilityNumbers, AreMeansOfEveryWatchWhereThereIsNoDraft) {
  const Scenario scenario = load_scenario_text(R"(subsoil: 1
machine:
  bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m, velocity: 1 0 m/s}}
time: {end: 1 s}
output: {monitor: {way: b.x, speed: b.vx}}
)")
                                .scenario;
  const std::vector<SweepNumber> numbers = usual_numbers(scenario);
  ASSERT_EQ(numbers.size(), 2U);
  for (const SweepNumber& n : numbers) EXPECT_EQ(n.take, SweepNumber::Take::mean) << n.name;
}

/// 1000 with packings 995, 1000, 1005 (s = 5, Student's t of two degrees of freedom 4.3027): U = 4.3027 sqrt(2) 5/1000.
TEST(CredibilityVerdict, FollowsTheRule) {
  Axes axes;
  for (const char* name : {"as given", "step", "stiffness", "bin across", "radius"})
    axes.axes.push_back({name, "", {}});
  axes.axes[1].refinement = true;
  for (int k = 1; k <= 3; ++k) {
    axes.axes.push_back({"packing " + std::to_string(k), "", {}});
    axes.axes.back().packing = true;
  }
  Study study;
  study.numbers.resize(1);
  study.numbers[0].name = "draft";
  std::vector<PointResult> results{result(1000, 10), result(1006, 10), result(1440, 10), result(1040, 10),
                                   PointResult{}};
  results[4].end = PointResult::End::failed, results[4].cause = "overlap", results[4].value = {std::nan("")};
  results[4].half_width = {std::nan("")};
  for (const double v : {995.0, 1000.0, 1005.0}) results.push_back(result(v, 10));
  const Credibility c = judge(axes, study, results, 0.05);
  ASSERT_EQ(c.verdicts.size(), 4U);
  EXPECT_NEAR(c.packing_scatter[0], 5, 1e-12);
  EXPECT_NEAR(c.verdicts[0].uncertainty, 4.302652729911275 * std::sqrt(2.0) * 0.005, 1e-10);
  EXPECT_EQ(c.verdicts[0].kind, Verdict::Kind::converged);      // 0.6 + 3.04 % within 5 %
  EXPECT_EQ(c.verdicts[1].kind, Verdict::Kind::not_converged);  // 44 - 3.04 % above
  EXPECT_EQ(c.verdicts[2].kind, Verdict::Kind::not_told);       // 4 +- 3.04 %
  EXPECT_EQ(c.verdicts[3].kind, Verdict::Kind::failed);
  const std::string line = credibility_lines(axes, study, c).front();
  EXPECT_NE(line.find("draft 1000, +- 5 packing, +0.6 % step, +44.0 % stiffness"), std::string::npos) << line;
  EXPECT_NE(line.find(": not converged in stiffness, inconclusive in bin across"), std::string::npos) << line;
  EXPECT_NE(line.find("grid convergence index: step 1.8 %"), std::string::npos) << line;
  // A random bed as given is a packing like the others: 1000 as well, three degrees of freedom.
  axes.base_is_packing = true;
  EXPECT_NEAR(judge(axes, study, results, 0.05).verdicts[0].uncertainty,
              3.182446305284263 * std::sqrt(2.0) * std::sqrt(50.0 / 3) / 1000, 1e-10);
  // Without packings the records' own intervals: sqrt(10^2 + 10^2)/1000.
  results.resize(5), axes.axes.resize(5), axes.base_is_packing = false;
  EXPECT_NEAR(judge(axes, study, results, 0.05).verdicts[0].uncertainty, std::sqrt(200.0) / 1000, 1e-12);
}

/// Where nothing ran nothing is converged, and what a run warned of is said once.
TEST(CredibilityVerdict, TellsOfFailuresAndWarnings) {
  Axes axes;
  for (const char* name : {"as given", "step", "bin below"}) axes.axes.push_back({name, "", {}});
  Study study;
  study.numbers.resize(1);
  study.numbers[0].name = "draft";
  std::vector<PointResult> results{result(1000, 10), result(1006, 10), result(1440, 10)};
  results[1].warnings = {"blade touched no soil", "few steps"}, results[2].warnings = {"blade touched no soil"};
  std::vector<std::string> lines = credibility_lines(axes, study, judge(axes, study, results, 0.05));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[1], "warning of step, bin below: blade touched no soil");
  EXPECT_EQ(lines[2], "warning of step: few steps");
  for (std::size_t k : {1U, 2U}) results[k] = PointResult{}, results[k].value = {std::nan("")};
  lines = credibility_lines(axes, study, judge(axes, study, results, 0.05));
  EXPECT_EQ(lines[0].find("converged"), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find("not judged"), std::string::npos) << lines[0];
}

}  // namespace
}  // namespace subsoil::sim::credibility_test
