// The forces of a machine as a scenario writes them: read, refused with place and cure, copied without loss.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "libmbd/elements.hpp"
#include "libmbd/forces/bushing.hpp"
#include "libmbd/forces/disk_contact.hpp"
#include "libmbd/forces/distance_stop.hpp"
#include "libmbd/forces/drag.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/outline_contact.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/forces/slide_stop.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libsim/scenario/load.hpp"
#include "scenario_samples.hpp"

namespace subsoil::sim::scenario_forces_test {
namespace {

Scenario with(const std::string& force) {
  return load_scenario_text(sample_machine, "arm.yaml", {"machine.forces.f=" + force}).scenario;
}
template <class Force>
Force read(const std::string& force) {
  return with(force).machine->forces.back().element.template get<Force>();
}
/// The first refusal, or "".
std::string refusal(const std::string& force) {
  try {
    with(force);
  } catch (const ScenarioError& e) {
    return e.lines.front();
  }
  return "";
}

TEST(ScenarioForces, SpringWithCurvesAndActuator) {
  const auto s = read<mbd::SpringDamper>(
      "{spring-damper: [sled, arm], ends: [0 0 m, 1 7 m], spring curve: {polynomial: {c1: 3 N/mm, c3: 2 N/mm^3}}, "
      "damper curve: {table: [[-1 m/s, -2 kN], [0 m/s, 0 N], [1 m/s, 1 kN]]}, "
      "actuator force: {harmonic: {amplitude: 5 N, frequency: 2 Hz}}}");
  EXPECT_TRUE(std::isnan(s.stiffness));
  EXPECT_DOUBLE_EQ(s.spring_curve.value(0.002), 3000 * 0.002 + 2e9 * 0.002 * 0.002 * 0.002);
  EXPECT_DOUBLE_EQ(s.damper_curve.value(-1), -2000);
  EXPECT_DOUBLE_EQ(s.damper_curve.value(1), 1000);
  EXPECT_NEAR(s.actuator.value(0.125), 5, 1e-14);
  const auto r = read<mbd::RotationalSpringDamper>(
      "{rotational spring-damper: [sled, arm], stiffness: 1 N m/deg, spring curve: {polynomial: {c3: 4 N m/rad^3}}, "
      "actuator torque: 7 N m}");
  EXPECT_DOUBLE_EQ(r.spring_curve.value(0.5), 0.5);
  EXPECT_EQ(r.actuator.value(0), 7);
  EXPECT_FALSE(r.damper_curve.is_set());
}

TEST(ScenarioForces, BushingAndDrag) {
  const auto b = read<mbd::Bushing>(
      "{bushing: [sled, arm], at: 1 1.5 m, turn: 90 deg, stiffness x: 2 kN/mm, stiffness y: 1 kN/mm, "
      "rotational stiffness: 3 N m/rad, damping x: 5 N s/m, preload y: 4 N}");
  EXPECT_EQ(b.stiffness_x, 2e6);
  EXPECT_EQ(b.stiffness_turn, 3);
  EXPECT_EQ(b.preload_y, 4);
  EXPECT_NEAR(b.p_b[0], -0.5, 1e-15);  // as a pin's `at`: the arm stands upright
  EXPECT_NEAR(b.turn, 1.5707963267948966, 1e-15);
  const auto d = read<mbd::Drag>(
      "{drag: arm, at: 1 2.5 m, quadratic: 0.6 N s^2/m^2, linear rotational: 2 N m s/rad, wind along x: 5 m/s}");
  EXPECT_EQ(d.quadratic, 0.6);
  EXPECT_EQ(d.linear_turn, 2);
  EXPECT_EQ(d.wind_x.value(1), 5);
  EXPECT_NEAR(d.point[0], 0.5, 1e-15);
}

TEST(ScenarioForces, ContactsAndStopsWithTheirOwnExponent) {
  const auto l = read<mbd::LineContact>(
      "{line contact: [ground, arm], ends: [0 0 m, 1 1.5 m], along: [1, 0], radius: 20 mm, stiffness: 3 kN/mm^1.5, "
      "damping: 0.2 s/m, friction: 0.4, slip speed: 2 mm/s}");
  EXPECT_EQ(l.law.normal.n, 1.5);
  EXPECT_NEAR(l.law.normal.stiffness, 3e3 * std::pow(1e3, 1.5), 1e-6);
  EXPECT_EQ(l.law.normal.damping, 0.2);
  EXPECT_EQ(l.law.slip_speed, 0.002);
  EXPECT_NEAR(l.p_b[0], -0.5, 1e-15);
  const auto d = read<mbd::DiskContact>(
      "{disk contact: [sled, arm], ends: [0 0.5 m, 1 2 m], first radius: 1 m, second radius: 0.4 m, side: inside, "
      "n: 1, stiffness: 3 kN/m}");
  EXPECT_EQ(d.side, mbd::DiskSide::inside);
  EXPECT_EQ(d.law.normal.stiffness, 3000);
  const auto r = read<mbd::RotationalStop>(
      "{rotational stop: [sled, arm], minimum: 45 deg, maximum: 2 rad, n: 1, stiffness: 9 N m/rad, damping: 0.1 "
      "s/rad}");
  EXPECT_NEAR(r.limits.least, 0.78539816339744831, 1e-15);
  EXPECT_EQ(r.limits.law.stiffness, 9);
  const auto s =
      read<mbd::SlideStop>("{slide stop: [ground, sled], along: [1, 0], maximum: 0.4 m, n: 2, stiffness: 9 N/mm^2}");
  EXPECT_DOUBLE_EQ(s.limits.law.stiffness, 9e6);
  EXPECT_TRUE(std::isnan(s.limits.least));
  const auto t = read<mbd::DistanceStop>(
      "{distance stop: [ground, arm], ends: [0 3 m, 1 2 m], maximum: 2 m, stiffness: 9 kN/m^(n)}");
  EXPECT_EQ(t.limits.largest, 2);
  EXPECT_EQ(t.limits.law.stiffness, 9000);
}

TEST(ScenarioForces, RefusalsNamePlaceRuleAndCure) {
  const std::string at = "--set machine.forces.f";
  EXPECT_EQ(refusal("{spring-damper: [sled, arm], ends: [0 0 m, 1 7 m]}"),
            at + ": stiffness and damping must be given and not negative; stiffness 0 is a damper alone");
  EXPECT_EQ(refusal("{spring-damper: [sled, arm], ends: [0 0 m, 1 7 m], spring curve: {tabel: []}}"),
            at + ".spring curve = {tabel: []}: does not say what it is; did you mean `table`?");
  EXPECT_EQ(refusal("{spring-damper: [sled, arm], ends: [0 0 m, 1 7 m], spring curve: {polynomial: {c3: 2 N/m}}}"),
            at +
                ".spring curve.polynomial.c3 = 2 N/m: `N/m` is a stiffness (kg s^-2), but needed is kg m^-2 s^-2, such "
                "as (N)/(m)^3");
  EXPECT_EQ(refusal("{spring-damper: [sled, arm], ends: [0 0 m, 1 7 m], spring curve: {table: [[0 m, 0 N]]}}"),
            at + ".spring curve = {table: [[0 m, 0 N]]}: table characteristic: needs at least two points, each with x "
                 "and value");
  EXPECT_NE(refusal("{rotational spring: [sled, arm], stiffness: 1 N m/rad}").find("`rotational spring-damper`?"),
            std::string::npos)
      << "not rotational stop, which is nearer by letters";
  EXPECT_EQ(refusal("{bushing: [sled, arm], at: 0 0 m, stiffness x: 1 N/m}"),
            at + ".stiffness y: is missing: force per offset along its y axis, in N/m");
  EXPECT_EQ(refusal("{drag: arm, quadratic: -1 N s^2/m^2}"),
            at + ".quadratic = -1 N s^2/m^2: must be in [0, inf) N s^2/m^2");
  EXPECT_EQ(refusal("{line contact: [ground, arm], ends: [0 0 m, 1 2 m], along: [1, 0], n: 0.5, stiffness: 1 N/m}"),
            at + ".n = 0.5: must be in [1, inf)");
  EXPECT_EQ(refusal("{disk contact: [sled, arm], ends: [0 0 m, 1 2 m], first radius: 1 m, second radius: 1 m, "
                    "side: inside, n: 1, stiffness: 1 N/m}"),
            at + ": the second radius must be less than the first for a disk inside a bore");
  EXPECT_EQ(refusal("{rotational stop: [sled, arm], n: 1, stiffness: 1 N m/rad}"),
            at + ": needs a stop: give minimum, maximum or both");
  EXPECT_EQ(refusal("{slide stop: [sled, arm], along: [1, 0], minimum: 1 m, maximum: 0 m, n: 1, stiffness: 1 N/m}"),
            at + ": minimum must be below maximum; for a fixed value use a joint or a driver");
  EXPECT_EQ(refusal("{distance stop: [sled, arm], ends: [0 0 m, 1 2 m], maximum: 1 m, n: 1}"),
            at + ".stiffness: is missing: force per depth^n, in N/m^(n)");
  const std::string motor =
      "{torque-speed motor: [sled, arm], torque curve: {table: [[0 rad/s, 3 N m], [9 rad/s, 0 N "
      "m]]}, share: ";
  EXPECT_EQ(refusal(motor + "3}"), at + ".share = 3: must be from -1 to 1");
  EXPECT_EQ(refusal(motor + "{ramp: {to: 3}}}"), "") << "a function of time saturates";
  EXPECT_EQ(refusal(motor + "{ramp: {end: 1 s}}}"),
            at + ".share = {ramp: {end: 1 s}}: ramp function: has no effect, `from` and `to` are equal; give `to`");
  EXPECT_EQ(
      refusal("{hydraulic cylinder: [sled, arm], ends: [0 0 m, 1 7 m], bore: 50 mm, closed length: 0.6 m, stroke: "
              "9 m, supply pressure: 18 MPa, rated flow: 30 l/min, valve: -5}"),
      at + ".valve = -5: must be from -1 to 1");
  EXPECT_EQ(refusal("{joint friction: slide, guide: 0.2 m, mu_s: 0.1, mu_k: 0.2}"),
            at + ".mu_k = 0.2: must be given, not negative and at most mu_s; equal values are Coulomb's friction");
}

/// An outline contact of a floor with this second outline, and the rest of its keys.
std::string over_floor(const std::string& second, const std::string& rest = "stiffness: 3 kN/mm^1.5") {
  return "{outline contact: [ground, arm], first: {flat: 0 0 m, direction: 0 deg}, second: {" + second + "}, " + rest +
         "}";
}

TEST(ScenarioForces, OutlineContactWithEveryOutline) {
  const auto disk = read<mbd::OutlineContact>(
      over_floor("disk: 20 mm, centre: 1 2 mm", "stiffness: 3 kN/mm^1.5, damping: 0.2 s/m, friction: 0.4"));
  EXPECT_EQ(std::get<mbd::FlatOutline>(disk.first).angle, 0);
  EXPECT_EQ(std::get<mbd::DiskOutline>(disk.second).radius, 0.02);
  EXPECT_EQ(std::get<mbd::DiskOutline>(disk.second).centre, (std::array<double, 2>{1e-3, 2e-3}));
  EXPECT_NEAR(disk.law.normal.stiffness, 3e3 * std::pow(1e3, 1.5), 1e-6);
  EXPECT_EQ(disk.law.normal.damping, 0.2);
  EXPECT_EQ(disk.law.friction, 0.4);
  EXPECT_EQ(disk.law.slip_speed, 1e-3);
  const auto polygon = std::get<mbd::PolygonOutline>(
      read<mbd::OutlineContact>(over_floor("polygon: [0 0 mm, 9 0 mm, 9 9 mm], corner radius: 1 mm")).second);
  EXPECT_EQ(polygon.points.size(), 3U);
  EXPECT_EQ(polygon.corner_radius, 1e-3);
  const auto profile = std::get<mbd::ProfileOutline>(
      read<mbd::OutlineContact>(over_floor("profile: [[0 deg, 10 mm], [120 deg, 12 mm], [240 deg, 11 mm]]")).second);
  EXPECT_EQ(profile.radii, (std::vector<double>{0.01, 0.012, 0.011}));
  const auto flank = std::get<mbd::FlankOutline>(
      read<mbd::OutlineContact>("{outline contact: [ground, arm], first: {flank: [0 0 mm, 10 5 mm, 20 0 mm]}, second: "
                                "{disk: 50 mm}, stiffness: 3 kN/mm^1.5}")
          .first);
  EXPECT_EQ(flank.points.size(), 3U);
  EXPECT_FALSE(flank.closed);
}

TEST(ScenarioForces, OutlineContactRefusesEveryKeyWithRuleAndCure) {
  const std::string at = "--set machine.forces.f", disk = "disk: 20 mm", second = at + ".second";
  struct Case {
    std::string force, refusal;
  };
  for (const Case& c : std::vector<Case>{
           {"{outline contact: [ground], first: {disk: 1 m}, second: {disk: 1 m}, stiffness: 1 N/m^1.5}",
            at + ".outline contact = [ground]: must be two bodies, such as [frame, shovel] or [ground, trolley]"},
           {"{outline contact: [arm, arm], first: {disk: 1 m}, second: {disk: 1 m}, stiffness: 1 N/m^1.5}",
            at + ".outline contact = [arm, arm]: the two bodies must differ"},
           {"{outline contact: [ground, leg], first: {disk: 1 m}, second: {disk: 1 m}, stiffness: 1 N/m^1.5}",
            at + ".outline contact = [ground, leg]: there is no body of this name; did you mean `sled`?"},
           {"{outline contact: [ground, arm], second: {disk: 1 m}, stiffness: 1 N/m^1.5}",
            at + ".first: is missing: the outline of the first body"},
           {"{outline contact: [ground, arm], first: {disk: 1 m}, stiffness: 1 N/m^1.5}",
            second + ": is missing: the outline of the second body"},
           {"{outline contact: [ground, arm], first: {disk: 1 m}, second: [1, 2], stiffness: 1 N/m^1.5}",
            second + " = [1, 2]: must be a mapping: `key: value` lines, or {key: value, ...}"},
           {"{outline contact: [ground, arm], first: {flat: 0 m}, second: {disk: 1 m}, stiffness: 1 N/m^1.5}",
            at + ".first.flat = 0 m: holds 1 numbers; needed are 2"},
           {"{outline contact: [ground, arm], first: {flat: 0 0 m, direction: 0 m}, second: {disk: 1 m}, stiffness: 1 "
            "N/m^1.5}",
            at + ".first.direction = 0 m: `m` is a length (m), but needed is an angle, such as deg or rad"},
           {"{outline contact: [ground, arm], first: {flank: [20 0 mm, 10 5 mm, 0 0 mm]}, second: {disk: 50 mm}, "
            "stiffness: 1 N/m^1.5}",
            at + ": a radius of 0.050000 m does not fit into the curve's hollow of radius 0.006667 m; take a smaller "
                 "one, or widen the hollow"},
           {over_floor("disc: 20 mm"), second + " = {disc: 20 mm}: does not say what it is; did you mean `disk`?"},
           {over_floor("disk: -20 mm"), second + ".disk = -20 mm: must be in (0, inf) m"},
           {over_floor("disk: 20"), second + ".disk = 20: has no unit; needed is a length (m), such as m"},
           {over_floor("disk: 20 mm, center: 0 0 m"), second + ".center = 0 0 m: unknown key; did you mean `centre`?"},
           {over_floor("disk: 20 mm, flat: 0 0 m"),
            second + " = {disk: 20 mm, flat: 0 0 m}: holds two types; keep one of them"},
           {over_floor("polygon: [0 0 mm, 1 0 mm]"),
            second + ".polygon = [0 0 mm, 1 0 mm]: an outline needs at least three points"},
           {over_floor("polygon: [0 0 mm, 1 1 mm, 1 0 mm, 0 1 mm]"),
            second + ": side 1 of the polygon meets another side; list its corners once around in order"},
           {over_floor("polygon: [0 0 mm, 1 0 mm, 1 1 mm], corner radius: 5 mm"),
            second + ": the corner radius leaves nothing of side 1 of the polygon; take a smaller one"},
           {over_floor("polygon: [0 0 mm, 1 0 mm, 1 1 mm], corner radius: -1 mm"),
            second + ".corner radius = -1 mm: must be in [0, inf) m"},
           {over_floor("profile: [[0 deg, 10 mm], [120 deg, 12 mm]]"),
            second + ": a profile needs at least three points"},
           {over_floor("profile: [[0 deg, 9 mm], [240 deg, 9 mm], [120 deg, 8 mm], [300 deg, 9 mm]]"),
            second + ": angles must increase; point 3 does not come after the one before"},
           {over_floor("flat: 0 0 m, direction: 0 deg"),
            at + ": two outlines that are both curves or flat have no point that can touch; give one of them as a "
                 "polygon or disk, or a flat's partner as a closed profile"},
           {over_floor(disk, "friction: 0"), at + ".stiffness: is missing: force per depth^n, in N/m^(n)"},
           {over_floor(disk, "stiffness: 0 N/m^1.5"), at + ".stiffness = 0 N/m^1.5: must be in (0, inf) N/m^(n)"},
           {over_floor(disk, "stiffness: 3 N/m"),
            at + ".stiffness = 3 N/m: `N/m` is a stiffness (kg s^-2), but needed is kg m^-0.5 s^-2, such as N/m^(n)"},
           {over_floor(disk, "stiffness: 1 N/m^1.5, damping: -1 s/m"),
            at + ".damping = -1 s/m: must be in [0, inf) s/m"},
           {over_floor(disk, "stiffness: 1 N/m^1.5, friction: -0.1"), at + ".friction = -0.1: must be in [0, inf)"},
           {over_floor(disk, "stiffness: 1 N/m^1.5, slip speed: 0 m/s"),
            at + ".slip speed = 0 m/s: must be in (0, inf) m/s"},
           {over_floor(disk, "stiffness: 1 N/m^1.5, n: 0.5"), at + ".n = 0.5: must be in [1, inf)"}})
    EXPECT_EQ(refusal(c.force), c.refusal) << c.force;
  const std::string crossed = refusal(over_floor("flank: [0 0 mm, 2 0 mm, 2 1 mm, 1 -1 mm, 0 1 mm]"));
  EXPECT_TRUE(crossed.starts_with(second + ": the flank crosses itself near ")) << crossed;
  EXPECT_TRUE(crossed.ends_with("end it before, or part it in two contacts")) << crossed;
  const std::string no_file = refusal(over_floor("polygon: nothing.csv"));
  EXPECT_TRUE(no_file.starts_with(second + ".polygon = nothing.csv: there is no file ")) << no_file;
}

// The copy with every default explicit reads back to the same text, so to the same values.
TEST(ScenarioForces, CopyReadsBackTheSame) {
  for (const char* force :
       {"{spring-damper: [sled, arm], ends: [0 0 m, 1 7 m], spring curve: {polynomial: {c1: 3 N/mm, c3: 2 N/mm^3}}, "
        "damper curve: {table: [[-1 m/s, -2 kN], [1 m/s, 1 kN]]}, actuator force: [1 N, {ramp: {to: 3 N}}]}",
        "{rotational spring-damper: [sled, arm], spring curve: {table: [[0 deg, 0 N m], [7 deg, 1 N m]]}}",
        "{bushing: [sled, arm], at: 1 1.5 m, stiffness x: 2 kN/mm, stiffness y: 1 kN/mm, free angle: 3 deg}",
        "{drag: arm, at: 1 2.5 m, quadratic: 0.6 N s^2/m^2, wind along y: {harmonic: {amplitude: 1 km/h}}}",
        "{line contact: [ground, arm], ends: [0 0 m, 1 1.5 m], along: [1, 2], stiffness: 3 kN/mm^1.5, friction: 0.4}",
        "{disk contact: [sled, arm], ends: [0 0.5 m, 1 2 m], first radius: 1 m, second radius: 0.4 m, side: inside, "
        "n: 1.1, stiffness: 3 kN/mm^1.1}",
        "{rotational stop: [sled, arm], minimum: 45 deg, n: 1.3, stiffness: 9 N m/rad^1.3}",
        "{slide stop: [ground, sled], along: [1, 3], maximum: 0.4 m, stiffness: 9 N/mm^1.5}",
        "{distance stop: [ground, arm], ends: [0 3 m, 1 2 m], minimum: 1 mm, n: 2, stiffness: 9 kN/m^2}",
        "{outline contact: [ground, arm], first: {polygon: [0 0 mm, 9 0 mm, 9 9 mm], corner radius: 1 mm}, second: "
        "{profile: [[0 deg, 10 mm], [120 deg, 12 mm], [240 deg, 11 mm]], centre: 1 2 mm}, stiffness: 9 kN/m^1.5}",
        "{outline contact: [ground, arm], first: {flank: [0 0 mm, 10 5 mm, 20 0 mm]}, second: {disk: 4 mm}, stiffness: "
        "9 kN/m^1.5, friction: 0.2}"}) {
    const std::string copy = write_scenario(with(force));
    Scenario again;
    ASSERT_NO_THROW(again = load_scenario_text(copy, "copy.yaml").scenario) << copy;
    EXPECT_EQ(write_scenario(again), copy);
  }
}

}  // namespace
}  // namespace subsoil::sim::scenario_forces_test
