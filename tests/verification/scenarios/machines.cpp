#include <cmath>
#include <numbers>

#include "tests/tools/program_runs.hpp"

/// Machines without soil through the whole program: file in, series out.
/// Oracles: the complete elliptic integral; the slider's closed form, differentiated by hand.
namespace subsoil::sim::machines {
namespace {

/// Times at which a column passes zero upward, by linear interpolation.
std::vector<double> upward_crossings(const std::vector<double>& t, const std::vector<double>& x) {
  std::vector<double> out;
  for (std::size_t i = 1; i < t.size(); ++i)
    if (x[i - 1] < 0 && x[i] >= 0) out.push_back(t[i - 1] - x[i - 1] * (t[i] - t[i - 1]) / (x[i] - x[i - 1]));
  return out;
}

TEST(Machines, PendulumOfNinetyDegreesHasThePeriodOfTheEllipticIntegral) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("pendulum"), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  std::vector<double> from_hanging = series.at("rod.angle");
  for (double& angle : from_hanging) angle += std::numbers::pi / 2;
  const std::vector<double> passes = upward_crossings(series.at("time"), from_hanging);
  ASSERT_EQ(passes.size(), 5U);
  const double inertia = 1.0 / 3, m = 1, g = 9.81, d = 0.5;
  const double period = 4 * std::sqrt(inertia / (m * g * d)) * std::comp_ellint_1(std::sin(std::numbers::pi / 4));
  EXPECT_NEAR(period, 1.9333, 5e-5) << "as the config's comment says";
  // Where it hangs its spin is constant to second order, so interpolation over 5 ms is good to 1e-7 s.
  EXPECT_NEAR((passes.back() - passes.front()) / 4, period, 2e-6);
  EXPECT_NEAR(passes.front(), 0.75 * period, 2e-6) << "let go at the right, first upward pass after three quarters";
  for (const double balance : series.at("energy.balance")) ASSERT_LT(std::abs(balance), 1e-6 * m * g * d);
}

TEST(Machines, SliderFollowsTheCrankAndTheMotorsTorqueDoesTheWork) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("slider-crank"), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double r = 0.1, l = 0.4, w = 20;
  const std::vector<double>& t = series.at("time");
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double s = r * std::sin(w * t[i]), c = r * std::cos(w * t[i]), rod = std::sqrt(l * l - s * s);
    ASSERT_NEAR(series.at("slider.x")[i], c + rod, 1e-8);
    ASSERT_NEAR(series.at("slider.vx")[i], -w * s - w * s * c / rod, 1e-7);
  }
  // The driver gives and takes back: kinetic energy now less that of the start is its work.
  const std::vector<double>&kinetic = series.at("energy.kinetic"), &work = series.at("energy.driver work");
  for (std::size_t i = 0; i < t.size(); ++i)
    ASSERT_NEAR(kinetic[i] - kinetic.front(), work[i] - work.front(), 1e-5 * kinetic.front());
}

/// A slide whose friction comes to lock itself: no integrator creeps towards that instant for ever.
TEST(LockingFriction, EndsARunThatCannotPassIt) {
  constexpr const char* locking = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies:
    arm: {mass: 2 kg, inertia: 0.08 kg m^2, at: 0.4 -0.15 m}
    block: {mass: 2 kg, inertia: 0.06 kg m^2, at: 0.43 -0.3 m}
  joints:
    pin: {revolute: [ground, arm], at: 0.06 -0.06 m}
    slide: {translational: [arm, block], at: 0.1 -0.18 m, along: -0.085 -0.444}
  forces:
    hold: {rotational spring-damper: [ground, arm], stiffness: 2.3 N m/rad, damping: 0.09 N m s/rad}
    bush: {bushing: [arm, block], at: 0.1 -0.18 m, turn: 1.84 rad, stiffness x: 200 N/m, stiffness y: 200 N/m, damping x: 1.4 N s/m, damping y: 0.63 N s/m}
    rub: {joint friction: slide, guide: 0.2 m, mu_s: 0.4, mu_k: 0.285}
time: {end: 1 s}
)";
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(dir.scenario(locking), dir / "out"), exit_failed);
  EXPECT_TRUE(test::summary_of(dir / "out")["run"]["failure"].get<std::string>().find("joint 'slide' locks itself") !=
              std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::machines
