#include <fmt/format.h>
#include <spdlog/sinks/ostream_sink.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <sstream>

#include "libmbd/equilibrium/force_jumps.hpp"
#include "libsim/setup/machine.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Analyses beside dynamics: what they find is what the machine would do, or they say that it is not.
namespace subsoil::sim::run_analyses {
namespace {

using namespace test;

/// "" where the run ends well.
std::string refusal(const std::string& text, const std::vector<std::string>& sets) {
  const RunDirectory dir;
  return message_of<std::exception>([&] { run_scenario(dir.scenario(text), dir / "out", sets); });
}
double found(const std::string& text, const std::string& column, const std::vector<std::string>& sets = {}) {
  const RunDirectory dir;
  std::vector<std::string> all = sets;
  all.emplace_back("analysis=equilibrium");
  EXPECT_EQ(run_scenario(dir.scenario(text), dir / "out", all), exit_ok);
  return read_series(dir / "out" / "series.csv").at(column).back();
}
bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A block on a slope of tan = 0.546 sticks while mu_s is above it.
constexpr const char* block = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {b: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0 0 m}}
  joints: {r: {translational: [ground, b], at: 0 0 m, along: 0.87758256 0.47942554}}
  forces: {f: {joint friction: r, guide: 100 m, mu_s: 0.6, mu_k: 0.4, stick stiffness: 1 MN/m}}
time: {end: 1 s}
)";
TEST(Equilibrium, FrictionHoldsUpToItsLimit) {
  EXPECT_NEAR(found(block, "f.force"), 2 * 9.81 * std::sin(0.5), 1e-6);
  for (const char* analysis : {"analysis=equilibrium", "analysis=modes"})
    EXPECT_TRUE(
        holds(refusal(block, {analysis, "machine.forces.f.mu_s=0.5"}), "the pose found is no rest: there body 'b'"))
        << analysis;
}

/// A block of 10 kg on two corners, that do not overlap at the start, is pushed by 10 N of the 49 N that friction
/// holds.
constexpr const char* pushed = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {a: {mass: 10 kg, inertia: 1 kg m^2, at: 0 0.05 m}}
  forces:
    l: {line contact: [ground, a], points: [0 0 m, -0.2 -0.05 m], along: 1 0, stiffness: 1e6 N/m^1.5, restitution: 0.3, friction: 0.5, stick stiffness: 1e6 N/m}
    r: {line contact: [ground, a], points: [0 0 m, 0.2 -0.05 m], along: 1 0, stiffness: 1e6 N/m^1.5, restitution: 0.3, friction: 0.5, stick stiffness: 1e6 N/m}
    p: {force: a, along x: 10 N}
time: {end: 0.5 s}
output: {series every: 10 ms}
)";

/// Each corner obeys its law at the pose that is found: k times its own way along the line, k d^1.5 of its depth. The
/// way is a sum over steps, integrated exactly; 1e-12 m of rounding and Newton's remainder are 1e-6 N of it.
void expect_held(const Series& s, double x, double y, double angle, const std::string& contact, double corner) {
  const double c = std::cos(angle), i = std::sin(angle);
  const double along = x + c * corner + i * 0.05 - corner, depth = -(y + i * corner - c * 0.05);
  EXPECT_NEAR(s.at(contact + ".friction").back(), -1e6 * along, 1e-6) << contact;
  EXPECT_NEAR(s.at(contact + ".normal force").back(), 1e6 * std::pow(depth, 1.5), 1e-6) << contact;
}
TEST(Equilibrium, ContactsStickUpToTheirLimit) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(pushed), dir / "out", {"analysis=equilibrium"}), exit_ok);
  EXPECT_EQ(summary_of(dir / "out")["equilibrium"]["stability"], "stable");
  const Series s = read_series(dir / "out" / "series.csv");
  const double x = s.at("a.x").back(), y = s.at("a.y").back(), angle = s.at("a.angle").back();
  expect_held(s, x, y, angle, "l", -0.2), expect_held(s, x, y, angle, "r", 0.2);
  const double left = s.at("l.normal force").back(), right = s.at("r.normal force").back();
  EXPECT_NEAR(s.at("l.friction").back() + s.at("r.friction").back(), -10, 1e-8);
  EXPECT_NEAR(left + right, 98.1, 1e-8);
  // The push acts at the centre, 10 N at a height that both corners share but for the turn.
  const double arm = 0.2 * std::cos(angle), height = 0.05 * std::cos(angle), slant = 0.2 * std::sin(angle);
  const double turning = right * (arm + 0.05 * std::sin(angle)) - left * (arm - 0.05 * std::sin(angle)) +
                         s.at("l.friction").back() * (height + slant) + s.at("r.friction").back() * (height - slant);
  EXPECT_NEAR(turning, 0, 1e-7);
}

/// Dynamics from there keeps the pose, found from above or from 1 mm deep.
TEST(Equilibrium, ContactsThatStickStayAtRest) {
  for (const char* height : {"0.05", "0.049"}) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(pushed), dir / "out",
                           {"machine.start={towing equilibrium: 0 m/s}",
                            std::string("machine.bodies.a.at=[0 m, ") + height + " m]"}),
              exit_ok);
    const Series s = read_series(dir / "out" / "series.csv");
    for (const char* column : {"a.x", "a.y", "a.angle"}) EXPECT_NEAR(s.at(column).back(), s.at(column)[0], 1e-9);
  }
}

/// A slope of 20 degrees: sticks at mu = 0.5 with m g sin 20 as friction, not at 0.3 < tan 20. Friction that fades at
/// rest holds nothing, and the refusal says what does.
TEST(Equilibrium, ContactsStickOnASlope) {
  constexpr const char* slope = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {a: {mass: 10 kg, inertia: 1 kg m^2, at: [-0.017101007166283436 m, 0.04698463103929543 m], angle: 20 deg}}
  forces:
    l: {line contact: [ground, a], points: [0 0 m, -0.2 -0.05 m], along: 0.9396926207859084 0.3420201433256687, stiffness: 1e6 N/m^1.5, friction: 0.5, stick stiffness: 1e6 N/m}
    r: {line contact: [ground, a], points: [0 0 m, 0.2 -0.05 m], along: 0.9396926207859084 0.3420201433256687, stiffness: 1e6 N/m^1.5, friction: 0.5, stick stiffness: 1e6 N/m}
)";
  const double angle = std::numbers::pi / 9;
  EXPECT_NEAR(found(slope, "l.friction") + found(slope, "r.friction"), 98.1 * std::sin(angle), 1e-6);
  EXPECT_NEAR(found(slope, "l.normal force") + found(slope, "r.normal force"), 98.1 * std::cos(angle), 1e-6);
  const std::string steep =
      refusal(slope, {"analysis=equilibrium", "machine.forces.l.friction=0.3", "machine.forces.r.friction=0.3"});
  EXPECT_TRUE(holds(steep, "the pose found is no rest: there body 'a'")) << steep;
  std::string without = slope;
  for (const std::string key = ", stick stiffness: 1e6 N/m"; without.find(key) != std::string::npos;)
    without.erase(without.find(key), key.size());
  const std::string fading = refusal(without, {"analysis=equilibrium"});
  EXPECT_TRUE(holds(fading, "give the friction of 'l', 'r' a `stick stiffness`")) << fading;
}

/// Oil that a closed valve locks in: V = V_0 exp(-p/beta) at the pressure that bears the load, while the rod side is
/// fed from the tank. Gauss's rule along the steps leaves less than 1e-12 m.
TEST(Equilibrium, LockedOilHasThePressureOfItsVolume) {
  constexpr const char* jack = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {a: {mass: 1000 kg, inertia: 10 kg m^2, at: 0 1 m}}
  joints: {g: {translational: [ground, a], at: 0 1 m, along: 0 1}}
  forces: {c: {hydraulic cylinder: [ground, a], ends: [0 0 m, 0 1 m], bore: 50 mm, rod: 30 mm, closed length: 0.8 m, stroke: 0.5 m, supply pressure: 20 MPa, rated flow: 40 l/min, valve: 0}}
)";
  const double area = std::numbers::pi / 4 * 0.05 * 0.05, pressure = 9810 / area, dead = 0.1 * 0.5;
  EXPECT_NEAR(found(jack, "a.y"), 1 - (dead + 0.2) * -std::expm1(-pressure / 1.4e9), 1e-11);
  EXPECT_NEAR(found(jack, "c.pressure a"), pressure, 1e-6 * pressure);
}

/// 1 km away rounding of the place is 1e-13 m, 3e-8 N of a stiff beam: that much may stay, and the pose is that of the
/// origin to what it bends the beam by.
TEST(Equilibrium, FarAwayIsThatOfTheOrigin) {
  const auto at = [](double x) {
    const auto place = [&](double px, double py) { return std::to_string(px + x) + " " + std::to_string(py + x / 4); };
    return "subsoil: 1\nmachine:\n  bodies: {b: {mass: 0.8423 kg, inertia: 0.04037 kg m^2, at: " +
           place(0.002644, 0.3734) + " m}}\n  joints: {j: {revolute: [ground, b], at: " + place(-0.063464, 0.29899) +
           " m}}\n  forces: {f: {beam: [ground, b], ends: [" + place(-0.18888, -0.15678) + " m, " +
           place(0.16823, 0.33046) + " m], axial stiffness: 92000 N, bending stiffness: 17 N m^2}}\n";
  };
  const double here = found(at(0), "b.angle");
  EXPECT_GT(std::abs(here), 1e-4);
  EXPECT_NEAR(found(at(1024), "b.angle"), here, 1e-11);
}

/// A pin that shears at 5 N and would bear 2 * 9.81/2 N.
constexpr const char* shear_pin = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {b: {mass: 2 kg, inertia: 0.1 kg m^2, at: 1 0 m}}
  joints: {p: {revolute: [ground, b], at: 0 0 m}, hook: {revolute: [ground, b], at: 2 0 m}}
  events: {e: {opens: hook, reaction above: 5 N}}
  forces: {s: {rotational spring-damper: [ground, b], stiffness: 100 N m/rad}}
time: {end: 1 s}
)";
TEST(Equilibrium, APinThatShearsIsNoRest) {
  EXPECT_TRUE(holds(refusal(shear_pin, {"analysis=equilibrium"}), "hook opens"));
  EXPECT_NEAR(found(shear_pin, "b.angle", {"machine.events.e.reaction above=50 N"}), 0, 1e-12);
}

TEST(Equilibrium, SampledControllersAreRefused) {
  constexpr const char* held = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {a: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0 0 m}}
  joints: {p: {translational: [ground, a], at: 0 0 m, along: 0 1}}
  forces: {s: {spring-damper: [ground, a], ends: [0 -1 m, 0 0 m], stiffness: 1 kN/m, controller: c}}
  measures: {h: {position: a, component: y}}
  controllers: {c: {pid: h, measured in: m, output in: N, set point: 0.02 m, proportional: 3 kN/m}}
)";
  EXPECT_NEAR(found(held, "a.y"), (3000 * 0.02 - 2 * 9.81) / 4000, 1e-9);
  for (const char* analysis : {"analysis=equilibrium", "analysis=modes"})
    EXPECT_TRUE(holds(refusal(held, {analysis, "machine.controllers.c.sample time=10 ms"}),
                      "is of continuous equations, a sampled controller acts from instant to instant"))
        << analysis;
}

/// Driven to and fro by x = A sin(w t): friction turns with it. What it takes in a period is N times the integral of
/// mu(|v|)|v|; each turn, found within a machine step h of 1 ms, errs by N mu A w^2 h^2 at most.
TEST(Kinematics, FrictionThatSticksTurnsWithTheMotion) {
  constexpr const char* driven = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {a: {mass: 3 kg, inertia: 0.1 kg m^2, at: 0 0 m, velocity is: about}}
  joints: {r: {translational: [ground, a], at: 0 0 m, along: 1 0}}
  drivers: {d: {coordinate: a.x, position: {harmonic: {amplitude: 0.1 m, frequency: 2 Hz}}}}
  forces: {f: {joint friction: r, guide: 100 m, mu_s: 0.4, mu_k: 0.2, stick stiffness: 1 MN/m}}
time: {end: 0.5 s}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(driven), dir / "out", {"analysis=kinematics"}), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double w = 4 * std::numbers::pi, N = 3 * 9.81;
  double lost = 0;
  constexpr int parts = 200000;
  for (int k = 0; k < parts; ++k) {
    const double v = 0.1 * w * std::cos(w * 0.5 * (k + 0.5) / parts);
    lost += N * (0.2 + 0.2 * std::exp(-v * v / 1e-4)) * std::abs(v) * 0.5 / parts;
  }
  EXPECT_NEAR(series.at("energy.lost").back(), lost, 4 * N * 0.4 * 0.1 * w * w * 1e-6);
  const std::vector<double>&t = series.at("time"), &v = series.at("a.vx"), &f = series.at("f.force");
  for (std::size_t k = 0; k < t.size(); ++k)
    if (std::abs(v[k]) > 0.1) {
      EXPECT_NEAR(f[k], v[k] > 0 ? -0.2 * N : 0.2 * N, 1e-9) << "t = " << t[k];
    }
}

// Every order chooses the method that has one, its default among them.
TEST(MachineOrder, ChoosesAdamsMoulton) {
  constexpr const char* thrown = R"(subsoil: 1
machine: {bodies: {a: {mass: 3 kg, inertia: 0.1 kg m^2, at: 0 0 m, velocity: 1 0 m/s}}}
time: {end: 10 ms}
)";
  const RunDirectory dir;
  const auto is_fixed = [&](const std::vector<std::string>& set) {
    const auto out = dir / (set.empty() ? "none" : set[0].substr(19));
    EXPECT_EQ(run_scenario(dir.scenario(thrown), out, set), exit_ok);
    return summary_of(out)["run"].contains("machine step error");
  };
  EXPECT_FALSE(is_fixed({}));
  for (const char* order : {"3", "4", "5"})
    EXPECT_TRUE(is_fixed({std::string("time.machine.order=") + order})) << order;
}

TEST(LocatedEvents, CannotBeLeftOutWhereFrictionSticks) {
  EXPECT_TRUE(holds(refusal(block, {"time.machine.locate events=no"}),
                    "cannot be with `stick stiffness` or `restitution` of f"));
}

/// v = ln(1 - t/T): steps towards the pole become ever shorter, and no integrator goes on with them for ever.
TEST(ShortSteps, EndARunThatTheyCannotBringToItsEnd) {
  constexpr const char* pole = R"(subsoil: 1
machine:
  bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}
  forces: {f: {force: a, along x: {expression: 1/(t-0.01), unit: N}}}
time: {end: 20 ms}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(pole), dir / "out"), exit_failed);
  EXPECT_TRUE(holds(summary_of(dir / "out")["run"]["failure"], "steps did not reach 0.01 s"));
}

/// Shorter than a step: its last row is of its end still.
TEST(ShortRuns, EndWithARow) {
  constexpr const char* falls = R"(subsoil: 1
machine: {bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}
time: {end: 1e-12 s}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(falls), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_EQ(series.at("time").back(), 1e-12);
  EXPECT_NEAR(series.at("a.vy").back(), -9.81e-12, 1e-17);
}

/// What is wrong, and what mends it.
TEST(MachineRefusals, NameTheCause) {
  constexpr const char* machine = R"(subsoil: 1
parameters: {reach: 1 m}
machine:
  bodies: {a: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m, angular velocity: 10 rad/s}, b: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m}}
  joints: {A: {revolute: [ground, a], at: 0 0 m}, B: {revolute: [ground, b], at: 0 0 m}}
time: {end: 1 s}
)";
  const auto refused = [&](const std::vector<std::string>& sets) { return refusal(machine, sets); };
  EXPECT_EQ(refused({}), "accepted");
  const std::string clutch =
      refused({"machine.joints.cl={fixed: [a, b], at: 0 0 m}", "machine.bodies.b.angular velocity=-5 rad/s",
               "machine.events={on: {closes: cl, at: 0.5 s}, off: {opens: cl, at: 0.8 s}}"});
  EXPECT_TRUE(holds(clutch, "let joint 'cl', which begins closed, be open: `joint starts: open` at its event"))
      << clutch;
  // It holds other bodies than the one whose start is wrong.
  const std::string beside =
      refused({"machine.bodies.c={mass: 1 kg, inertia: 0.1 kg m^2, at: 3 0 m, angular velocity: 2 rad/s}",
               "machine.joints.slide={translational: [ground, c], at: 3 0 m, along: 1 0}",
               "machine.joints.cl={fixed: [a, b], at: 0 0 m}", "machine.bodies.b.angular velocity=10 rad/s",
               "machine.events={on: {closes: cl, at: 0.5 s}, off: {opens: cl, at: 0.8 s}}"});
  EXPECT_TRUE(holds(beside, "body 'c' spin: given 2, assembled 0")) << beside;
  EXPECT_FALSE(holds(beside, "begins closed")) << beside;
  // A wheel's law is of sinkages below its radius.
  for (const auto& [height, said] : {std::pair("0.25 m", 0), std::pair("-0.1 m", 1)}) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
machine:
  bodies: {{w: {{mass: 60 kg, inertia: 1.5 kg m^2, at: 0 {}}}}}
  forces: {{s: {{wheel on soil: w, radius: 0.25 m, width: 0.1 m, n: 0.8, k_c: 5 kN/m^1.8, k_phi: 900 kN/m^2.8, heave: plastic}}}}
time: {{end: 1 ms}}
)",
                                         height);
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
    const std::string warnings = summary_of(dir / "out")["warnings"].dump();
    EXPECT_EQ(holds(warnings, "the axle begins 0.1 m below the surface"), said == 1) << warnings;
  }
  const std::string pole =
      refused({"machine.drivers={d: {angle: [ground, b], position: {expression: 1/(t-0.51), unit: rad}}}"});
  EXPECT_TRUE(holds(pole, "grows without limit near t = 0.51 s")) << pole;
  const std::string corner =
      refused({"machine.drivers={d: {angle: [ground, b], position: {expression: abs(t-0.51), unit: rad}}}"});
  EXPECT_TRUE(holds(corner, "its rate jumps by 2 rad/s")) << corner;
  const std::string line = refused(
      {"machine.forces={c: {outline contact: [ground, b], first: {flat: 0 -0.15 m}, second: {polygon: [-0.1 -0.1 m, "
       "0.1 -0.1 m, 0 -0.1 m]}, stiffness: 100 kN/m, n: 1}}"});
  EXPECT_TRUE(holds(line, "the polygon's corners lie on one line")) << line;
  const std::string unit = refused({"machine.bodies.b.mass=(2*ms) kg"});
  EXPECT_TRUE(holds(unit, "`ms` is a unit, and stands behind a number; no parameter has its name")) << unit;
}

/// A driver that sets out from rest without gravity: its first millijoules are no reason to stop.
TEST(MachineEnergy, ASlowStartIsNoFailure) {
  for (const char* motion :
       {"position: {expression: 't^3/6', unit: m}", "velocity: {ramp: {to: 1 m/s}}",
        "position: {ramp: {to: 0.1 m, end: 10 s}}", "velocity: {expression: '0.1*sin(pi*t)^2', unit: m/s}"}) {
    const RunDirectory dir;
    const std::string text = std::string(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {a: {mass: 3 kg, inertia: 0.1 kg m^2, at: 0 0 m}}
  joints: {r: {translational: [ground, a], at: 0 0 m, along: 1 0}}
  drivers: {d: {coordinate: a.x, )") +
                             motion + "}}\ntime: {end: 0.2 s}\n";
    EXPECT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok) << motion;
    EXPECT_TRUE(summary_of(dir / "out")["warnings"].empty()) << motion << summary_of(dir / "out")["warnings"];
    const Series series = read_series(dir / "out" / "series.csv");
    const double v = series.at("a.vx").back();
    EXPECT_NEAR(series.at("energy.driver work").back(), 1.5 * v * v, 1e-9) << motion;
  }
}

/// A driven rotor takes a wheel along, or leaves it to the ground, as a point of its rim passes two posts, nearer than
/// 0.12 mm for 0.1 ms, between rows: 6 whole turns and the passage of the first post begun make 13 passages, each opens
/// one joint and closes the other.
TEST(Kinematics, SeesEventsBetweenItsSteps) {
  const std::string rotor = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {p: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0 m, angular velocity: 10 rad/s}, q: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0 m, angular velocity: 10 rad/s}}
  markers: {r: {body: p, at: 0.1 0 m}, A: {at: 0.03307955731798016 0.09447620275840084 m}, B: {at: -0.06542972644844756 -0.07575592978032362 m}}
  joints: {pin: {revolute: [ground, p], at: 0 0 m}, J1: {fixed: [p, q], at: 0 0 m}, J2: {fixed: [ground, q], at: 0 0 m}}
  drivers: {m: {angle: [ground, p], velocity: 10 rad/s}}
  measures: {dA: {distance: [r, A]}, dB: {distance: [r, B]}}
  events:
    a: {opens: J1, measure: dA, below: 0.12 mm, joint starts: closed}
    b: {closes: J2, measure: dA, below: 0.12 mm, joint starts: open}
    c: {opens: J2, measure: dB, below: 0.12 mm}
    d: {closes: J1, measure: dB, below: 0.12 mm}
time: {end: 4 s}
output: {series every: 1 ms}
)";
  double angle = 0;
  for (const char* analysis : {"analysis=kinematics", "analysis=dynamics"}) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(rotor), dir / "out", {analysis}), exit_ok);
    EXPECT_EQ(summary_of(dir / "out")["run"]["events"], 26) << analysis;
    const double found = read_series(dir / "out" / "series.csv").at("q.angle").back();
    if (angle != 0) {
      EXPECT_NEAR(found, angle, 1e-6);
    }
    angle = found;
  }
}

/// The guide of the slider moves with it, so that the rod's force turns it in the guide more and more: with a friction
/// of 0.7 it locks on the way. The failure says so, and rows stand up to there.
TEST(Kinematics, AGuideThatLocksItselfIsNamed) {
  const std::string press = R"(subsoil: 1
analysis: kinematics
machine:
  bodies:
    crank: {mass: 1 kg, inertia: 0.02 kg m^2, at: 0.1 0 m}
    rod: {mass: 2 kg, inertia: 0.05 kg m^2, at: 0.4 -0.15 m, angle: -0.6435011087932844 rad, pose is: about}
    slider: {mass: 3 kg, inertia: 0.1 kg m^2, at: 0.6 -0.3 m, pose is: about}
  joints:
    a: {revolute: [ground, crank], at: 0 0 m}
    b: {revolute: [crank, rod], points: [0.1 0 m, -0.25 0 m]}
    c: {revolute: [rod, slider], points: [0.25 0 m, 0 0 m]}
    guide: {translational: [ground, slider], at: 0.6 -0.3 m, along: 1 0}
  drivers: {d: {angle: [ground, crank], velocity: {ramp: {to: 1 rad/s, end: 0.2 s}}}}
  forces: {rub: {joint friction: guide, guide: 0.2 m, mu_s: 0.7, mu_k: 0.7}}
time: {end: 1.5 s}
output: {series every: 10 ms}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(press), dir / "out"), exit_failed);
  const std::string failure = summary_of(dir / "out")["run"]["failure"];
  EXPECT_TRUE(holds(failure, "joint 'guide' locks itself")) << failure;
  EXPECT_GT(read_series(dir / "out" / "series.csv").at("time").back(), 0.6);
}

/// Oil drawn from a cylinder opens its feed from the tank, which answers within 10 us; a soil step is 43 us. The
/// machine then takes steps of its own, and its energy balance closes; at the steps of the soil it would not, and the
/// failure names the cure.
TEST(Dynamics, OilBesideSoilTakesStepsOfItsOwn) {
  const std::string draw = R"(subsoil: 1
materials: {a: {density: 2500 kg/m^3}, s: {density: 7800 kg/m^3}}
contacts:
  - {between: [a, a], law: linear, k_n: 10 kN/m, restitution: 0.3, mu: 0.4}
  - {between: [a, s], law: linear, k_n: 10 kN/m, restitution: 0.3, mu: 0.4}
soil:
  container: {size: 200 200 60 mm, at: -100 0 -30 mm, material: s, periodic: [z]}
  bed: {fill: lattice, material: a, radius: 9.8 mm, pitch: 20 mm, depth: 40 mm, inside machine: carve}
machine:
  bodies: {arm: {mass: 2 kg, inertia: 0.002 kg m^2, at: 0 100 mm}}
  joints: {rail: {translational: [ground, arm], at: 0 100 mm, along: 1 0}}
  forces:
    oil:
      hydraulic cylinder: [ground, arm]
      ends: [-750 100 mm, 0 100 mm]
      bore: 20 mm
      rod: 10 mm
      closed length: 0.6 m
      stroke: 0.5 m
      flow given: -2 l/min
      dead volume: 0.01 l
  surfaces: {blade: {body: arm, material: s, box: 12 60 30 mm, at: 0 -50 0 mm}}
time: {end: 5 ms}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(draw), dir / "out"), exit_ok);
  const auto energy = summary_of(dir / "out")["energy"];
  EXPECT_LT(energy["machine closure over energy there or moved"].get<double>(), 1e-8);
  EXPECT_GT(energy["lost in the machine [J]"].get<double>(), 1e-4) << "the feed throttles";
  ASSERT_EQ(run_scenario(dir.scenario(draw), dir / "fixed", {"time.machine.integrator=adams-moulton"}), exit_failed);
  const std::string failure = summary_of(dir / "fixed")["run"]["failure"];
  EXPECT_TRUE(holds(failure, "the energy balance of the machine is off")) << failure;
  EXPECT_TRUE(holds(failure, "take `time.machine: {integrator: cvode}`")) << failure;
}

/// I w' = c w^2 from w = 1 rad/s ends at I/c = 0.05 s. Steps shrink with the time that is left, so a count of steps
/// would be met first.
TEST(Dynamics, AMotorThatFeedsTheMotionWithoutBoundIsNamed) {
  const std::string motor = R"(subsoil: 1
analysis: dynamics
machine:
  bodies: {w: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m, spin: 1 rad/s}}
  joints: {j: {revolute: [ground, w], at: 0 0 m}}
  forces: {mot: {torque-speed motor: [ground, w], torque curve: {polynomial: {c2: 2 N m s^2/rad^2}}}}
time: {end: 20 s}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(motor), dir / "out"), exit_failed);
  const std::string failure = summary_of(dir / "out")["run"]["failure"];
  EXPECT_TRUE(holds(failure, "the motion blows up, body 'w'")) << failure;
  EXPECT_TRUE(holds(failure, "so it is the force: `mot` has put in")) << failure;
  EXPECT_FALSE(holds(failure, "stiff,")) << failure;
}

/// A spring of negative stiffness gives its own energy: v = v_0 cosh(t sqrt(k/m)), and no tolerance holds it.
TEST(Dynamics, ASpringOfNegativeStiffnessIsNoMatterOfSteps) {
  const std::string spring = R"(subsoil: 1
machine:
  bodies: {b: {mass: 1 kg, inertia: 0.1 kg m^2, at: 1 0 m}}
  joints: {g: {translational: [ground, b], at: 1 0 m, along: 0 1}}
  forces: {f: {spring-damper: [ground, b], ends: [1 -1 m, 1 0 m], spring curve: {polynomial: {c1: -1 kN/m}}}}
time: {end: 2 s}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(spring), dir / "out"), exit_failed);
  const std::string failure = summary_of(dir / "out")["run"]["failure"];
  EXPECT_TRUE(holds(failure, "the energy balance closes, so the steps resolve it: a stiffness or damping below zero"))
      << failure;
  EXPECT_FALSE(holds(failure, "rtol")) << failure;
}

/// Without a force the summary has no column to follow, and a failure is written all the same.
TEST(Dynamics, ABodyBeyondAllSpeedsWithoutAForceEndsWithAReason) {
  const std::string rotor = R"(subsoil: 1
machine:
  bodies: {w: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m, spin: 2e7 rad/s}}
  joints: {j: {revolute: [ground, w], at: 0 0 m}}
time: {end: 1 s}
)";
  for (const char* integrator : {"cvode", "ida", "adams-moulton"}) {
    const RunDirectory dir;
    const std::string method = std::string("time.machine.integrator=") + integrator;
    ASSERT_EQ(run_scenario(dir.scenario(rotor), dir / "out", {method}), exit_failed) << integrator;
    EXPECT_TRUE(holds(summary_of(dir / "out")["run"]["failure"], "the motion blows up, body 'w'")) << integrator;
  }
  const RunDirectory dir;
  EXPECT_EQ(run_scenario(dir.scenario(rotor), dir / "out", {"machine.bodies.w.spin=1e5 rad/s", "time.end=20 s"}),
            exit_ok)
      << "2e6 rad at a constant rate";
}

/// A block of 2 kg on a guide, held by a formula of its place and velocity.
std::string block_by(const std::string& formula, const std::string& at = "0 0 m") {
  return "subsoil: 1\ngravity: 9.81 m/s^2\nmachine:\n"
         "  bodies: {blk: {mass: 2 kg, inertia: 0.1 kg m^2, at: " +
         at +
         "}}\n"
         "  markers: {c: {body: blk, at: " +
         at +
         "}}\n"
         "  measures: {pos: {position: c, component: x}, vel: {velocity: c, component: x}}\n"
         "  joints: {guide: {translational: [ground, blk], at: 0 0 m, along: 1 0}}\n"
         "  controllers: {pd: {formula: \"" +
         formula +
         "\", output in: N}}\n"
         "  forces: {push: {force: blk, controller: pd}}\n"
         "time: {end: 1 s}\n";
}

/// A force that jumps at the state has no derivative there: the eigenvalues that hang on it are no zeros, and the block
/// is not free. Beside it a smooth force has the mode of its spring, sqrt(800/2)/(2 pi).
TEST(Modes, AForceThatJumpsAtTheStateLeavesThemUndetermined) {
  const auto modes_of = [](const std::string& formula) {
    const RunDirectory dir;
    EXPECT_EQ(run_scenario(dir.scenario(block_by(formula)), dir / "out", {"analysis=modes"}), exit_ok);
    return summary_of(dir / "out");
  };
  for (const char* formula : {"-800*pos - 30*sign(vel)", "-800*pos - 3*sqrt(abs(vel))*sign(vel)",
                              "-800*pos - 10*vel*abs(vel) - 30*sign(vel)"}) {
    const nlohmann::json found = modes_of(formula)["equilibrium"];
    EXPECT_EQ(found["stability"], "undetermined") << formula;
    EXPECT_EQ(found["coordinates that nothing holds"], 0) << formula;
    EXPECT_GT(found["undetermined eigenvalues"], 0) << formula;
  }
  for (const char* formula : {"-800*pos", "-800*pos - 10*vel*abs(vel)"}) {
    const nlohmann::json found = modes_of(formula);
    EXPECT_EQ(found["equilibrium"]["stability"], "stable") << formula;
    EXPECT_EQ(found["equilibrium"]["undetermined eigenvalues"], 0) << formula;
    EXPECT_NEAR(found["modes"][0]["frequency [Hz]"].get<double>(), 20 / (2 * std::numbers::pi), 1e-6) << formula;
  }
  EXPECT_EQ(modes_of("0*pos")["equilibrium"]["coordinates that nothing holds"], 1);
}

TEST(Modes, NameWhatJumps) {
  const auto names = [](const std::string& formula) {
    const std::unique_ptr<mbd::Machine> machine = build_machine(load_scenario_text(block_by(formula)));
    const mbd::MotionState& s = machine->integrator().state();
    return mbd::jumping(machine->system(), 0, {s.q, s.velocity, s.lambda}, Eigen::Vector3d(1, 0, 0));
  };
  const std::vector<std::string> pd{"controller 'pd'"};
  EXPECT_EQ(names("-800*pos - 30*sign(vel)"), pd);
  EXPECT_EQ(names("-800*pos - 3*sqrt(abs(vel))*sign(vel)"), pd);
  EXPECT_EQ(names("-30*sign(pos)"), pd);
  for (const char* smooth : {"-800*pos", "-800*pos - 200*abs(pos)", "-800*pos - 10*vel*abs(vel)", "5 + 0*pos"})
    EXPECT_TRUE(names(smooth).empty()) << smooth;
}

/// What a run warns of.
std::string warnings_of(const RunDirectory& dir, const std::string& text, const std::vector<std::string>& sets) {
  std::ostringstream said;
  const std::shared_ptr<spdlog::logger> usual = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_st>(said)));
  spdlog::set_level(spdlog::level::warn);
  const int code = run({.scenario = dir.scenario(text), .out = dir / "out", .sets = sets, .threads = 1});
  spdlog::set_default_logger(usual);
  EXPECT_EQ(code, exit_ok);
  return said.str();
}

/// The rod side of a locked cylinder at the pressure of its tank: its check valve just closes. The warning advised a
/// smooth force in place of one that jumps.
TEST(Modes, AValveThatJustClosesIsNoJump) {
  const RunDirectory dir;
  const std::string warned = warnings_of(dir, R"(subsoil: 1
analysis: modes
machine:
  bodies: {a: {mass: 200 kg, inertia: 5 kg m^2, at: 0 0 m}}
  joints: {p: {translational: [ground, a], at: 0 0 m, along: 0 1}}
  forces:
    c: {hydraulic cylinder: [ground, a], ends: [0 -0.65 m, 0 0 m], bore: 50 mm, closed length: 0.5 m, stroke: 0.3 m,
        bulk modulus: 1.4 GPa, dead volume: 0.1 l, supply pressure: 12 MPa, rated flow: 20 l/min, valve: 0,
        friction: 3000 N s/m, tank pressure: 100 kPa}
)",
                                         {});
  EXPECT_TRUE(holds(warned, "as where a valve, stop or contact just closes")) << warned;
  EXPECT_FALSE(holds(warned, "tanh")) << warned;
}

/// Two blocks that the same force jumps on: the first mode is free, two hang on the force and have one warning.
TEST(Modes, UndeterminedOnesAreListedOnce) {
  std::string text = block_by("-800*pos - 30*sign(vel)");
  const auto insert = [&](const std::string& before, const std::string& more) {
    text.insert(text.find(before) + before.size(), more);
  };
  insert("bodies: {", "other: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 1 m}, ");
  insert("joints: {", "rail: {translational: [ground, other], at: 0 1 m, along: 1 0}, ");
  insert("forces: {", "pull: {force: other, controller: pd}, ");
  const RunDirectory dir;
  const std::string warned = warnings_of(dir, text, {"analysis=modes"});
  EXPECT_TRUE(holds(warned, "warning: modes 2, 3 are not determined")) << warned;
  EXPECT_TRUE(holds(warned, "controller 'pd' jumps")) << warned;
  EXPECT_EQ(warned.find("not determined"), warned.rfind("not determined")) << warned;
}

/// Two locked cylinders in series: the oil of both is a spring, whatever the masses are.
TEST(Modes, OilHoldsBodiesOfAnyMass) {
  for (const double mid : {0.001, 0.1, 10.0, 100.0}) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies:
    mid: {{mass: {} kg, inertia: 0.1 kg m^2, at: 0 0.7 m}}
    load: {{mass: 500 kg, inertia: 10 kg m^2, at: 0 1.4 m}}
  joints:
    g1: {{translational: [ground, mid], at: 0 0.7 m, along: 0 1}}
    g2: {{translational: [ground, load], at: 0 1.4 m, along: 0 1}}
  forces:
    c1: {{hydraulic cylinder: [ground, mid], ends: [0 0 m, 0 0.7 m], bore: 50 mm, rod: 30 mm, closed length: 0.5 m, stroke: 0.4 m, supply pressure: 20 MPa, rated flow: 30 l/min, valve: 0, start pressure a: 6 MPa, start pressure b: 5 MPa}}
    c2: {{hydraulic cylinder: [mid, load], ends: [0 0.7 m, 0 1.4 m], bore: 40 mm, rod: 20 mm, closed length: 0.5 m, stroke: 0.4 m, supply pressure: 20 MPa, rated flow: 30 l/min, valve: 0, start pressure a: 6 MPa, start pressure b: 5 MPa}}
)",
                                         mid);
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out", {"analysis=modes"}), exit_ok);
    const nlohmann::json found = summary_of(dir / "out");
    EXPECT_EQ(found["equilibrium"]["stability"], "stable") << mid;
    EXPECT_EQ(found["equilibrium"]["coordinates that nothing holds"], 0) << mid;
    EXPECT_EQ(found["modes"].size(), 2U) << mid;
  }
}

/// Steps collapse where the velocity passes zero: no method is the cure.
TEST(StepFailure, NamesTheFormulaThatJumps) {
  for (const char* integrator : {"cvode", "ida"}) {
    const RunDirectory dir;
    const std::string text = block_by("-800*pos - 30*sign(vel)", "0.1 0 m");
    EXPECT_NE(run_scenario(dir.scenario(text), dir / "out", {std::string("time.machine.integrator=") + integrator}),
              exit_ok);
    const std::string end = summary_of(dir / "out")["run"].value("failure", summary_of(dir / "out").dump());
    EXPECT_TRUE(holds(end, "controller 'pd' jumps there")) << end;
    EXPECT_TRUE(holds(end, "tanh(x/w)")) << end;
  }
}

/// A lock that closes on a cart that a driver moves on: no pose agrees with both, and no step is to blame.
TEST(StepFailure, NamesConstraintsThatAskForDifferentMotions) {
  const RunDirectory dir;
  const std::string text = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {cart: {mass: 5 kg, inertia: 1 kg m^2, at: 0 0 m, velocity: 1 0 m/s}}
  joints:
    g: {translational: [ground, cart], at: 0 0 m, along: 1 0}
    lock: {fixed: [ground, cart], at: 0 0 m}
  drivers: {d: {coordinate: cart.x, velocity: 1 m/s}}
  events: {c: {closes: lock, at: 0.5 s}}
time: {end: 1 s}
)";
  for (const char* integrator : {"cvode", "ida", "adams-moulton"}) {
    EXPECT_NE(
        run_scenario(dir.scenario(text), dir / integrator, {std::string("time.machine.integrator=") + integrator}),
        exit_ok);
    const std::string end = summary_of(dir / integrator)["run"].dump();
    EXPECT_TRUE(holds(end, "ask for different motions from here on")) << end;
    EXPECT_TRUE(holds(end, "driver 'd'") && holds(end, "joint 'lock'")) << end;
    EXPECT_FALSE(holds(end, "step is too long")) << end;
  }
}

}  // namespace
}  // namespace subsoil::sim::run_analyses
