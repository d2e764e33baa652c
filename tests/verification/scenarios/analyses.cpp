#include <cmath>
#include <numbers>

#include "libsim/document/document.hpp"
#include "libsim/io/series_writer.hpp"
#include "tests/tools/program_runs.hpp"

/// Analyses of machines without soil through the whole program: the word in the file, series and summary out.
/// Oracles: closed forms of rods, springs, the slider-crank and the bouncing ball.
namespace subsoil::sim::analyses {
namespace {

using test::run_scenario;
using test::RunDirectory;
using test::summary_of;

constexpr double g = 9.81;

/// A rod of 1 kg and 1 m on a pin at the origin.
std::string rod(const std::string& pose, const std::string& rest) {
  return "subsoil: 1\nmachine:\n  bodies:\n    rod: {mass: 1 kg, inertia: 0.08333333333333333 kg m^2, " + pose +
         "}\n  joints:\n    pin: {revolute: [ground, rod], points: [0 0 m, -0.5 0 m]}\n" + rest;
}
const std::string level = "at: 0.5 0 m", upright = "at: 0 0.5 m, angle: 90 deg";

std::string refusal(const std::string& text, const std::vector<std::string>& sets = {}) {
  const RunDirectory dir;
  try {
    run_scenario(dir.scenario(text), dir / "out", sets);
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(Analyses, KinematicsGivesMotionAndTorqueAtEveryRow) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(test::config("slider-crank"), dir / "out", {"analysis=kinematics"}), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double r = 0.1, l = 0.4, w = 20;
  const std::vector<double>& t = series.at("time");
  ASSERT_GT(t.size(), 10U);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double s = r * std::sin(w * t[i]), c = r * std::cos(w * t[i]), bar = std::sqrt(l * l - s * s);
    ASSERT_NEAR(series.at("slider.x")[i], c + bar, 1e-13);
    ASSERT_NEAR(series.at("slider.vx")[i], -w * s - w * s * c / bar, 1e-11);
  }
  EXPECT_EQ(summary_of(dir / "out")["run"]["analysis"], "kinematics");
}

/// A blow beside a distance joint, which ida leaves to steps over singular configurations: one that only just converges
/// is halved where its part up to an event does not. Every tolerance reaches the latch of cvode at 1.9141116 s.
TEST(Analyses, TripLegLatchesByIdaAtEveryTolerance) {
  for (const char* tolerance : {"1e-6", "1e-8", "1e-9"}) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(test::config("trip-leg"), dir / "out",
                           {"time.machine.integrator=ida", std::string("time.machine.rtol=") + tolerance,
                            std::string("time.machine.atol=") + tolerance}),
              exit_ok)
        << tolerance;
    EXPECT_NEAR(read_series(dir / "out" / "series.csv").at("time").back(), 1.9141116, 2e-7) << tolerance;
  }
}

TEST(Analyses, KinematicsOfAFreeMachineIsRefusedWithWhatIsFree) {
  const std::string text = refusal(rod(level, "time: {end: 1 s}\n"), {"analysis=kinematics"});
  EXPECT_NE(text.find("case.yaml:"), std::string::npos) << text;
  EXPECT_NE(text.find("driven by nothing (rod."), std::string::npos) << text;
}

TEST(Analyses, EquilibriumOfAHangingAndOfAnUprightRod) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(rod(level, "analysis: equilibrium\n")), dir / "hangs"), exit_ok);
  nlohmann::json found = summary_of(dir / "hangs")["equilibrium"];
  EXPECT_EQ(found["stability"], "stable");
  EXPECT_NEAR(found["pose"]["rod"]["y [m]"].get<double>(), -0.5, 1e-12);
  const Series row = read_series(dir / "hangs" / "series.csv");
  ASSERT_EQ(row.rows(), 1U);
  EXPECT_NEAR(std::abs(row.at("pin.fy")[0]), g, 1e-10);
  ASSERT_EQ(run_scenario(dir.scenario(rod(upright, "analysis: equilibrium\n")), dir / "stands"), exit_ok);
  found = summary_of(dir / "stands")["equilibrium"];
  EXPECT_EQ(found["stability"], "unstable");
  EXPECT_EQ(found["unstable eigenvalues"], 1);
}

TEST(Analyses, AMachineThatFallsForEverHasNoEquilibrium) {
  const RunDirectory dir;
  const std::string file = dir.scenario(
      "subsoil: 1\nanalysis: equilibrium\nmachine: {bodies: {ball: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}\n");
  try {
    run_scenario(file, dir / "out");
    FAIL() << "found one";
  } catch (const ScenarioError& error) {
    FAIL() << "the file is good, so no exit 2: " << error.what();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).rfind("no static equilibrium", 0), 0U) << error.what();
  }
}

TEST(Analyses, ModesGoToATableAndTheSummary) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(rod(level, "analysis: modes\n")), dir / "out"), exit_ok);
  const double frequency = std::sqrt(1.5 * g) / (2 * std::numbers::pi);
  const nlohmann::json modes = summary_of(dir / "out")["modes"];
  ASSERT_EQ(modes.size(), 1U);
  EXPECT_NEAR(modes[0]["frequency [Hz]"].get<double>(), frequency, 1e-8);
  const Series table = read_series(dir / "out" / "modes.csv");
  ASSERT_EQ(table.rows(), 1U);
  EXPECT_NEAR(table.at("frequency")[0], frequency, 1e-8);
  EXPECT_NEAR(std::abs(table.at("rod.x.real")[0] / table.at("rod.angle.real")[0]), 0.5, 1e-8);
}

TEST(Analyses, AssemblySaysWhatMoved) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(rod("at: 0.5 0.01 m", "analysis: assembly\n")), dir / "out"), exit_ok);
  const nlohmann::json found = summary_of(dir / "out")["assembly"];
  EXPECT_EQ(found["freedom"], 1);
  EXPECT_EQ(found["rank"], 2);
  EXPECT_NEAR(found["open as given [m or rad]"]["joint 'pin'"].get<double>(), 0.01, 1e-12);
  const Series row = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(found["moved"]["rod"]["y [m]"].get<double>(), row.at("rod.y")[0] - 0.01, 1e-15);
  // The pin lies half a length behind the centre.
  EXPECT_NEAR(std::hypot(row.at("rod.x")[0], row.at("rod.y")[0]), 0.5, 1e-13);
}

TEST(Analyses, AnOpenPoseIsRefusedWhenNothingMayMove) {
  const std::string text = refusal(rod("at: 0.5 0.01 m", "  assemble: no\ntime: {end: 1 s}\n"));
  EXPECT_NE(text.find("joint 'pin' by"), std::string::npos) << text;
  EXPECT_NE(text.find("0.01 m"), std::string::npos) << text;
}

TEST(Analyses, NeedAMachineWithoutSoil) {
  const std::string text = refusal(test::small_pass, {"analysis=modes"});
  EXPECT_NE(text.find("looks at a machine without soil"), std::string::npos) << text;
}

TEST(Analyses, OnlyMotionNeedsAnEnd) {
  EXPECT_NE(refusal(rod(level, "")).find("time.end: is missing: simulated time, in s"), std::string::npos);
}

// ---- rows ----------------------------------------------------------------------------------------------------------

/// Pull of the pin on a rod let go from the level, at the angle a below it: along the rod (5/2) m g sin a, across it
/// (1/4) m g cos a.
double pin_force(double angle) { return std::hypot(2.5 * g * std::sin(angle), 0.25 * g * std::cos(angle)); }

// Not means over the row's interval: those differ by tenths of a newton. Tolerances of 1e-10 leave some hundreds of
// them in the spin's square, of order 10.
TEST(Rows, HoldForcesAtTheirInstantWithoutSoil) {
  const std::vector<std::vector<std::string>> methods{
      {"time.machine.integrator=adams-moulton"},
      {"time.machine.integrator=cvode"},
      {"time.machine.integrator=ida"},
      {"time.machine.integrator=ida", "time.machine.formulation=index 1"}};
  const RunDirectory dir;
  const std::string file = dir.scenario(
      rod(level, "time: {end: 0.5 s, machine: {rtol: 1e-10, atol: 1e-11}}\noutput: {series every: 20 ms}\n"));
  for (std::size_t k = 0; k < methods.size(); ++k) {
    const auto out = dir / std::to_string(k);
    ASSERT_EQ(run_scenario(file, out, methods[k]), exit_ok);
    const Series series = read_series(out / "series.csv");
    ASSERT_EQ(series.rows(), 26U);
    for (std::size_t i = 0; i < series.rows(); ++i)
      ASSERT_NEAR(std::hypot(series.at("pin.fx")[i], series.at("pin.fy")[i]), pin_force(series.at("rod.angle")[i]),
                  1e-7)
          << methods[k].back() << ", row " << i;
    EXPECT_EQ(series.at("time").back(), 0.5);
  }
}

TEST(Rows, HoldMeansWhereAskedFor) {
  const RunDirectory dir;
  const std::string file =
      dir.scenario(rod(level, "time: {end: 0.2 s}\noutput: {series every: 20 ms, forces: mean}\n"));
  ASSERT_EQ(run_scenario(file, dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double now = pin_force(series.at("rod.angle")[5]),
               here = std::hypot(series.at("pin.fx")[5], series.at("pin.fy")[5]);
  EXPECT_GT(std::abs(here - now), 0.1);
}

TEST(Rows, EndWhereTheRunEnds) {
  const RunDirectory dir;
  const std::string file = dir.scenario(rod(level, "time: {end: 0.3456 s}\noutput: {series every: 10 ms}\n"));
  for (const char* integrator : {"adams-moulton", "cvode"}) {
    ASSERT_EQ(run_scenario(file, dir / integrator, {std::string("time.machine.integrator=") + integrator}), exit_ok);
    const std::vector<double> t = read_series(dir / integrator / "series.csv").at("time");
    EXPECT_NEAR(t.back(), 0.3456, 1e-15);
    EXPECT_NEAR(t[t.size() - 2], 0.34, 1e-12);
    EXPECT_EQ(summary_of(dir / integrator)["run"]["simulated [s]"], t.back());
  }
}

// Written twice from the same numbers: 1/3 has no short decimal, and comes back as it was.
TEST(Rows, ReadBackBitForBit) {
  const RunDirectory dir;
  {
    SeriesWriter out(dir / "series.csv", {{"third", "1"}}, 0);
    const double third = 1.0 / 3;
    out.write({&third, 1});
    out.flush();
  }
  EXPECT_EQ(read_series(dir / "series.csv").at("third")[0], 1.0 / 3);
}

TEST(Rows, EventsStandInTheSummary) {
  const RunDirectory dir;
  const std::string file = dir.scenario(R"(subsoil: 1
machine:
  bodies:
    ball: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0.2 m}
  forces:
    floor: {line contact: [ground, ball], ends: [0 0 m, 0 0.2 m], along: 1 0, n: 1, stiffness: 10 kN/m}
time: {end: 0.3 s, machine: {integrator: cvode}}
)");
  ASSERT_EQ(run_scenario(file, dir / "out"), exit_ok);
  nlohmann::json summary = summary_of(dir / "out");
  EXPECT_EQ(summary["run"]["events"], 2);
  EXPECT_NEAR(summary["events"][0]["time [s]"].get<double>(), std::sqrt(2 * 0.2 / g), 1e-7);
  EXPECT_EQ(summary["events"][0]["of"], "floor");
  EXPECT_EQ(summary["events"][0]["direction"], "closes");
  ASSERT_EQ(run_scenario(file, dir / "over", {"time.machine.locate events=no"}), exit_ok);
  EXPECT_EQ(summary_of(dir / "over")["run"]["events"], 0);
}

}  // namespace
}  // namespace subsoil::sim::analyses
