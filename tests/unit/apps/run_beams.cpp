#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/commands/beam_words.hpp"
#include "libsim/run/input_report.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/machine.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Beams of a scenario: what they stand for, their columns, the explicit copy, and what is refused. Oracle: the
/// cantilever with a force at its end.
namespace subsoil::sim::run_beams {
namespace {

using namespace test;

const std::string cantilever = R"(subsoil: 1
title: a cantilever
analysis: equilibrium
gravity: 0 m/s^2
machine:
  beams:
    bar: {points: [0 0 m, 1 0 m], section: {rectangle: 20 40 mm}, young's modulus: 200 GPa, density: 7850 kg/m^3, elements: 4}
  joints:
    root: {fixed: [ground, bar start], at: 0 0 m}
  forces:
    load: {force: bar end, along y: -10 N}
)";

constexpr double second_moment = 0.04 * 8e-6 / 12, bending = 2e11 * second_moment;

// Deflection P L^3/(3 EI) + P L/(kappa GA), moment P L and stress P L c/I at the root; large deflection is 1e-9 of it.
TEST(Beams, CantileverHasItsColumns) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(cantilever), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out/series.csv");
  const double shear = 10 / (13 / (12 + 11 * 0.3) * 2e11 / 2.6 * 8e-4);
  EXPECT_NEAR(series.at("bar.deflection y")[0], -10 / (3 * bending) - shear, 1e-6 * 10 / (3 * bending));
  EXPECT_NEAR(series.at("bar.turn")[0], -10 / (2 * bending), 1e-6 * 10 / (2 * bending));
  EXPECT_NEAR(series.at("bar.moment")[0], -10, 1e-4);
  EXPECT_NEAR(series.at("bar element 4.moment a")[0], -2.5, 1e-4);
  EXPECT_NEAR(series.at("bar.stress")[0], 10 * 0.01 / second_moment, 1e-4 * 10 * 0.01 / second_moment);
  EXPECT_EQ(series.at("bar.stress at")[0], 0);
  EXPECT_NEAR(series.at("bar.strain energy")[0], 10 * (10 / (3 * bending) + shear) / 2, 1e-6);
  EXPECT_NEAR(series.at("root.moment")[0], -10, 1e-4) << "P L, on the ground";
}

// The explicit copy shows the beam and not what it stands for, and runs to the same numbers.
TEST(Beams, ExplicitCopyRunsTheSame) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(cantilever), dir / "out"), exit_ok);
  std::ifstream file(dir / "out/scenario.yaml");
  const std::string copy{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(copy.find("beams:"), std::string::npos) << copy;
  EXPECT_EQ(copy.find("bar element"), std::string::npos) << copy;
  ASSERT_EQ(run_scenario((dir / "out/scenario.yaml").string(), dir / "again"), exit_ok);
  const Series a = read_series(dir / "out/series.csv"), b = read_series(dir / "again/series.csv");
  for (const char* column : {"bar.deflection y", "bar end.angle", "bar element 2.shear force"})
    EXPECT_EQ(a.at(column), b.at(column)) << column;
}

// `subsoil check` says mass rho A L, first frequency 1.875^2/(2 pi) sqrt(EI/(rho A L^4)), and what the elements are
// good for: beta l = 0.4, so that n elements reach (0.4 n)^2/(2 pi) sqrt(EI/(rho A L^4)).
TEST(Beams, CheckSaysWhatElementsAreGoodFor) {
  const RunDirectory dir;
  const auto words = [&](const char* elements) {
    std::string text = cantilever;
    text.replace(text.find("elements: 4"), 11, elements);
    return beam_words(load_scenario(dir.scenario(text)).scenario.machine->beams[0]);
  };
  const double first = 1.8751040687 * 1.8751040687 / (2 * 3.14159265359) * std::sqrt(bending / (7850 * 8e-4));
  EXPECT_EQ(words("elements: 5"), fmt::format("bar: 1 m, 6.28 kg, 5 elements; as a straight cantilever {:.4g} Hz, "
                                              "frequencies right to about 1e-3 up to {:.4g} Hz",
                                              first, first * std::pow(2 / 1.8751040687, 2)));
  EXPECT_NE(words("elements: 4").find("too few elements"), std::string::npos);
}

// A load that is there at once: ida by default, and Adams-Moulton in parts of its step of order 2 (15 us). The first
// mode, 100 rad/s, is right to (w h)^2/12 = 2e-7; of the higher ones, some per cent of the deflection, those of 1e4
// rad/s lose their phase within the 8 ms: 2e-4 of the whole.
TEST(Beams, IntegratorsAgree) {
  std::string text = cantilever + "time: {end: 8 ms}\noutput: {every: 1 ms}\n";
  text.replace(text.find("analysis: equilibrium"), 21, "analysis: dynamics");
  const RunDirectory dir;
  const std::string file = dir.scenario(text);
  EXPECT_EQ(integrator_of(load_scenario(file).scenario), mbd::IntegratorKind::ida);
  ASSERT_EQ(run_scenario(file, dir / "ida"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "adams", {"time.machine.integrator=adams-moulton"}), exit_ok);
  const Series a = read_series(dir / "ida/series.csv"), b = read_series(dir / "adams/series.csv");
  for (const char* column : {"bar.deflection y", "bar.turn"})
    EXPECT_NEAR(a.at(column).back(), b.at(column).back(), 2e-4 * std::abs(a.at(column).back())) << column;
  EXPECT_NEAR(b.at("energy.balance").back(), 0, 1e-4 * b.at("bar.strain energy").back());
}

TEST(Beams, FaultsNameTheBeam) {
  const RunDirectory dir;
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = cantilever;
    text.replace(text.find(from), from.size(), to);
    return subsoil::test::message_of([&] { load_scenario(dir.scenario(text)); });
  };
  const auto expect = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  expect(message("0 0 m, 1 0 m", "0 0 m"), "machine.beams.bar.points");
  expect(message("rectangle: 20 40 mm", "tube: 20 12 mm"), "machine.beams.bar: section: the wall of the tube");
  expect(message("elements: 4", "elements: 0"), "machine.beams.bar.elements");
  expect(message("elements: 4", "damping ratio: 0.1, damping time: 1 s"), "keep one");
  expect(message("bar end, along y", "bar 4, along y"), "there is no body of this name");
}

// A damped beam divides fixed steps until a run takes days: 1 ms into tau w^2/2 with tau = 2 ratio/w_1, and w = (2/l) c
// at the least. What `auto` takes needs no such steps, and without damping there are few.
TEST(Beams, FixedStepsOfADampedBeamAreWarnedOf) {
  const RunDirectory dir;
  const auto warnings = [&](const std::string& damping, const std::string& integrator) {
    std::string text = cantilever;
    text.replace(text.find("analysis: equilibrium\n"), 22,
                 "time: {end: 2 s, machine: {integrator: " + integrator + "}}\n");
    text.replace(text.find("elements: 4"), 11, "elements: 4, damping ratio: " + damping);
    const std::string file = dir.scenario(text);
    const Loaded loaded = load_scenario(file);
    const World world = build_world(loaded, {.threads = 1, .settle = false, .restored = {}, .progress = {}});
    return fmt::format("{}", fmt::join(input_warnings(loaded, world, file, {}), "\n"));
  };
  const std::string found = warnings("0.2", "adams-moulton");
  EXPECT_TRUE(found.starts_with("time.machine.integrator = adams-moulton: the fastest waves of the beams divide"))
      << found;
  EXPECT_NE(found.find("`time.machine.integrator: ida` needs none"), std::string::npos) << found;
  EXPECT_EQ(warnings("0.2", "auto"), "");
  EXPECT_EQ(warnings("0", "adams-moulton"), "");
}

// A slide on a curve comes near a singular pose that it does not reach, beside a bar that swings fast: the step over it
// would be 0.6 s long and leads beyond all bounds. It is not taken, and both methods find the same place.
TEST(Beams, AStepThatLeadsBeyondAllBoundsIsNone) {
  constexpr const char* slide = R"(subsoil: 1
machine:
  bodies:
    b0: {mass: 1.277 kg, inertia: 0.07328 kg m^2, at: 0.309520790588109 -0.17958563470865918 m, angle: 2.5639704007566064 rad, pose is: about}
    b1: {mass: 3 kg, inertia: 0.05312 kg m^2, at: 0.321287867001002 -0.10648326872305555 m, angle: 2.3133704007566065 rad, pose is: about}
  joints:
    j0: {fixed: [ground, b0], at: 0.5470978520555859 -0.16229788284560032 m}
    j1: {point on curve: [b0, b1], curve: [-0.2 0 m, -0.1 0.04546 m, 0 -0.03784 m, 0.1 -0.01397 m, 0.2 0.04947 m]}
    clamp: {fixed: [ground, bar start], at: -0.03860606685325532 -0.20079922535239517 m}
  beams:
    bar: {points: [-0.03860606685325532 -0.20079922535239517 m, -0.41056987790676924 -0.05369919045591465 m],
          section: {circle: 0.012 m}, young's modulus: 200 MPa, density: 2000 kg/m^3, elements: 2, damping ratio: 0.05}
gravity: 7.227325687014222 6.633390039325625 0 m/s^2
time: {end: 0.16 s}
output: {series every: 0.015 s}
)";
  double place[2] = {};
  for (const int k : {0, 1}) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(slide), dir / "out",
                           {k == 0 ? "time.machine.integrator=cvode" : "time.machine.integrator=ida"}),
              exit_ok);
    place[k] = read_series(dir / "out" / "series.csv").at("b1.x").back();
  }
  EXPECT_NEAR(place[0], place[1], 1e-8);
}

}  // namespace
}  // namespace subsoil::sim::run_beams
