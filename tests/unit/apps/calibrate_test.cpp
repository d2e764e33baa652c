#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "libsim/studies/calibrate/calibration.hpp"
#include "libsim/studies/calibrate/surrogate.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

/// `subsoil calibrate`: the surrogate against functions that are known, the search against a known minimum, and the
/// whole against a material that is known.
namespace subsoil::sim::calibrate_test {
namespace {

using subsoil::test::message_of;

/// So many points of a two-dimensional grid and f at them.
template <class F>
Surrogate surrogate_of(int side, F f, double noise = 0) {
  Eigen::MatrixXd points(side * side, 2);
  Eigen::VectorXd values(side * side);
  for (int i = 0; i < side * side; ++i) {
    points.row(i) << (i % side) / (side - 1.0), (i / side) / (side - 1.0);
    values[i] = f(points(i, 0), points(i, 1));
  }
  return {points, values, noise};
}

TEST(Surrogate, IsExactForALinearFunction) {
  const Surrogate s = surrogate_of(3, [](double x, double y) { return 7 + 2 * x - 5 * y; });
  // The trend holds it; what is left is the nugget of 1e-8 of the variance.
  EXPECT_NEAR(s.value(Eigen::Vector2d(0.3, 0.9)), 7 + 0.6 - 4.5, 1e-5);
}

TEST(Surrogate, FollowsASmoothFunctionAndKnowsHowWell) {
  const auto f = [](double x, double y) { return std::sin(3 * x) * (1 + y * y); };
  const Surrogate s = surrogate_of(5, f);
  const Eigen::Vector2d between(0.4, 0.6), on(0.5, 0.5), beyond(1.6, 1.6);
  // A fifth of a period of the fastest change between points: some per mille of the range of 2.
  EXPECT_NEAR(s.value(between), f(0.4, 0.6), 0.01);
  EXPECT_NEAR(s.value(on), f(0.5, 0.5), 1e-3);
  EXPECT_LT(s.error(on), s.error(between));
  EXPECT_LT(s.error(between), 0.1 * s.error(beyond));
}

TEST(Surrogate, SmoothsNoise) {
  // A plane with +-1 in turns: the noise's variance is 1, and the mean of 25 is found within some 1/sqrt(25).
  const Surrogate s = surrogate_of(
      5, [](double x, double y) { return 10 * x + (std::lround(4 * x + 20 * y) % 2 == 0 ? 1.0 : -1.0); }, 1);
  EXPECT_NEAR(s.value(Eigen::Vector2d(0.5, 0.5)), 5, 0.5);
}

TEST(Minimise, FindsTheDeeperOfTwoValleys) {
  // A double well with a tilt, and a narrow place in y: the deeper well is at x = 0.2.
  const auto f = [](const Eigen::VectorXd& u) {
    return 50 * std::pow((u[0] - 0.2) * (u[0] - 0.8), 2) + 0.2 * u[0] + 3 * std::pow(u[1] - 0.7, 2);
  };
  const Eigen::VectorXd u = minimise(2, f);
  // d/dx: 100 (x - 0.2)(x - 0.8)(2x - 1) + 0.2 = 0 nearest to 0.2 at x = 0.19429..., by Newton from 0.2.
  double x = 0.2;
  for (int i = 0; i < 30; ++i) {
    const double slope = 100 * (x - 0.2) * (x - 0.8) * (2 * x - 1) + 0.2;
    const double bend = 100 * ((2 * x - 1) * (2 * x - 1) + 2 * (x - 0.2) * (x - 0.8));
    x -= slope / bend;
  }
  EXPECT_NEAR(u[0], x, 1e-4);
  EXPECT_NEAR(u[1], 0.7, 1e-4);
}

/// A plan beside its scenario, in a directory of its own. The modulus of a packing of linear springs rises with their
/// stiffness, and restitution has hardly any part in a slow compression.
struct Synthetic {
  test::RunDirectory directory;
  std::string plan() const {
    directory.scenario(
        "subsoil: 1\nmaterials: {grain: {density: 2600 kg/m^3}}\n"
        "contacts: [{between: [grain, grain], law: linear, k_n: 5 kN/m, restitution: 0.5, mu: 0.5}]\n"
        "test: {material: grain, walls: grain, radius: 5 mm, packings: 3,\n"
        "       compress: {length: 50 mm, depth: 40 mm, stress: 4 kPa, speed: 40 mm/s}}\n");
    const std::string file = directory / "plan.yaml";
    std::ofstream(file) << "subsoil: 1\nscenario: case.yaml\nparameters:\n"
                           "  k_n: {keys: \"contacts[0].k_n\", between: 1 8, unit: kN/m, truth: 3}\n"
                           "  e: {keys: \"contacts[0].restitution\", between: 0.3 0.8, truth: 0.5}\n"
                           "targets: [{test: compress, number: modulus, tolerance: 10 kPa}]\n"
                           "design: 6\nevaluations: 9\n";
    return file;
  }
};

TEST(Calibrate, FindsWhatIsToldAndNamesWhatIsNot) {
  const Synthetic synthetic;
  const Plan plan = load_plan(synthetic.plan(), {});
  const auto store = synthetic.directory / "evaluations.csv";
  const Calibrated found = calibrate(plan, store, 0, {});
  // The truth's packings are others than the calibration's: three of each, so the interval must hold the truth at 95 %.
  // Moduli of packings as small as these spread by a tenth, 8 kPa, and rise by 8 kPa per kN/m: twice the spread of the
  // difference of two is 2.8 kN/m. The middle of the range is 1.5 away from the truth.
  EXPECT_NEAR(found.values[0], 3, 2.8);
  EXPECT_LT(found.low[0], 3);
  EXPECT_GT(found.high[0], 3);
  // One target for two parameters: one direction is blind, and it is restitution.
  EXPECT_GT(found.strengths[0], 2);  // deviations over the range: some three with packings that scatter so
  EXPECT_LT(found.strengths[1], Calibrated::blind);
  EXPECT_GT(std::abs(found.directions(1, 1)), 0.9);
  EXPECT_NE(calibration_text(plan, found).find("**no**"), std::string::npos);

  // Again from the store: it is not run anew, so a value changed in it shows.
  std::ifstream in(store);
  std::stringstream text;
  text << in.rdbuf();
  std::string kept = text.str();
  const Evaluation& last = found.evaluations.back();
  const std::string number = fmt::format("{}", last.found[0]);
  ASSERT_NE(kept.find(number), std::string::npos);
  kept.replace(kept.find(number), number.size(), "123456");
  std::ofstream(store) << kept;
  const Calibrated again = calibrate(plan, store, 0, {});
  EXPECT_EQ(again.evaluations[found.evaluations.size() - 1].found[0], 123456);

  Plan single = plan;
  single.scenario = synthetic.directory / "single.yaml";
  std::ifstream scenario(synthetic.directory / "case.yaml");
  std::stringstream three;
  three << scenario.rdbuf();
  std::string one = three.str();
  one.replace(one.find("packings: 3"), 11, "packings: 1");
  std::ofstream(single.scenario) << one;
  EXPECT_NE(message_of([&] {
              static_cast<void>(calibrate(single, synthetic.directory / "other.csv", 0, {}));
            }).find("test.packings = 1: one packing does not show how far packings scatter"),
            std::string::npos);

  std::ofstream(synthetic.directory / "case.yaml", std::ios::app) << "gravity: 5 m/s^2\n";
  EXPECT_NE(message_of([&] { static_cast<void>(calibrate(plan, store, 0, {})); }).find("name another folder"),
            std::string::npos);
}

TEST(Calibrate, RefusalsNamePlaceRuleAndCure) {
  const Synthetic synthetic;
  const std::string file = synthetic.plan();
  const auto says = [&](const std::string& set) {
    return message_of([&] { static_cast<void>(load_plan(file, {set})); });
  };
  EXPECT_EQ(says("parameters.k_n.between=10 2"),
            "--set parameters.k_n.between = 10 2: the first number must be less than the second");
  EXPECT_EQ(says("parameters.k_n.truth=20"), "--set parameters.k_n.truth: must lie in the range");
  EXPECT_EQ(says("targets[0].number=modulos"),
            "--set targets[0].number: `modulos` is no number of compress; did you mean `modulus`?");
  EXPECT_EQ(says("targets[0].test=compres"),
            "--set targets[0].test: there is no laboratory test of this name; did you mean `compress`?");
  EXPECT_NE(says("targets[0].tolerance=3 mm").find("targets[0].tolerance"), std::string::npos);
  EXPECT_EQ(says("design=3"), "--set design: must be two points more than there are parameters");
}

TEST(CalibrationPlan, ConfigsAreRead) {
  int plans = 0;
  for (const auto& entry : std::filesystem::directory_iterator(subsoil::test::source_dir() + "/configs/calibrate")) {
    EXPECT_FALSE(load_plan(entry.path(), {}).parameters.empty()) << entry.path();
    ++plans;
  }
  EXPECT_GE(plans, 3);
}

}  // namespace
}  // namespace subsoil::sim::calibrate_test
