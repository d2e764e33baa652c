#include <gtest/gtest.h>

#include "libsim/base/problems.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/simulation.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Forces of a C++ program on the spheres of a scenario: in a run, in process, after a restart.
namespace subsoil::sim::run_sphere_forces {
namespace {

using namespace test;

constexpr const char* sphere = R"(subsoil: 1
gravity: 0 m/s^2
materials: {glass: {density: 2500 kg/m^3}}
contacts: [{between: [glass, glass], law: linear, k_n: 100 kN/m, restitution: 0.6, mu: 0}]
soil:
  container: {size: 2 2 2 m, at: -1 -1 -1 m, material: glass}
  bed: {fill: particles, particles: [{position: 0.3 0 0 m, radius: 10 mm, material: glass}]}
time: {end: 0.2 s, soil step: 20 us}
output: {state: full}
)";

/// N/m; of its state it keeps the time at which the field was last looked at.
struct Field {
  double k = 0.5, seen = -1;
  void begin_step(double time) { seen = time; }
  dem::Wrench operator()(const dem::SphereAt& s) const { return {-k * s.position, {}}; }
  void archive(Archive& a) { a("seen", seen); }
};
const std::vector<dem::NamedSphereForce> field{{"field", Field{}}};

double position(const Simulation& simulation) { return simulation.spheres()[0].x.x; }

int run_it(const RunDirectory& dir, const char* out, const std::vector<std::string>& sets,
           const std::vector<dem::NamedSphereForce>& forces, const std::filesystem::path& from = {}) {
  spdlog::set_level(spdlog::level::off);
  return run({.scenario = dir.scenario(sphere),
              .out = dir / out,
              .sets = sets,
              .threads = 1,
              .from = from,
              .sphere_forces = forces});
}

/// x(t) = a cos(w t), second order in w dt = 3e-4; the work is what the field had stored, and the run has no warning
/// about its energy.
TEST(SphereForcesOfARun, MoveTheSphereAndEnterTheBalance) {
  const RunDirectory dir;
  ASSERT_EQ(run_it(dir, "out", {}, field), exit_ok);
  const double mass = 2500 * dem::sphere_volume(0.01), a = 0.3, w = std::sqrt(0.5 / mass);
  const auto summary = summary_of(dir / "out");
  const auto energy = summary["energy"];
  EXPECT_EQ(summary["warnings"].size(), 1u) << "of the large container: " << summary["warnings"];
  const double x = a * std::cos(w * 0.2), work = 0.5 * 0.5 * (a * a - x * x);
  EXPECT_NEAR(energy["work of forces on spheres [J]"].get<double>(), work, 1e-3 * work);
  EXPECT_NEAR(energy["bed closure [J]"].get<double>(), 0, 1e-6 * work);
  EXPECT_GT(work, 0.01) << "the sphere must have moved";
}

TEST(SphereForcesOfARun, ARestartNeedsThemAgain) {
  const RunDirectory dir;
  ASSERT_EQ(run_it(dir, "whole", {}, field), exit_ok);
  ASSERT_EQ(run_it(dir, "first", {"time.end=0.1 s"}, field), exit_ok);
  const std::filesystem::path state = latest_state(dir / "first").value();
  ASSERT_EQ(run_it(dir, "second", {}, field, state), exit_ok);
  EXPECT_EQ(frame_positions(dir / "second", frame_times(dir / "second").size() - 1)[0].x,
            frame_positions(dir / "whole", frame_times(dir / "whole").size() - 1)[0].x);
  EXPECT_NE(subsoil::test::message_of([&] { run_it(dir, "third", {}, {}, state); }).find("with the force 'field'"),
            std::string::npos);
}

TEST(SphereForcesOfARun, AreReadChangedAndRestoredInProcess) {
  const SimulationOptions options{.sets = {}, .threads = 1, .sphere_forces = field, .energies = true};
  Simulation simulation = Simulation::from_text(sphere, "case.yaml", options);
  simulation.run_until(0.05);
  EXPECT_NEAR(simulation.sphere_force("field").as<Field>().seen, 0.05, 3e-5);
  EXPECT_GT(simulation.value("soil.force work"), 0);
  const Simulation::State state = simulation.save();
  simulation.run_until(0.1);
  const double x = position(simulation);
  simulation.restore(state);
  EXPECT_NEAR(simulation.sphere_force("field").as<Field>().seen, 0.05, 3e-5);
  simulation.run_until(0.1);
  EXPECT_EQ(position(simulation), x);
  simulation.restore(state);
  simulation.sphere_force("field").as<Field>().k = 1;
  simulation.run_until(0.1);
  EXPECT_LT(position(simulation), x);
}

TEST(SphereForcesOfARun, AreRefusedWhereSpheresMaySleepAndWithoutSoil) {
  const auto refused = [](const std::string& text) {
    return subsoil::test::message_of(
        [&] { Simulation::from_text(text, "case.yaml", {.sets = {}, .threads = 1, .sphere_forces = field}); });
  };
  std::string sleepy = sphere;
  sleepy.insert(sleepy.find("time:"), "  active: {within: 100 mm, below: 1 mm/s}\n");
  EXPECT_NE(refused(sleepy).find("force on spheres 'field': spheres of an active region may sleep"), std::string::npos)
      << refused(sleepy);
  const std::string pendulum = R"(subsoil: 1
machine:
  bodies: {bob: {mass: 1 kg, inertia: 0.1 kg m^2, at: 1 0 m}}
  joints: {pin: {revolute: [ground, bob], at: 0 0 m}}
time: {end: 1 s}
)";
  EXPECT_NE(refused(pendulum).find("the scenario has no soil"), std::string::npos) << refused(pendulum);
}

}  // namespace
}  // namespace subsoil::sim::run_sphere_forces
