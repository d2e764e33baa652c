// The forces of a machine as a scenario writes them: read, refused with place and cure, copied without loss.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "apps/scenario/load.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/forces/bushing.hpp"
#include "libmbd/forces/disk_contact.hpp"
#include "libmbd/forces/distance_stop.hpp"
#include "libmbd/forces/drag.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/forces/slide_stop.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "scenario_samples.hpp"

namespace subsoil::app::scenario_forces_test {
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
      "stiffness in turn: 3 N m/rad, damping x: 5 N s/m, preload y: 4 N}");
  EXPECT_EQ(b.stiffness_x, 2e6);
  EXPECT_EQ(b.stiffness_turn, 3);
  EXPECT_EQ(b.preload_y, 4);
  EXPECT_NEAR(b.p_b[0], -0.5, 1e-15);  // as a pin's `at`: the arm stands upright
  EXPECT_NEAR(b.turn, 1.5707963267948966, 1e-15);
  const auto d = read<mbd::Drag>(
      "{drag: arm, at: 1 2.5 m, quadratic: 0.6 N s^2/m^2, linear in turn: 2 N m s/rad, wind along x: 5 m/s}");
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
      "{rotational stop: [sled, arm], least: 45 deg, largest: 2 rad, n: 1, stiffness: 9 N m/rad, damping: 0.1 s/rad}");
  EXPECT_NEAR(r.limits.least, 0.78539816339744831, 1e-15);
  EXPECT_EQ(r.limits.law.stiffness, 9);
  const auto s =
      read<mbd::SlideStop>("{slide stop: [ground, sled], along: [1, 0], largest: 0.4 m, n: 2, stiffness: 9 N/mm^2}");
  EXPECT_DOUBLE_EQ(s.limits.law.stiffness, 9e6);
  EXPECT_TRUE(std::isnan(s.limits.least));
  const auto t = read<mbd::DistanceStop>(
      "{distance stop: [ground, arm], ends: [0 3 m, 1 2 m], largest: 2 m, stiffness: 9 kN/m^(n)}");
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
            at + ": needs a stop: give least, largest or both");
  EXPECT_EQ(refusal("{slide stop: [sled, arm], along: [1, 0], least: 1 m, largest: 0 m, n: 1, stiffness: 1 N/m}"),
            at + ": least must be below largest; for a fixed value use a joint or a driver");
  EXPECT_EQ(refusal("{distance stop: [sled, arm], ends: [0 0 m, 1 2 m], largest: 1 m, n: 1}"),
            at + ".stiffness: is missing: force per depth^n, in N/m^(n)");
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
        "{rotational stop: [sled, arm], least: 45 deg, n: 1.3, stiffness: 9 N m/rad^1.3}",
        "{slide stop: [ground, sled], along: [1, 3], largest: 0.4 m, stiffness: 9 N/mm^1.5}",
        "{distance stop: [ground, arm], ends: [0 3 m, 1 2 m], least: 1 mm, n: 2, stiffness: 9 kN/m^2}"}) {
    const std::string copy = write_scenario(with(force));
    Scenario again;
    ASSERT_NO_THROW(again = load_scenario_text(copy, "copy.yaml").scenario) << copy;
    EXPECT_EQ(write_scenario(again), copy);
  }
}

}  // namespace
}  // namespace subsoil::app::scenario_forces_test
