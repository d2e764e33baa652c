// Springs, bushing and drag in given states, against their equations written out by hand.

#include <gtest/gtest.h>

#include <cmath>

#include "force_support.hpp"
#include "libmbd/forces/bushing.hpp"
#include "libmbd/forces/drag.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/spring_damper.hpp"

namespace subsoil::mbd::springs_test {
namespace {

/// A body at x, moving along x: the spring to the ground's origin lies along x.
BodyState on_x(double x, double speed = 0) { return {{x, 0}, 0, {speed, 0}, 0}; }

TEST(SpringDamper, LinearAloneIsWhatItWas) {
  const SpringDamper s{
      .body_a = ground, .body_b = 1, .stiffness = 70.3, .free_length = 0.41, .preload = 3.7, .damping = 11.9};
  const double x = 0.7313, v = -0.377;
  const Felt f = feel(s, on_x(x, v));
  EXPECT_EQ(f.values[0], 3.7 + 70.3 * (0.41 - x) + -11.9 * v);  // to the bit, in the order it was always summed
  EXPECT_EQ(f.values[2], -11.9 * v);
  EXPECT_EQ(f.wrench[1][0], f.values[0]);
  EXPECT_EQ(f.wrench[0][0], -f.values[0]);
  EXPECT_EQ(f.power.stored, 0.5 * 70.3 * (x - 0.41) * (x - 0.41) - 3.7 * (x - 0.41));
  EXPECT_EQ(f.power.lost, 11.9 * v * v);
}

TEST(SpringDamper, PolynomialCurvesActOnShorteningAndItsRate) {
  SpringDamper s{.body_a = ground,
                 .body_b = 1,
                 .stiffness = 10,
                 .free_length = 1,
                 .preload = 2,
                 .damping = 3,
                 .spring_curve = PolynomialCharacteristic{{.c = {0, 0, 5, 7}}},
                 .damper_curve = PolynomialCharacteristic{{.c = {0, 4, 0, 6}}}};
  s.check();
  const double d = 0.2, rate = 0.5;  // 0.8 long, shortening at 0.5 m/s
  const Felt f = feel(s, on_x(0.8, -rate));
  EXPECT_DOUBLE_EQ(f.values[2], 3 * rate + 4 * rate + 6 * rate * rate * rate);
  EXPECT_DOUBLE_EQ(f.values[0], 2 + 10 * d + 5 * d * d + 7 * d * d * d + f.values[2]);
  EXPECT_DOUBLE_EQ(f.power.stored, 2 * d + 5 * d * d + 5 * d * d * d / 3 + 7 * d * d * d * d / 4);
  EXPECT_DOUBLE_EQ(f.power.lost, f.values[2] * rate);
  // Lengthening turns odd powers round and leaves even ones: a softening side, as written.
  EXPECT_NEAR(feel(s, on_x(1.2)).values[0], 2 - 10 * d + 5 * d * d - 7 * d * d * d, 1e-14);
}

// A table of a bump stop: nothing, then steep; the stored energy must be the integral of the force that it shows,
// here by Simpson's rule on 2000 strips (exact for the spline's cubics but for the strips with a knot: 1e-9).
TEST(SpringDamper, TableCurveStoresTheIntegralOfItsForce) {
  SpringDamper s{.body_a = ground,
                 .body_b = 1,
                 .free_length = 1,
                 .spring_curve = TableCharacteristic{{-0.2, 0, 0.1, 0.15, 0.3}, {-3, 0, 1, 4, 30}}};
  s.check();
  s.initialise_from_pose({});
  const auto force = [&](double shortening) { return feel(s, on_x(1 - shortening)).values[0]; };
  EXPECT_NEAR(force(0.15), 4, 1e-12);
  EXPECT_NEAR(force(0.3), 30, 1e-12);
  EXPECT_NEAR(force(0.35), 30, 1e-12);  // held beyond its end
  EXPECT_NEAR(force(-0.4), -3, 1e-12);
  for (const double end : {0.27, 0.4, -0.35}) {
    constexpr int strips = 2000;
    double sum = force(0) + force(end);
    for (int i = 1; i < strips; ++i) sum += (i % 2 ? 4 : 2) * force(end * i / strips);
    EXPECT_NEAR(feel(s, on_x(1 - end)).power.stored, sum * end / strips / 3, 1e-6) << "to " << end;
  }
}

TEST(SpringDamper, ActuatorWorksAndStoresNothing) {
  const SpringDamper s{
      .body_a = ground, .body_b = 1, .stiffness = 0, .free_length = 1, .actuator = PolynomialFunction{{2, 3}}};
  const Felt f = feel(s, on_x(0.6, 0.4), {}, 5);
  EXPECT_DOUBLE_EQ(f.wrench[1][0], 17);  // pushes apart
  EXPECT_DOUBLE_EQ(f.power.work, 17 * 0.4);
  EXPECT_EQ(f.power.stored, 0);
  EXPECT_EQ(f.power.lost, 0);
}

TEST(RotationalSpringDamper, CurvesAndActuatorActOnTheSecondBody) {
  const RotationalSpringDamper s{.body_a = 1,
                                 .body_b = 2,
                                 .stiffness = 10,
                                 .free_angle = 0.5,
                                 .spring_curve = PolynomialCharacteristic{{.c = {0, 0, 0, 8}}},
                                 .damper_curve = TableCharacteristic{{-2, 0, 2}, {-6, 0, 6}},
                                 .actuator = 1.5};
  const BodyState a{{}, 0.2, {}, 0.1}, b{{}, 0.4, {}, 0.8};  // 0.2 apart, opening at 0.7
  const double d = 0.3, torque = 10 * d + 8 * d * d * d - 3 * 0.7 + 1.5;
  const Felt f = feel(s, a, b);
  EXPECT_NEAR(f.wrench[2][2], torque, 1e-14);
  EXPECT_NEAR(f.wrench[1][2], -torque, 1e-14);
  EXPECT_NEAR(f.power.stored, 5 * d * d + 2 * d * d * d * d, 1e-14);
  EXPECT_NEAR(f.power.lost, 3 * 0.7 * 0.7, 1e-14);
  EXPECT_NEAR(f.power.work, 1.5 * 0.7, 1e-14);
}

TEST(Springs, RefuseWithRuleAndCure) {
  const std::string rule = "stiffness and damping must be given and not negative; stiffness 0 is a damper alone";
  EXPECT_EQ(refusal([] { SpringDamper{}.check(); }), rule);
  EXPECT_EQ(refusal([] { RotationalSpringDamper{.stiffness = -1}.check(); }), rule);
  EXPECT_EQ(refusal([] { SpringDamper{.spring_curve = TableCharacteristic{{0, 1}, {0, 1}}}.check(); }), "accepted");
  EXPECT_EQ(refusal([] {
              SpringDamper{.stiffness = -1, .spring_curve = TableCharacteristic{{0, 1}, {0, 1}}}.check();
            }),
            rule);
  EXPECT_EQ(refusal([] { Characteristic{PolynomialCharacteristic{}}; }),
            "polynomial characteristic: all coefficients are 0; give one, or leave the curve out");
  EXPECT_EQ(refusal([] {
              Characteristic{TableCharacteristic{{0}, {0}}};
            }),
            "table characteristic: needs at least two points, each with x and value");
  EXPECT_EQ(refusal([] {
              Characteristic{TableCharacteristic{{0, 1, 1}, {0, 1, 2}}};
            }),
            "table characteristic: x must increase; point 3 does not come after the one before");
}

TEST(Bushing, ActsInTheAxesOfTheFirstBodyAtThePlaceOfTheSecondsPoint) {
  const double quarter = std::acos(0.0);
  Bushing bushing{.body_a = 1, .body_b = 2, .stiffness_x = 100, .stiffness_y = 7, .stiffness_turn = 3, .free_angle = 0};
  // Body a stands at a quarter turn, so its x axis is the world's y; b's point is 0.2 to the right and 0.5 above.
  const BodyState a{{1, 2}, quarter, {}, 0}, b{{1.2, 2.5}, quarter + 0.4, {}, 0};
  const Felt f = feel(bushing, a, b);
  EXPECT_NEAR(f.values[0], -100 * 0.5, 1e-12);
  EXPECT_NEAR(f.values[1], 7 * 0.2, 1e-12);  // its y axis is the world's -x
  EXPECT_NEAR(f.wrench[2][0], -7 * 0.2, 1e-12);
  EXPECT_NEAR(f.wrench[2][1], -100 * 0.5, 1e-12);
  EXPECT_NEAR(f.wrench[2][2], -3 * 0.4, 1e-12);
  EXPECT_NEAR(f.wrench[1][2], 3 * 0.4 + 0.2 * 50 - 0.5 * 7 * 0.2, 1e-12);  // with the lever of the offset
  EXPECT_NEAR(f.power.stored, 50 * 0.25 + 3.5 * 0.04 + 1.5 * 0.16, 1e-12);
  EXPECT_NEAR(f.values[3], std::hypot(0.2, 0.5), 1e-12);
  // Axes turned back by the quarter are the world's.
  bushing.turn = -quarter;
  EXPECT_NEAR(feel(bushing, a, b).wrench[2][0], -100 * 0.2, 1e-12);
  EXPECT_NEAR(feel(bushing, a, b).wrench[2][1], -7 * 0.5, 1e-12);
}

// The pair turning as one rigid body damps nothing, however large the offset.
TEST(Bushing, RateIsWhatTheFirstBodySees) {
  const Bushing bushing{.body_a = 1,
                        .body_b = 2,
                        .stiffness_x = 1,
                        .stiffness_y = 1,
                        .damping_x = 9,
                        .damping_y = 9,
                        .damping_turn = 9,
                        .preload_x = 2,
                        .free_angle = 0};
  const double spin = 1.7;
  const BodyState a{{0, 0}, 0.3, {0, 0}, spin}, b{{0.6, 0.2}, 0.3, {-spin * 0.2, spin * 0.6}, spin};
  EXPECT_NEAR(feel(bushing, a, b).power.lost, 0, 1e-15);
  const BodyState resting{{0.6, 0.2}, 0.3, {0, 0}, spin};
  EXPECT_NEAR(feel(bushing, a, resting).power.lost, 9 * spin * spin * 0.4, 1e-12);
}

TEST(Bushing, RefusesNegativeStiffness) {
  const std::string rule =
      "stiffness x and y must be given, and no stiffness or damping may be negative; 0 leaves a direction free";
  EXPECT_EQ(refusal([] { Bushing{}.check(); }), rule);
  EXPECT_EQ(refusal([] { Bushing{.stiffness_x = 1, .stiffness_y = 1, .damping_turn = -1}.check(); }), rule);
}

TEST(Drag, OpposesTheVelocityThroughTheWind) {
  const Drag drag{.body = 1, .linear = 2, .quadratic = 3, .linear_turn = 4, .quadratic_turn = 5, .wind_x = 1.0};
  const Felt f = feel(drag, {{0, 0}, 0, {4, 4}, -2});  // 3 and 4 against the air: speed 5
  EXPECT_DOUBLE_EQ(f.wrench[1][0], -(2 + 3 * 5) * 3);
  EXPECT_DOUBLE_EQ(f.wrench[1][1], -(2 + 3 * 5) * 4);
  EXPECT_DOUBLE_EQ(f.wrench[1][2], (4 + 5 * 2) * 2);
  EXPECT_DOUBLE_EQ(f.power.lost, 17 * 25 + 14 * 4);
  EXPECT_DOUBLE_EQ(f.power.work, -17 * 3 * 1.0);
  // At a point of the body its own velocity counts, and the force turns the body.
  const Drag at_tip{.body = 1, .point = {0, 2}, .linear = 1};
  const Felt tip = feel(at_tip, {{0, 0}, 0, {0, 0}, 3});
  EXPECT_DOUBLE_EQ(tip.wrench[1][0], 6);
  EXPECT_DOUBLE_EQ(tip.wrench[1][2], -12);
}

TEST(Drag, RefusesToPush) {
  EXPECT_EQ(refusal([] { Drag{.quadratic = -1}.check(); }),
            "drag coefficients must not be negative; for a push along the motion use a force");
}

}  // namespace
}  // namespace subsoil::mbd::springs_test
