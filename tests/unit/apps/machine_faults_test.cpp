// Mechanisms that cannot be: each refusal has file and line of what is wrong, the rule and the cure.
#include <gtest/gtest.h>

#include <string>

#include "libsim/scenario/load.hpp"
#include "libsim/setup/machine.hpp"

namespace subsoil::sim::machine_faults_test {
namespace {

/// What reading and building a scenario says; it is read as `rig.yaml`.
std::string refusal(const std::string& text) {
  try {
    build_machine(load_scenario_text(text, "rig.yaml"));
  } catch (const ScenarioError& error) {
    std::string all;
    for (const std::string& line : error.lines) all += (all.empty() ? "" : "\n") + line;
    return all;
  }
  return "accepted";
}

/// A slider-crank; line 5 is the crank, 9 the main bearing, 14 the motor. One thing in it is changed.
std::string slider_crank(const std::string& what = "", const std::string& by = "") {
  std::string text = R"(subsoil: 1
time: {end: 1 s}
machine:
  bodies:
    crank: {mass: 1 kg, inertia: 0.001 kg m^2, at: 0.05 0 m}
    rod: {mass: 1 kg, inertia: 0.0133 kg m^2, at: 0.3 0 m}
    slider: {mass: 2 kg, inertia: 0.01 kg m^2, at: 0.5 0 m}
  joints:
    bearing: {revolute: [ground, crank], at: 0 0 m}
    crank pin: {revolute: [crank, rod], at: 0.1 0 m}
    wrist pin: {revolute: [rod, slider], at: 0.5 0 m}
    guide: {translational: [ground, slider], at: 0.5 0 m, along: 1 0}
  drivers:
    motor: {angle: [ground, crank], velocity: 20 rad/s}
)";
  if (const std::size_t at = text.find(what); !what.empty() && at != std::string::npos)
    text.replace(at, what.size(), by);
  return text;
}

TEST(MachineFaults, TheMechanismItselfIsAccepted) { EXPECT_EQ(refusal(slider_crank()), "accepted"); }

TEST(MachineFaults, MassAndInertiaMustBePositive) {
  EXPECT_EQ(refusal(slider_crank("crank: {mass: 1 kg", "crank: {mass: 0 kg")),
            "rig.yaml:5:19 machine.bodies.crank.mass = 0 kg: must be in (0, inf) kg");
  EXPECT_EQ(refusal(slider_crank("crank: {mass: 1 kg", "crank: {mass: -1 kg")),
            "rig.yaml:5:19 machine.bodies.crank.mass = -1 kg: must be in (0, inf) kg");
  EXPECT_EQ(refusal(slider_crank(", inertia: 0.0133 kg m^2", "")),
            "rig.yaml:6:10 machine.bodies.rod.inertia: is missing: moment of inertia about the centre of "
            "mass, in kg m^2");
  EXPECT_EQ(refusal(slider_crank("0.0133 kg m^2", "0 kg m^2")),
            "rig.yaml:6:32 machine.bodies.rod.inertia = 0 kg m^2: must be in (0, inf) kg m^2");
}

TEST(MachineFaults, AJointNeedsTwoBodies) {
  EXPECT_EQ(refusal(slider_crank("[crank, rod]", "[rod, rod]")),
            "rig.yaml:10:27 machine.joints.crank pin.revolute = [rod, rod]: the two bodies must differ");
}

TEST(MachineFaults, DriversThatContradictEachOther) {
  const std::string two =
      slider_crank("20 rad/s}\n", "20 rad/s}\n    push: {coordinate: crank.angle, velocity: 10 rad/s}\n");
  EXPECT_EQ(refusal(two),
            "rig.yaml:14:12 machine.drivers.motor: the velocities asked of the machine contradict each other: driver "
            "'motor' by -5 rad/s, driver 'push' by 5 rad/s off. Over-determined by driver 'motor' and driver 'push': "
            "drop a driver or free a joint.");
}

TEST(MachineFaults, DriversThatHoldDifferentPlaces) {
  const std::string two =
      slider_crank("20 rad/s}\n", "20 rad/s}\n    push: {coordinate: crank.angle, position: 0.3 rad}\n");
  EXPECT_EQ(refusal(two),
            "rig.yaml:14:12 machine.drivers.motor: the machine cannot be assembled: driver 'motor' by 0.15 rad, driver "
            "'push' by -0.15 rad open. Over-determined by driver 'motor' and driver 'push': drop a driver or free a "
            "joint.");
}

// The rod is 0.4 m, the guide 1 m above the crank: no turn of anything closes it.
// Its direction is lost there; the motion is known before the run.
TEST(MachineFaults, ADistanceDrivenToNothing) {
  const std::string text = R"(subsoil: 1
machine:
  bodies: {m: {mass: 1 kg, inertia: 0.1 kg m^2, at: 1 0 m}}
  drivers:
    d: {distance: [ground, m], ends: [0 0 m, 1 0 m], velocity: -0.5 m/s}
)";
  EXPECT_EQ(
      refusal(text + "time: {end: 3 s}\n"),
      "rig.yaml:5:8 machine.drivers.d: its motion brings the distance to 0 by t = 2.0001 s, where it has no "
      "direction; must stay above 0 until time.end = 3 s: end the motion or the run before, or let the ends start "
      "farther apart");
  EXPECT_EQ(refusal(text + "time: {end: 1.9 s}\n"), "accepted");
}

/// A slide and what moves it, from rest at 0 on until 1 s.
std::string moved_by(const std::string& motion) {
  return R"(subsoil: 1
machine:
  bodies: {m: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m, pose is: about, velocity is: about}}
  joints: {guide: {translational: [ground, m], at: 0 0 m, along: 1 0}}
  drivers:
    d: {coordinate: m.x, )" +
         motion + "}\ntime: {end: 1 s}\n";
}

// Integrators would step across, with the motion of everything else as if nothing had happened.
TEST(MachineFaults, MotionsThatJump) {
  const std::string rule = "a body has a mass, so its velocity must be continuous: ";
  const std::string ramp = rule + "let a `ramp` of some milliseconds lead from one to the other";
  EXPECT_EQ(refusal(moved_by("position: {expression: '0.1*sign(t - 0.5)', unit: m}")),
            "rig.yaml:6:36 machine.drivers.d.position: jumps by 0.2 m at t = 0.5 s, from -0.1 to 0.1 m; " + ramp);
  EXPECT_EQ(refusal(moved_by("velocity: {expression: 'sign(t - 0.5)', unit: m/s}")),
            "rig.yaml:6:36 machine.drivers.d.velocity: jumps by 2 m/s at t = 0.5 s, from -1 to 1 m/s; " + ramp);
  EXPECT_EQ(refusal(moved_by("position: {expression: 'abs(t - 0.25)', unit: m}")),
            "rig.yaml:6:36 machine.drivers.d.position: its rate jumps by 2 m/s at t = 0.25 s, from -1 to 1 m/s; " +
                rule + "give the velocity in its place, as a `ramp` or a table, or round the corner off");
  EXPECT_EQ(refusal(moved_by("velocity: {expression: 'sign(t)', unit: m/s}")),
            "rig.yaml:6:36 machine.drivers.d.velocity: jumps by 1 m/s at t = 0 s, from 0 to 1 m/s, right after the "
            "start; " +
                ramp);
}

// Kinematics asks where bodies are; a position that jumps has no answer.
TEST(MachineFaults, KinematicsTakesCornersAndNoJumps) {
  const auto kinematic = [](const std::string& motion) {
    return "subsoil: 1\nanalysis: kinematics\n" + moved_by(motion).substr(std::string("subsoil: 1\n").size());
  };
  EXPECT_EQ(refusal(kinematic("position: {expression: 'abs(t - 0.25)', unit: m}")), "accepted");
  EXPECT_EQ(refusal(kinematic("velocity: {expression: 'sign(t - 0.5)', unit: m/s}")), "accepted");
  EXPECT_NE(
      refusal(kinematic("position: {expression: '0.1*sign(t - 0.5)', unit: m}")).find("jumps by 0.2 m at t = 0.5 s"),
      std::string::npos);
}

// Beyond its last point a table holds its last value: a motion that ends in full travel stops dead.
TEST(MachineFaults, TablesOfPositionsThatEndBeforeTheRun) {
  const std::string text = moved_by("position: {table: {points: [[0 s, 0 m], [0.25 s, 0.1 m], [0.5 s, 0.4 m]]}}");
  // A natural spline over two intervals h: y'' = 3 (y1 - 2 y2 + y3)/(2 h^2) at the middle, 0 at both ends.
  EXPECT_EQ(refusal(text),
            "rig.yaml:6:36 machine.drivers.d.position: its rate jumps by 1.4 m/s at t = 0.5 s, from 1.4 to 0 m/s; a "
            "body has a mass, so its velocity must be continuous: the table ends there, and its last value holds from "
            "then on: give it points until time.end = 1 s, or, with `between: monotone`, the last value twice");
  EXPECT_EQ(refusal(moved_by("position: {table: {points: [[0 s, 0 m], [0.5 s, 0.1 m], [1 s, 0.4 m]]}}")), "accepted");
  EXPECT_EQ(refusal(moved_by("position: {table: {points: [[0 s, 0 m], [0.2 s, 0.1 m], [0.4 s, 0.1 m]], between: "
                             "monotone}}")),
            "accepted");
}

TEST(MachineFaults, StepsWithoutNumber) {
  EXPECT_NE(refusal(slider_crank("{end: 1 s}", "{end: 1 s, machine: {step: 1 ps}}"))
                .find("rig.yaml:2:34 time.machine.step = 1e-12 s: makes 1e+12 steps until 1 s; at most 1e+10"),
            std::string::npos)
      << refusal(slider_crank("{end: 1 s}", "{end: 1 s, machine: {step: 1 ps}}"));
  EXPECT_EQ(refusal(slider_crank("{end: 1 s}", "{end: 1 s, machine: {step: 1 ns}}")), "accepted");
}

TEST(MachineFaults, OutOfReach) {
  const std::string text = refusal(slider_crank("guide: {translational: [ground, slider], at: 0.5 0 m, along: 1 0}",
                                                "guide: {translational: [ground, slider], points: [0 1 m, 0 0 m], "
                                                "along: 1 0}"));
  EXPECT_EQ(text.find("rig.yaml:"), 0U) << text;
  EXPECT_NE(text.find(" machine.joints."), std::string::npos) << text;
  EXPECT_NE(text.find("the machine cannot be assembled: "), std::string::npos) << text;
  EXPECT_NE(text.find("joint 'guide' by "), std::string::npos) << text;
}

// A body that nothing holds is a free body, not a fault.
TEST(MachineFaults, ALooseBodyFlies) {
  EXPECT_EQ(refusal(slider_crank("  joints:\n", "    stone: {mass: 1 kg, inertia: 1 kg m^2, at: 0 3 m}\n  joints:\n")),
            "accepted");
}

/// A joint that opens and closes is closed at the start; here it is meant to be caught on the way.
TEST(MachineFaults, AJointThatIsFarOpenMayBeMeantToStartOpen) {
  const std::string text = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {rod: {mass: 2 kg, inertia: 0.2 kg m^2, at: 0 0 m}}
  markers: {tip: {body: rod, at: 0.5 0 m}}
  measures: {tx: {position: tip, component: x}}
  joints: {hook: {revolute: [ground, rod], points: [0.8 0.2 m, 0.5 0 m]}, rail: {fixed: [ground, rod], at: 0 0 m}}
  events: {catch: {closes: hook, measure: tx, above: 0.8 m}, free: {opens: hook, at: 0.9 s}}
time: {end: 1 s}
)";
  const std::string said = refusal(text);
  EXPECT_NE(said.find("Where joint 'hook' is to close on the way only, give an event of it `joint starts: open`."),
            std::string::npos)
      << said;
  std::string open = text;
  open.replace(open.find("above: 0.8 m"), 12, "above: 0.8 m, joint starts: open");
  EXPECT_EQ(refusal(open), "accepted");
}

/// The unit of a number is 1, or left out.
TEST(MachineFaults, TheUnitOfAFormulaMayBeOne) {
  const auto motor = [](const std::string& share) {
    return refusal(
        "subsoil: 1\ntime: {end: 1 s}\nmachine:\n  bodies: {a: {mass: 5 kg, inertia: 1 kg m^2, at: 0 0 m}}\n"
        "  joints: {g: {revolute: [ground, a], at: 0 0 m}}\n"
        "  forces: {m: {torque-speed motor: [ground, a], torque curve: {table: {points: [[0 rpm, 10 N m], "
        "[100 rpm, 0 N m]]}}, share: " +
        share + "}}\n");
  };
  EXPECT_EQ(motor("{expression: \"0.5*sin(t)\", unit: 1}"), "accepted");
  EXPECT_EQ(motor("{expression: \"0.5*sin(t)\"}"), "accepted");
  EXPECT_NE(motor("{expression: \"0.5*sin(t)\", unit: 2}").find("must be a unit alone"), std::string::npos);
  EXPECT_NE(motor("{expression: \"0.5*sin(t)\", unit: kg}").find("is a mass"), std::string::npos);
}

/// A root begins with an infinite rate; nothing is read before the run.
TEST(MachineFaults, AMotionIsLookedAtWithinTheRun) {
  const std::string said =
      refusal(slider_crank("velocity: 20 rad/s", "position: {expression: \"0.01*sqrt(t)\", unit: rad}"));
  EXPECT_NE(said.find("machine.drivers.motor.position: its rate jumps"), std::string::npos) << said;
  EXPECT_NE(said.find("right after the start"), std::string::npos) << said;
  EXPECT_EQ(said.find("t = -"), std::string::npos) << said;
}

}  // namespace
}  // namespace subsoil::sim::machine_faults_test
