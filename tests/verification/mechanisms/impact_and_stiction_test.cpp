// Impacts of a given restitution and contacts that stick, by closed forms, with every integrator.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/disk_contact.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/outline_contact.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/forces/slide_stop.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::impact_and_stiction_test {
namespace {

class Touching : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const {
    return {.integrator = GetParam(), .ida = {.rtol = 1e-10, .atol = 1e-11}, .cvode = {1e-10, 1e-12}};
  }
};
INSTANTIATE_TEST_SUITE_P(All, Touching,
                         testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida));

void move_to(Machine& machine, double end, double h) {
  while (machine.time() < end - h / 2) machine.advance(h);
}

/// Hertz's contact that gives back the share e of the speed.
HuntCrossleyForce rebounding(double e, double stiffness = 2e5) {
  return {.n = 1.5, .stiffness = stiffness, .restitution = e};
}

// The equation of the impact, x - ln(1 + x) = -e x - ln(1 - e x), and its limits x = 3/2 (1 - e) and 1/e.
TEST(Restitution, GivesTheDampingOfTheImpact) {
  for (const double e : {0.1, 0.3, 0.5, 0.7, 0.9, 0.95}) {
    const double x = HuntCrossleyForce::damping_number(e);
    EXPECT_NEAR(x - std::log1p(x), -e * x - std::log1p(-e * x), 1e-11) << e;
  }
  EXPECT_EQ(HuntCrossleyForce::damping_number(1), 0);
  EXPECT_NEAR(HuntCrossleyForce::damping_number(0.999), 1.5e-3, 3e-6);
  EXPECT_NEAR(HuntCrossleyForce::damping_number(0.01), 100, 1e-9);
  EXPECT_EQ(rebounding(0.5).damping_from(2), HuntCrossleyForce::damping_number(0.5) / 2);
  EXPECT_EQ(rebounding(0.5).damping_from(0), HuntCrossleyForce::damping_number(0.5) / 0.01);
}

// A ball between two walls without gravity: each wall gives back e of the speed that the ball comes with, whatever that
// is. Steps of 1/2000 of the shortest contact, whose kink of order 1.5 leaves 1e-8; two impacts.
TEST_P(Touching, EveryImpactGivesBackItsShareOfTheSpeed) {
  for (const double e : {0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 1.0}) {
    SCOPED_TRACE(e);
    constexpr double mass = 0.8, v = 2;
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "ball", .mass = mass, .inertia = 1, .pose = {0, 1e-3, 0}, .velocity = {0, -v, 0}});
    m.add("floor", LineContact{.body_a = ground, .body_b = 1, .law = {.normal = rebounding(e)}});
    m.add("ceiling", LineContact{.body_a = ground,
                                 .body_b = 1,
                                 .p_a = {0, 2e-3},
                                 .angle_a = std::acos(-1.0),
                                 .law = {.normal = rebounding(e)}});
    Machine machine(m, options());
    machine.start_from_pose();
    std::vector<double> speeds;
    for (int i = 0; i < 200000 && machine.events().size() < 4; ++i) machine.advance(1e-5);
    ASSERT_EQ(machine.events().size(), 4U);
    EXPECT_NEAR(machine.body(1).v.y, -e * e * v, 2e-6 * v);
    EXPECT_NEAR(machine.energy().lost, 0.5 * mass * v * v * (1 - std::pow(e, 4)), 4e-6 * mass * v * v);
    EXPECT_LT(machine.energy().closure(), 1e-6);
  }
}

// Two balls: momentum is kept, their relative speed is e times what it was. A bar on a pin and a block on a slide
// against their stops, and a block that falls flat on two corners, which close at one instant.
TEST_P(Touching, PairsStopsAndBlocksGiveBackTheirShare) {
  constexpr double e = 0.6, v = 2;
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "one", .mass = 2, .inertia = 1, .pose = {-0.101, 0, 0}, .velocity = {v, 0, 0}});
  m.add({.name = "other", .mass = 0.5, .inertia = 1, .pose = {0.1, 0, 0}, .velocity = {0, 0, 0}});
  m.add("pair",
        DiskContact{.body_a = 1, .body_b = 2, .radius_a = 0.1, .radius_b = 0.1, .law = {.normal = rebounding(e)}});
  m.add({.name = "bar", .mass = 3, .inertia = 0.2, .pose = {0.4, 5, 0}, .velocity = {0, 0.4 * v, v}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 3, .p_a = {0, 5}, .p_b = {-0.4, 0}});
  m.add("turn", RotationalStop{.body_a = ground, .body_b = 3, .limits = {.largest = 1e-3, .law = rebounding(e)}});
  m.add({.name = "slider", .mass = 0.7, .inertia = 1, .pose = {0, 7, 0}, .velocity = {-v, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 4, .p_a = {0, 7}});
  m.add("end",
        SlideStop{.body_a = ground, .body_b = 4, .p_a = {0, 7}, .limits = {.least = -1e-3, .law = rebounding(e)}});
  m.add({.name = "block", .mass = 1, .inertia = 0.1, .pose = {9, 0.201, 0}, .velocity = {0, -v, 0}});
  m.add("flat", OutlineContact{.body_a = ground,
                               .body_b = 5,
                               .first = FlatOutline{.point = {0, 0}},
                               .second = PolygonOutline{.points = {{-0.3, -0.2}, {0.3, -0.2}, {0.3, 0.2}, {-0.3, 0.2}}},
                               .law = {.normal = rebounding(e)}});
  Machine machine(m, options());
  machine.start_from_pose();
  move_to(machine, 0.06, 1e-5);
  EXPECT_NEAR(2 * machine.body(1).v.x + 0.5 * machine.body(2).v.x, 2 * v, 1e-9);
  EXPECT_NEAR(machine.body(2).v.x - machine.body(1).v.x, e * v, 1e-6 * v);
  EXPECT_NEAR(machine.body(3).omega, -e * v, 1e-6 * v);
  EXPECT_NEAR(machine.body(4).v.x, e * v, 1e-6 * v);
  EXPECT_NEAR(machine.body(5).v.y, e * v, 1e-6 * v);
  EXPECT_NEAR(machine.body(5).omega, 0, 1e-9);
  EXPECT_LT(machine.energy().closure(), 1e-6);
}

// A ball that is dropped comes to rest: below the smallest impact speed its rebounds are those of one damping.
TEST_P(Touching, ADroppedBallComesToRest) {
  Model m;
  m.add({.name = "ball", .mass = 1, .inertia = 1, .pose = {0, 0.05, 0}});
  m.add("floor",
        LineContact{.body_a = ground,
                    .body_b = 1,
                    .law = {.normal = {.n = 1, .stiffness = 1e5, .restitution = 0.5, .slowest_impact = 0.02}}});
  Machine machine(m, options());
  machine.start_from_pose();
  move_to(machine, 1, 1e-4);
  EXPECT_NEAR(machine.body(1).v.y, 0, 1e-3);
  EXPECT_NEAR(machine.body(1).r.y, -9.81 / 1e5, 2e-6);
  EXPECT_LT(machine.energy().closure(), 1e-4);
}

/// Block of 0.6 x 0.4 m on a floor by its outline, in rest depth; gravity as on a slope of that tangent.
constexpr double mass = 4, g = 9.81, stiff = 1e6, bristle = 2e5;
Model block(double slope, double mu, double speed, double pull_per_second = 0) {
  Model m;
  const double cosine = 1 / std::hypot(1.0, slope);
  m.gravity = {g * slope * cosine, -g * cosine};
  const double depth = mass * g * cosine / (2 * stiff);
  m.add({.name = "block",
         .mass = mass,
         .inertia = mass * (0.36 + 0.16) / 12,
         .pose = {0, 0.2 - depth, 0},
         .velocity = {speed, 0, 0}});
  m.add(
      "floor",
      OutlineContact{
          .body_a = ground,
          .body_b = 1,
          .first = FlatOutline{.point = {0, 0}},
          .second = PolygonOutline{.points = {{-0.3, -0.2}, {0.3, -0.2}, {0.3, 0.2}, {-0.3, 0.2}}},
          .law = {.normal = {.n = 1, .stiffness = stiff, .damping = 50}, .friction = mu, .stick_stiffness = bristle}});
  if (pull_per_second > 0)
    m.add("pull", AppliedForce{.body = 1, .point = {0, -0.2}, .fx = PolynomialFunction{.c = {0, pull_per_second}}});
  return m;
}

TEST(Stiction, NeedsLocatedEvents) {
  EXPECT_THROW(Machine(block(0, 0.5, 0), {.locate_events = false}), std::invalid_argument);
}

// At a slope of 0.3 below mu = 0.5 the block stands for good: the spring of its surfaces begins with the load of the
// slope. What is left is that of its pitch, which the start gives no depth for.
TEST_P(Touching, ABlockOnASlopeHolds) {
  Machine machine(block(0.3, 0.5, 0), options());
  machine.start_from_pose();
  move_to(machine, 1, 1e-3);
  const double at_one = machine.body(1).r.x;
  move_to(machine, 10, 1e-3);
  EXPECT_NEAR(machine.body(1).r.x, at_one, 1e-9);  // 9 mm by a slip speed of 1 mm/s
  EXPECT_NEAR(machine.body(1).v.x, 0, 1e-9);
  EXPECT_NEAR(machine.body(1).r.x, 0, 0.3 * mass * g / (2 * bristle));
  EXPECT_LT(std::abs(machine.energy().balance()), 1e-6);
}

// At a slope of 0.3 above mu = 0.2 it slides with g (sin - mu cos), whatever its pitch does.
TEST_P(Touching, ABlockOnASteepSlopeSlides) {
  Machine machine(block(0.3, 0.2, 0.5), options());
  machine.start_from_pose();
  move_to(machine, 1, 1e-4);
  const double a = g * (0.3 - 0.2) / std::hypot(1.0, 0.3);
  EXPECT_NEAR(machine.body(1).v.x, 0.5 + a, 1e-4);
  EXPECT_LT(machine.energy().closure(), 1e-6);
}

// A block that slides on the level at 1 m/s stops within v^2/(2 mu g), and stays.
TEST_P(Touching, ASlidingBlockStopsAndStays) {
  constexpr double mu = 0.4, v = 1;
  Machine machine(block(0, mu, v), options());
  machine.start_from_pose();
  move_to(machine, 1, 1e-4);
  const double at_one = machine.body(1).r.x;
  EXPECT_NEAR(at_one, v * v / (2 * mu * g), 2e-4);  // of its surfaces' strain, mu m g/(2 k), and of its pitch
  move_to(machine, 3, 1e-4);
  EXPECT_NEAR(machine.body(1).r.x, at_one, 1e-9);
  EXPECT_NEAR(machine.energy().lost + machine.energy().stored - mass * g * mass * g / (4 * stiff), mass * v * v / 2,
              1e-3);
  EXPECT_LT(machine.energy().closure(), 1e-6);
}

// A block that is laid on the floor without depth has touched it, though its gap is 0: its friction acts, and it sinks
// in.
TEST_P(Touching, ABlockThatBeginsAtTheSurfaceRubs) {
  constexpr double mu = 0.4, v = 1;
  Model m = block(0, mu, v);
  m.bodies[0].pose[1] = 0.2;
  Machine machine(m, options());
  machine.start_from_pose();
  move_to(machine, 0.5, 1e-4);
  EXPECT_NEAR(machine.body(1).r.x, v * v / (2 * mu * g), 2e-3);
  EXPECT_NEAR(machine.body(1).v.x, 0, 1e-4);
  EXPECT_LT(machine.energy().closure(), 1e-5);
}

/// Block as block(), or a disk of 0.2 m, that begins at rest with its outline on the floor: nothing presses it yet.
Model laid_on_the_floor(double slope, double mu, bool disk, double pull = 0) {
  Model m = block(slope, mu, 0);
  Body& body = m.bodies[0];
  body.pose[1] = 0.2;
  if (disk) {
    const OutlineContact outline = m.forces[0].element.get<OutlineContact>();
    body.inertia = mass * 0.2 * 0.2 / 2;
    m.forces.clear();
    m.add("floor", LineContact{.body_a = ground, .body_b = 1, .radius = 0.2, .law = outline.law});
  }
  if (pull > 0) m.add("pull", AppliedForce{.body = 1, .point = {0, -0.2}, .fx = PolynomialFunction{.c = {pull}}});
  return m;
}

// What has no normal force as it begins cannot stick on a slope steeper than its friction: the impulse of the floor is
// m g cos t less m v_n, and v_n is gone at 1 s, so that v = g (sin - mu cos) t whatever the depth did meanwhile.
TEST_P(Touching, WhatIsLaidOnASteepSlopeSlidesAtOnce) {
  for (const bool disk : {false, true}) {
    SCOPED_TRACE(disk);
    constexpr double slope = 0.6, mu = 0.1;  // a disk rolls up to mu = slope/3
    Machine machine(laid_on_the_floor(slope, mu, disk), options());
    machine.start_from_pose();
    move_to(machine, 1, 1e-4);
    const double normal = g / std::hypot(1.0, slope), a = normal * (slope - mu);
    EXPECT_NEAR(machine.body(1).v.x, a, 2e-6 * a);
    if (disk) {
      EXPECT_NEAR(machine.body(1).omega, -2 * mu * normal / 0.2, 2e-6 * a / 0.2);
    }
    EXPECT_LT(machine.energy().closure(), 1e-6);
  }
}

// The same of a pull above mu m g on the level, and of one below: sinking in it has slipped by no more than it could
// while the floor did not carry it yet, some (m/k)^(1/2), and then it stands still, its springs damped critically.
TEST_P(Touching, WhatIsPulledAsItIsLaidDownSlidesOrHolds) {
  constexpr double mu = 0.3, limit = mu * mass * g;
  for (const double share : {0.0, 0.5, 1.5}) {
    SCOPED_TRACE(share);
    Machine machine(laid_on_the_floor(0, mu, false, share * limit), options());
    machine.start_from_pose();
    move_to(machine, 1, 1e-4);
    const double surplus = std::max(0.0, share - 1) * limit / mass;
    EXPECT_NEAR(machine.body(1).v.x, surplus, share > 1 ? 1e-4 * surplus : 1e-7);
    const double sinking = std::numbers::pi * std::sqrt(mass / (2 * stiff));
    if (share < 1) {
      EXPECT_LT(machine.body(1).r.x, limit / mass * sinking * sinking + limit / (2 * bristle));
    }
    EXPECT_LT(machine.energy().closure(), 1e-6);
  }
}

// On a slope that holds it, friction has stopped it when it has sunk in, and nothing swings on.
TEST_P(Touching, WhatIsLaidOnAFlatSlopeComesToRest) {
  Machine machine(laid_on_the_floor(0.3, 0.5, false), options());
  machine.start_from_pose();
  move_to(machine, 1, 1e-4);
  const double at_one = machine.body(1).r.x;
  EXPECT_LT(at_one, 0.3 * mass * g / bristle);
  move_to(machine, 2, 1e-4);
  EXPECT_NEAR(machine.body(1).r.x, at_one, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, 0, 1e-9);
}

// Two boxes on each other and on a cart, all at gap 0, so that rounding alone presses the upper one as they begin. The
// cart's acceleration grows as 6 c t: the lower box holds (10 kg x 2.5 m/s^2 + mu_2 m g < 2 mu_1 m g), the upper one
// slides from 6 c t = mu_2 g on.
TEST_P(Touching, AStackThatOnlyTouchesRidesOnACart) {
  constexpr double c = 5.0 / 6, mu_1 = 0.3, mu_2 = 0.2, end = 0.5;
  const PolygonOutline box{.points = {{-0.5, -0.1}, {0.5, -0.1}, {0.5, 0.1}, {-0.5, 0.1}}};
  const auto rests = [&](int below, int above, double mu) {
    return OutlineContact{
        .body_a = below,
        .body_b = above,
        .first = FlatOutline{.point = {0, 0.1}},
        .second = box,
        .law = {.normal = {.n = 1, .stiffness = 1e7, .damping = 50}, .friction = mu, .stick_stiffness = 5e6}};
  };
  Model m;
  m.add({.name = "cart", .mass = 50, .inertia = 3, .pose = {0, -0.1, 0}});
  m.add({.name = "lower", .mass = 10, .inertia = 0.5, .pose = {0, 0.1, 0}});
  m.add({.name = "upper", .mass = 10, .inertia = 0.5, .pose = {0, 0.3, 0}});
  m.add("track", Translational{.body_a = ground, .body_b = 1, .p_a = {0, -0.1}});
  m.add("drive", CoordinateDriver{.body = 1, .motion = {.position = PolynomialFunction{.c = {0, 0, 0, c}}}});
  m.add("on the cart", rests(1, 2, mu_1)), m.add("on the box", rests(2, 3, mu_2));
  Machine machine(m, options());
  machine.start_from_pose();
  move_to(machine, end, 2e-4);
  const double slides = mu_2 * g / (6 * c);
  EXPECT_NEAR(machine.body(2).v.x, 3 * c * end * end, 1e-4);
  EXPECT_NEAR(machine.body(3).v.x, 3 * c * slides * slides + mu_2 * g * (end - slides), 1e-4);
  EXPECT_LT(machine.events().size(), 200U);
}

// A ladder of 4 m between floor and wall, both of mu, holds from tan = (1 - mu^2)/(2 mu) on, 56.6 degrees: the
// equilibrium is where it stands, strained by its weight, whether its ends touch or are pressed in a little. Beside it
// there is one that no ladder comes to: it hangs on its foot below the floor.
TEST(Stiction, ALadderThatHoldsIsInEquilibriumWhereItStands) {
  constexpr double half = 2, mu = 0.3, k = 1e7, m_ladder = 20;
  for (const double degrees : {60.0, 65.0, 70.0, 75.0})
    for (const double pressed : {0.0, 1e-6, 1e-5}) {
      SCOPED_TRACE(std::to_string(degrees) + " degrees, pressed in by " + std::to_string(pressed));
      const double angle = degrees * std::numbers::pi / 180, up = std::sin(angle), out = std::cos(angle);
      const ContactLaw law{.normal = {.n = 1, .stiffness = k, .damping = 5}, .friction = mu, .stick_stiffness = k};
      Model m;
      m.add({.name = "ladder",
             .mass = m_ladder,
             .inertia = m_ladder * 16 / 12,
             .pose = {half * out - pressed, half * up - pressed, std::numbers::pi - angle}});
      m.add("floor", LineContact{.body_a = ground, .body_b = 1, .p_b = {-half, 0}, .law = law});
      m.add("wall",
            LineContact{.body_a = ground, .body_b = 1, .p_b = {half, 0}, .angle_a = -std::numbers::pi / 2, .law = law});
      Machine machine(m, {.integrator = IntegratorKind::cvode});
      machine.start_from_towing_equilibrium(0);
      const double strain = m_ladder * g / k;  // of each contact, and the play that the pose began with
      EXPECT_NEAR(machine.body(1).angle, std::numbers::pi - angle, 10 * (strain + pressed) / half);
      const BodyState found = machine.body(1);
      const double foot = found.r.y - half * std::sin(std::numbers::pi - found.angle);
      const double tip = found.r.x + half * std::cos(found.angle);
      EXPECT_LT(std::max(foot, tip), 0);
      // The floor's normal force and the wall's friction carry the weight.
      EXPECT_NEAR(-k * foot, m_ladder * g, -mu * k * tip + 1e-6 * m_ladder * g);
      move_to(machine, 1, 1e-2);
      EXPECT_NEAR(machine.body(1).r.x, found.r.x, 1e-9);
      EXPECT_NEAR(machine.body(1).r.y, found.r.y, 1e-9);
    }
}

// Under a pull that grows it holds until mu m g, then slides: at 1 s it has gone what the surplus has brought.
TEST_P(Touching, APulledBlockBreaksAwayAtItsLimit) {
  constexpr double mu = 0.4, per_second = 30;
  Machine machine(block(0, mu, 0, per_second), options());
  machine.start_from_pose();
  const double limit = mu * mass * g, when = limit / per_second;
  move_to(machine, 0.95 * when, 1e-4);
  EXPECT_LT(machine.body(1).r.x, 1.1 * limit / (2 * bristle));
  move_to(machine, 1, 1e-4);
  const double dt = 1 - when;
  EXPECT_NEAR(machine.body(1).v.x, per_second * dt * dt / (2 * mass), 1e-3);
  EXPECT_LT(machine.energy().closure(), 1e-5);
}

// A disk on a slope that sticks rolls: a = g sin/(1 + 1/2). The spring of its surfaces begins with that force.
TEST_P(Touching, ADiskThatSticksRolls) {
  constexpr double radius = 0.1, slope = 0.2, k = 1e5;
  Model m;
  const double cosine = 1 / std::hypot(1.0, slope);
  m.gravity = {g * slope * cosine, -g * cosine};
  m.add({.name = "disk",
         .mass = mass,
         .inertia = mass * radius * radius / 2,
         .pose = {0, radius - mass * g * cosine / stiff, 0}});
  m.add("floor",
        LineContact{
            .body_a = ground,
            .body_b = 1,
            .radius = radius,
            .law = {.normal = {.n = 1, .stiffness = stiff, .damping = 50}, .friction = 0.5, .stick_stiffness = k}});
  Machine machine(m, options());
  machine.start_from_pose();
  move_to(machine, 2, 1e-3);
  const double a = g * slope * cosine / 1.5;
  EXPECT_NEAR(machine.body(1).v.x, 2 * a, 1e-6);
  EXPECT_NEAR(machine.body(1).omega, -2 * a / radius, 1e-5);
  EXPECT_NEAR(machine.body(1).r.x + radius * machine.body(1).angle, 0, 1e-6);
  EXPECT_LT(machine.energy().closure(), 1e-7);
}

// The same motion in times that are 2^-n of one another: stiffnesses are 4^n times as large, velocities 2^n times. A
// rod that strikes a floor obliquely, sticks and slips leaves it with the same spin times T, from seconds to
// microseconds.
TEST_P(Touching, AnObliqueImpactHasNoTimeOfItsOwn) {
  double first = 0;
  for (const int n : {0, 8, 16}) {
    const double faster = std::ldexp(1.0, n);
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "rod", .mass = 2, .inertia = 0.02, .pose = {0, 0.11, 0}, .velocity = {0.2 * faster, -faster, 0}});
    m.add("floor", LineContact{.body_a = ground,
                               .body_b = 1,
                               .p_b = {0.05, -0.1},
                               .law = {.normal = {.n = 1, .stiffness = 1e6 * faster * faster},
                                       .friction = 0.6,
                                       .stick_stiffness = 2e5 * faster * faster,
                                       .stick_damping = 0}});
    Machine machine(m, options());
    machine.start_from_pose();
    move_to(machine, 0.03 / faster, 1e-5 / faster);
    const double spin = machine.body(1).omega / faster;
    if (n == 0) first = spin;
    EXPECT_NEAR(spin, first, 1e-6 * std::abs(first)) << n;
  }
  EXPECT_GT(std::abs(first), 1);
}

// A snapshot within an impact and one within stiction continue to the bit.
TEST_P(Touching, ASnapshotKeepsWhatAContactHasBegunWith) {
  Model m = block(0.3, 0.5, 0.2);
  std::vector<Named<AnyForce>>& forces = m.forces;
  forces.back().element = [&] {
    OutlineContact floor = forces.back().element.get<OutlineContact>();
    floor.law.normal.damping = 0, floor.law.normal.restitution = 0.4;
    return floor;
  }();
  m.bodies[0].pose[1] += 0.01, m.bodies[0].pose[2] = 0.02;
  for (const double stop : {0.045, 0.052, 0.2, 0.6}) {
    Machine whole(m, options()), first(m, options()), second(m, options());
    whole.start_from_pose(), first.start_from_pose(), second.start_from_pose();
    move_to(first, stop, 1e-3);
    const Snapshot snapshot = first.snapshot();
    second.restore(snapshot);
    first.restore(snapshot);
    move_to(first, 1, 1e-3), move_to(second, 1, 1e-3), move_to(whole, 1, 1e-3);
    EXPECT_EQ(first.snapshot(), second.snapshot()) << stop;
    EXPECT_NEAR(whole.body(1).r.x, second.body(1).r.x, 1e-5) << stop;
  }
}

}  // namespace
}  // namespace subsoil::mbd::impact_and_stiction_test
