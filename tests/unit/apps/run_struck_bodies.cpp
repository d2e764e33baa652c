#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libsim/io/series.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/program_runs.hpp"

/// Spheres that hit bodies which are light: what the run makes of the impact, and what it says where it cannot.
namespace subsoil::sim::run_struck_bodies {
namespace {

using namespace test;

/// A sphere of radius 10 mm hits a hinged flap at rest 0.15 m below its hinge, without gravity.
struct Flap {
  double restitution, mass;
  double sphere_mass = 2500 * 4.0 / 3 * std::numbers::pi * 1e-6;

  double about_hinge() const { return mass * (0.2 * 0.2 / 12 + 0.1 * 0.1); }
  /// Of the two masses that meet, the flap's I/r^2.
  double reduced() const {
    const double flap = about_hinge() / (0.15 * 0.15);
    return sphere_mass * flap / (sphere_mass + flap);
  }
  /// What a linear contact leaves whose damper was chosen for the sphere's mass, exp(-pi b/sqrt(1 - b^2)) with b =
  /// beta sqrt(m/m*).
  double met() const {
    const double l = std::log(restitution), beta = -l / std::hypot(std::numbers::pi, l);
    const double b = beta * std::sqrt(sphere_mass / reduced());
    return std::exp(-std::numbers::pi * b / std::sqrt(1 - b * b));
  }
  /// Angular momentum about the hinge: (1 + e) m v r/(I + m r^2).
  double spin() const { return (1 + met()) * sphere_mass * 2 * 0.15 / (about_hinge() + sphere_mass * 0.15 * 0.15); }
  std::string text() const {
    return fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
materials: {{soil: {{density: 2500 kg/m^3}}}}
contacts: [{{between: [soil, soil], law: linear, k_n: 50 kN/m, restitution: {}, mu: 0}}]
soil: {{bed: {{fill: particles, material: soil, particles: [{{position: -0.05 -0.15 0 m, radius: 10 mm, velocity: 2 0 0 m/s}}]}}}}
machine:
  bodies: {{flap: {{mass: {} kg, inertia: {} kg m^2, at: 0 -0.1 m}}}}
  joints: {{hinge: {{revolute: [ground, flap], at: 0 0 m}}}}
  surfaces: {{plate: {{body: flap, material: soil, box: 0.01 0.2 0.1 m}}}}
time: {{end: 21 ms}}
output: {{precision: double, state: none}}
)",
                       restitution, mass, mass * 0.2 * 0.2 / 12);
  }
};

double spin_after(const std::filesystem::path& out) { return read_series(out / "series.csv").at("flap.spin").back(); }
std::string warnings_of(const std::filesystem::path& out) { return summary_of(out)["warnings"].dump(); }

/// In the first step of the touch the integrator's past knows no force: a seventh of the energy of that one step is
/// missing, which is nothing against what the sphere brings.
TEST(StruckBody, ThatWasAtRestIsNoLostBalance) {
  const Flap flap{.restitution = 0.1, .mass = 0.02};
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(flap.text()), dir / "out", {"output.series every=0.1 ms"}), exit_ok)
      << summary_of(dir / "out")["run"]["failure"];
  // The restitution that `time.accuracy` allows is off by 0.01, of 1 + e.
  EXPECT_NEAR(spin_after(dir / "out"), flap.spin(), 0.01 * flap.spin());
}

/// What is really lost is still named, with the key that acts: a spring of 16 times the stable stiffness.
TEST(StruckBody, OnASpringTooStiffForTheStepStillStops) {
  const RunDirectory dir;
  std::string text = Flap{.restitution = 0.1, .mass = 0.02}.text();
  text.insert(text.find("  surfaces:"),
              "  forces: {spring: {spring-damper: [ground, flap], ends: [0.1 -0.2 m, 0 -0.2 m], stiffness: 10 GN/m, "
              "free length: 0.099999 m}}\n");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_failed);
  const std::string failure = summary_of(dir / "out")["run"]["failure"];
  EXPECT_NE(failure.find("`time.soil step`"), std::string::npos) << failure;
  EXPECT_EQ(failure.find("time.machine.step"), std::string::npos) << failure;
}

TEST(StruckBody, LighterThanTheSphereGetsItsStep) {
  for (const double mass : {0.0003, 0.001, 0.05}) {
    const Flap flap{.restitution = 1, .mass = mass};
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(flap.text()), dir / "out"), exit_ok);
    // `time.accuracy`: 0.01 of the relative speed, half of which is of 1 + e.
    EXPECT_NEAR(spin_after(dir / "out"), flap.spin(), 0.005 * flap.spin()) << mass << " kg";
    EXPECT_EQ(warnings_of(dir / "out").find("the exchange between"), std::string::npos) << warnings_of(dir / "out");
  }
}

/// A step that was given stays, and what it makes of the energy is said: 40 steps in a contact with a fixed wall.
TEST(StruckBody, EnergyThatTheExchangeMakesIsSaidAndStrictFails) {
  const Flap flap{.restitution = 1, .mass = 0.001};
  const RunDirectory dir;
  const std::vector<std::string> coarse{"time.soil step=36 us"};
  ASSERT_EQ(run_scenario(dir.scenario(flap.text()), dir / "out", coarse), exit_ok);
  EXPECT_GT(spin_after(dir / "out"), 1.1 * flap.spin());
  EXPECT_NE(warnings_of(dir / "out").find("the exchange between soil and machine made"), std::string::npos)
      << warnings_of(dir / "out");
  EXPECT_EQ(
      run({.scenario = dir.scenario(flap.text()), .out = dir / "strict", .sets = coarse, .threads = 1, .strict = true}),
      exit_failed);
}

/// Both columns are of the row's time: in the step that follows the flap takes some hundredths of its energy.
TEST(StruckBody, WorkAtItsSurfaceIsItsExternalWorkInEveryRow) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(Flap{.restitution = 1, .mass = 0.05}.text()), dir / "out",
                         {"output.series every=0.1 ms", "output.series digits=all"}),
            exit_ok);
  const Series s = read_series(dir / "out" / "series.csv");
  const std::vector<double>&interface = s.at("interface.on machine"), &work = s.at("energy.external work");
  ASSERT_GT(work.back(), 1e-4);
  for (std::size_t i = 0; i < work.size(); ++i) EXPECT_NEAR(interface[i], work[i], 1e-12 * work.back()) << i;
}

/// The contact, from 17.5 ms on and pi sqrt(m*/k) = 1.2 ms long, lies between the rows of 10 and 20 ms.
TEST(StruckBody, ATouchBetweenTwoRowsIsATouch) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(Flap{.restitution = 1, .mass = 0.05}.text()), dir / "out",
                         {"output.series every=10 ms"}),
            exit_ok);
  EXPECT_EQ(warnings_of(dir / "out").find("touched no soil"), std::string::npos) << warnings_of(dir / "out");
  EXPECT_EQ(warnings_of(dir / "out").find("steady work"), std::string::npos) << "it was never meant to";
}

/// A ball of 0.283 kg against a slider, e = 0.5 asked.
std::string slider(double mass) {
  return fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
materials: {{a: {{density: 2500 kg/m^3}}}}
contacts: [{{between: [a, a], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0}}]
soil: {{bed: {{fill: particles, material: a, particles: [{{position: -50.3 0 0 mm, velocity: 1 0 0 m/s, radius: 30 mm}}]}}}}
machine:
  bodies: {{b: {{mass: {} kg, inertia: 0.1 kg m^2, at: 0.05 0 m}}}}
  joints: {{g: {{translational: [ground, b], at: 0 0 m, along: 1 0}}}}
  surfaces: {{f: {{body: b, material: a, box: 0.1 0.1 0.1 m}}}}
time: {{end: 0.1 s}}
output: {{precision: double, state: none}}
)",
                     mass);
}

std::vector<std::string> said_of(double mass) {
  const Loaded loaded = load_scenario_text(slider(mass), "slider.yaml");
  const World world = build_world(loaded, {.threads = 1, .settle = false});
  return surface_warnings(surface_facts(world, loaded.scenario, 0.1), world);
}

TEST(StruckBody, ARestitutionThatALightBodyDoesNotMeetIsSaid) {
  const double m = 2500 * 4.0 / 3 * std::numbers::pi * 27e-6, l = std::log(0.5);
  const double beta = -l / std::hypot(std::numbers::pi, l);
  for (const double mass : {0.5, 0.05}) {
    const double b = beta * std::sqrt((m + mass) / mass), e = std::exp(-std::numbers::pi * b / std::sqrt(1 - b * b));
    const std::vector<std::string> said = said_of(mass);
    ASSERT_EQ(said.size(), 1u) << mass;
    EXPECT_NE(said[0].find(fmt::format("restitution at `b` is {:.2f} where it yields most", e)), std::string::npos)
        << said[0];
    EXPECT_NE(said[0].find("has 0.50"), std::string::npos) << said[0];
    // And so it is: with the ball's speed by its momentum.
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(slider(mass)), dir / "out"), exit_ok);
    const double v = read_series(dir / "out" / "series.csv").at("b.vx").back();
    EXPECT_NEAR(v - (1 - mass / m * v), e, 0.01 + 0.002) << "time.accuracy; phases between those that it tries";
  }
  EXPECT_TRUE(said_of(50).empty());
}

}  // namespace
}  // namespace subsoil::sim::run_struck_bodies
