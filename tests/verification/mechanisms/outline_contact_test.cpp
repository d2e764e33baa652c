// Outlines that touch, against closed forms: Hertz's time of contact, restitution, a cam's follower and its lift-off,
// an eccentric impact of two corners, a pawl under load, a block on an incline.

#include "libmbd/forces/outline_contact.hpp"

#include <gtest/gtest.h>

#include <boost/math/special_functions/lambert_w.hpp>
#include <cmath>
#include <numbers>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::outline_contact_test {
namespace {

constexpr double g = 9.81;

MachineOptions method(IntegratorKind kind) {
  return {.integrator = kind, .ida = {.rtol = 1e-10, .atol = 1e-12}, .cvode = {.rtol = 1e-12, .atol = 1e-13}};
}
class Outlines : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const { return method(GetParam()); }
};

PolygonOutline box(double width, double height) {
  const double x = width / 2, y = height / 2;
  return {.points = {{-x, -y}, {x, -y}, {x, y}, {-x, y}}};
}

Model disk_over_floor(double speed, double gap, double damping) {
  constexpr double radius = 0.05;
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "disk", .mass = 0.8, .inertia = 1e-3, .pose = {0, radius + gap, 0}, .velocity = {0, -speed, 0}});
  m.add("touch", OutlineContact{.body_a = ground,
                                .body_b = 1,
                                .first = FlatOutline{{0, 0}, 0},
                                .second = DiskOutline{radius},
                                .law = {.normal = {.n = 1.5, .stiffness = 2e5, .damping = damping}}});
  return m;
}

// Hertz's impact without loss: depth (5 m v^2/(4 k))^(2/5), time of contact 2.943 depth/v. Tolerances of 1e-10 over
// some hundred steps, and fixed steps of 1/500 of the contact at order 4: 1e-7 of the time, which the event's own 1e-12
// does not see. d^1.5 has no third derivative at touch, which costs the fixed step its order there: 1e-6.
TEST_P(Outlines, DiskStaysOnAFloorAsLongAsHertzSays) {
  constexpr double mass = 0.8, k = 2e5, v = 2, gap = 1e-3;
  Machine machine(disk_over_floor(v, gap, 0), options());
  machine.start_from_pose();
  const double depth = std::pow(1.25 * mass * v * v / k, 0.4);
  const double shape = 0.8 * std::sqrt(std::numbers::pi) * std::tgamma(0.4) / std::tgamma(0.9);
  const double contact = shape * depth / v;
  for (int i = 0; i < 1000; ++i) machine.advance(contact / 500);
  const auto& events = machine.events();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_NEAR(events[0].t, gap / v, 1e-10);
  EXPECT_EQ(events[0].direction, -1);
  EXPECT_NEAR(events[1].t - events[0].t, contact, 1e-6 * contact);
  EXPECT_EQ(events[1].direction, 1);
  EXPECT_NEAR(machine.body(1).v.y, v, 1e-6 * v);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

// Speed out v_o of a Hunt-Crossley contact, whatever mass, stiffness and exponent: y = 1 - b v_o by Lambert's W.
TEST_P(Outlines, DiskBouncesAsHuntAndCrossleySay) {
  constexpr double v = 2, b = 0.4, mass = 0.8;
  Machine machine(disk_over_floor(v, 1e-3, b), options());
  machine.start_from_pose();
  for (int i = 0; i < 2000; ++i) machine.advance(2e-5);
  const double left = b * v - std::log1p(b * v);
  const double out = (1 + boost::math::lambert_w0(-std::exp(-1 - left))) / b;
  EXPECT_NEAR(machine.body(1).v.y, out, 1e-6 * v);
  EXPECT_NEAR(machine.energy().lost, 0.5 * mass * (v * v - out * out), 1e-6 * mass * v * v);
  EXPECT_EQ(machine.events().size(), 2U);
}

/// An eccentric disk turns at w under a flat follower that a constant force and its weight press down; linear contact.
struct CamRig {
  static constexpr double radius = 0.03, e = 0.01, mass = 0.5, preload = 20, k = 1e6;
  double w;
  double amplitude() const { return e / (1 - w * w * mass / k); }
  double load() const { return preload + mass * g; }
  double height(double t) const { return radius - load() / k + amplitude() * std::sin(w * t); }
  double force(double t) const { return load() - mass * w * w * amplitude() * std::sin(w * t); }
  static double lift_off_speed() {  // m w^2 A = load
    constexpr double load = preload + mass * g;
    return std::sqrt(load / (mass * e + load * mass / k));
  }
  Model model(OutlineForm cam, OutlineForm face) const {
    Model m;
    m.add({.name = "cam", .mass = 1, .inertia = 1e-3, .pose = {0, 0, 0}, .velocity = {0, 0, w}});
    m.add({.name = "follower",
           .mass = mass,
           .inertia = 1,
           .pose = {0, height(0), 0},
           .velocity = {0, w * amplitude(), 0}});
    m.add("shaft", Revolute{.body_a = ground, .body_b = 1});
    m.add("guide", Translational{.body_a = ground, .body_b = 2, .angle_a = std::numbers::pi / 2});
    m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = w}});
    m.add("spring", AppliedForce{.body = 2, .fy = -preload});
    m.add("lift", OutlineContact{.body_a = 1,
                                 .body_b = 2,
                                 .first = std::move(cam),
                                 .second = std::move(face),
                                 .law = {.normal = {.n = 1, .stiffness = k}}});
    return m;
  }
};

/// The circle about the eccentric centre as a radius over the angle.
ProfileOutline circle_profile(double e, double radius, int points) {
  ProfileOutline p;
  for (int i = 0; i < points; ++i) {
    const double a = 2 * std::numbers::pi * i / points;
    p.angles.push_back(a);
    p.radii.push_back(e * std::cos(a) + std::sqrt(radius * radius - e * e * std::sin(a) * std::sin(a)));
  }
  return p;
}

// With linear contact the follower is a linear oscillator under a harmonic foot: height and force in closed form, exact
// while it touches. At 0.99 of the speed of lift-off it stays on for a turn. Disk against flat and against a block's
// side are exact: what the integrators leave. A spline through 90 points of the circle is off by (4 deg)^4/384 of the
// radius's fourth derivative, 1e-9 m, which k makes 1e-3 N; its curvature by 1e-4 of e w^2 m.
TEST_P(Outlines, EccentricCamLiftsItsFollowerAsTheClosedFormSays) {
  const CamRig rig{0.99 * CamRig::lift_off_speed()};
  const FlatOutline face{{0, 0}, std::numbers::pi};
  PolygonOutline block{.points = {{-0.05, 0}, {0.05, 0}, {0.05, 0.02}, {-0.05, 0.02}}};
  const DiskOutline disk{rig.radius, {rig.e, 0}};
  struct Case {
    OutlineForm cam, face;
    double height, force;
  };
  for (const Case& c : {Case{disk, face, 1e-9, 1e-3}, Case{disk, block, 1e-9, 1e-3},
                        Case{circle_profile(rig.e, rig.radius, 90), face, 1e-8, 0.02},
                        Case{circle_profile(rig.e, rig.radius, 90), block, 1e-8, 0.02}}) {
    Machine machine(rig.model(c.cam, c.face), options());
    machine.start_from_pose();
    const double turn = 2 * std::numbers::pi / rig.w;
    for (int i = 1; i <= 20; ++i) {
      for (int j = 0; j < 100; ++j) machine.advance(turn / 2000);
      const double t = machine.time();
      EXPECT_NEAR(machine.body(2).r.y, rig.height(t), c.height) << t;
      EXPECT_NEAR(machine.force_value("lift", "normal force"), rig.force(t), c.force) << t;
      EXPECT_EQ(machine.force_value("lift", "contacts"), 1);
    }
    EXPECT_TRUE(machine.events().empty());
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().moved);
  }
}

// Above that speed it leaves where the closed form of the force passes zero: sin(w t) = load/(m w^2 A), and flies until
// it meets the cam again, at a time found here by bisection on the parabola.
TEST_P(Outlines, FollowerLiftsOffWhereTheForceIsZero) {
  const CamRig rig{1.2 * CamRig::lift_off_speed()};
  Machine machine(rig.model(DiskOutline{rig.radius, {rig.e, 0}}, FlatOutline{{0, 0}, std::numbers::pi}), options());
  machine.start_from_pose();
  const double off = std::asin(rig.load() / (rig.mass * rig.w * rig.w * rig.amplitude())) / rig.w;
  const double speed = rig.w * rig.amplitude() * std::cos(rig.w * off);
  const auto gap = [&](double t) {
    const double s = t - off;
    return rig.height(off) + s * (speed - s * rig.load() / (2 * rig.mass)) - rig.radius - rig.e * std::sin(rig.w * t);
  };
  double early = off + 0.5 / rig.w, late = early;
  ASSERT_GT(gap(early), 0);
  while (gap(late) > 0) early = late, late += 0.01 / rig.w;
  while (late - early > 1e-14) (gap(0.5 * (early + late)) > 0 ? early : late) = 0.5 * (early + late);
  while (machine.time() < late + 1e-4) machine.advance(1e-5);
  ASSERT_EQ(machine.events().size(), 2U);
  EXPECT_EQ(machine.events()[0].direction, 1);
  EXPECT_NEAR(machine.events()[0].t, off, 1e-7);
  EXPECT_NEAR(machine.events()[1].t, early, 1e-7);
}

// A box falls with one corner beside its centre onto a block's top: the impulse of a frictionless eccentric impact is
// J = 2 v/(1/m + x^2/I), whatever the law, in the limit of a stiff contact. During the contact of some 3e-5 s the box
// turns by w T/2, 1e-4 rad, and x changes by as much of its height: 1e-3. What both keep is exact.
TEST_P(Outlines, CornerOfABoxMeetsABlock) {
  constexpr double mass = 2, inertia = 0.02, v = 1, heavy = 3, tilt = 0.3;
  Model m;
  m.gravity = {0, 0};
  const double x = 0.1 * std::sin(tilt) - 0.2 * std::cos(tilt), y = 0.2 * std::sin(tilt) + 0.1 * std::cos(tilt);
  m.add({.name = "block", .mass = heavy, .inertia = 0.03, .pose = {x, -0.05, 0}});
  m.add({.name = "box", .mass = mass, .inertia = inertia, .pose = {0, y + 1e-4, tilt}, .velocity = {0, -v, 0}});
  m.add("touch", OutlineContact{.body_a = 1,
                                .body_b = 2,
                                .first = box(1, 0.1),
                                .second = box(0.4, 0.2),
                                .law = {.normal = {.n = 1, .stiffness = 1e10}}});
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 0; i < 2000; ++i) machine.advance(1e-7);
  const double impulse = 2 * v / (1 / mass + 1 / heavy + x * x / inertia);
  EXPECT_EQ(machine.events().size(), 2U);
  EXPECT_NEAR(machine.body(2).v.y, -v + impulse / mass, 1e-3 * v);
  EXPECT_NEAR(machine.body(2).omega, impulse * x / inertia, 1e-3 * v / std::abs(x));
  EXPECT_NEAR(machine.body(1).v.y, -impulse / heavy, 1e-3 * v);
  const BodyState &a = machine.body(1), &b = machine.body(2);
  EXPECT_NEAR(heavy * a.v.y + mass * b.v.y, -mass * v, 1e-10);
  const double turning = heavy * cross(a.r, a.v) + 0.03 * a.omega + mass * cross(b.r, b.v) + inertia * b.omega;
  EXPECT_NEAR(turning, 0, 1e-10);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7);
}

// Two equal boxes on end meet corner to corner, rounded: the line of their centres is the normal, and an elastic
// central impact exchanges the speeds. Each corner sees the other's.
TEST_P(Outlines, RoundedCornersMeetHeadOn) {
  PolygonOutline square = box(0.2, 0.2);
  square.corner_radius = 0.02;
  const double reach = std::sqrt(2) * (0.1 - 0.02) + 0.02, diagonal = std::numbers::pi / 4;
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "left", .mass = 1, .inertia = 0.01, .pose = {-reach - 5e-4, 0, diagonal}, .velocity = {1, 0, 0}});
  m.add({.name = "right", .mass = 1, .inertia = 0.01, .pose = {reach + 5e-4, 0, -diagonal}});
  m.add(
      "touch",
      OutlineContact{
          .body_a = 1, .body_b = 2, .first = square, .second = square, .law = {.normal = {.n = 1, .stiffness = 1e7}}});
  Machine machine(m, options());
  machine.start_from_pose();
  double most = 0;
  for (int i = 0; i < 400; ++i) {
    machine.advance(1e-5);
    most = std::max(most, machine.force_value("touch", "contacts"));
  }
  EXPECT_EQ(most, 2);
  EXPECT_NEAR(machine.events().front().t, 1e-3, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, 0, 1e-6);  // a fixed step of 1/70 of the contact
  EXPECT_NEAR(machine.body(2).v.x, 1, 1e-6);
  EXPECT_NEAR(machine.body(2).omega, 0, 1e-9);
}

// A disk in a right-angled notch lies on both sides: its depths in them are two oscillators of their own,
// m d'' = m g c - k d, that never part here, while the nearer side changes four times in a period. Where the nearest
// side alone pushed, the disk clung to the bisector and no integrator passed. What fixed steps of 1/400 of a period
// leave is 1e-9 m.
TEST_P(Outlines, DiskRocksOnBothSidesOfANotch) {
  constexpr double tilt = 0.9, radius = 0.05, mass = 0.8, k = 2e4;
  const double c = std::cos(tilt), s = std::sin(tilt), w = std::sqrt(k / mass);
  PolygonOutline notch;
  for (const Vec2 p : {Vec2{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}})
    notch.points.push_back({c * p.x - s * p.y, s * p.x + c * p.y});
  const auto centre = [&](double t) {
    const double first = mass * g * c / k * (1 - 0.6 * std::cos(w * t)),
                 second = mass * g * s / k * (1 + 0.5 * std::cos(w * t));
    return (radius - first) * Vec2{-s, c} + (radius - second) * Vec2{c, s};
  };
  Model m;
  m.add({.name = "disk", .mass = mass, .inertia = 1e-3, .pose = {centre(0).x, centre(0).y, 0}});
  m.add("touch", OutlineContact{.body_a = ground,
                                .body_b = 1,
                                .first = notch,
                                .second = DiskOutline{radius},
                                .law = {.normal = {.n = 1, .stiffness = k}}});
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 0; i < 2000; ++i) {
    machine.advance(1e-4);
    const Vec2 off = machine.body(1).r - centre(machine.time());
    ASSERT_LT(length(off), 1e-9) << machine.time();
    ASSERT_EQ(machine.force_value("touch", "contacts"), 2);
  }
  EXPECT_TRUE(machine.events().empty());
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-9);
}

/// A block on its side on an incline, at rest depth under its own weight and friction when it slides down.
struct Slope {
  static constexpr double mass = 3, mu = 0.4, k = 1e6, width = 0.3, height = 0.1, slip_speed = 1e-3;
  double incline, speed;
  Model model() const {
    const double c = std::cos(incline), s = std::sin(incline), normal = mass * g * c;
    // Friction at the lower side turns the block: the corner ahead carries more. Depth and tilt of linear springs.
    const double each = normal / (2 * k), tilt = -mu * normal * (height / 2) / (k * width * width / 2);
    const double up = height / 2 - each;
    Model m;
    m.add({.name = "block",
           .mass = mass,
           .inertia = mass * (width * width + height * height) / 12,
           .pose = {s * up, c * up, -incline + tilt},
           .velocity = {speed * c, -speed * s, 0}});
    m.add("touch",
          OutlineContact{
              .body_a = ground,
              .body_b = 1,
              .first = FlatOutline{{0, 0}, -incline},
              .second = box(width, height),
              .law = {.normal = {.n = 1, .stiffness = k, .damping = 50}, .friction = mu, .slip_speed = slip_speed}});
    return m;
  }
  double along(const BodyState& b) const { return std::cos(incline) * b.v.x - std::sin(incline) * b.v.y; }
};

// a = g (sin - mu cos), both corners loaded. The start is off by the tilt's square and rings down in 0.1 s, where the
// sum of the forces still has the right mean: 1e-6 of the speed from there on, friction's tanh is within 4e-9.
TEST_P(Outlines, BlockSlidesDownAnIncline) {
  const Slope slope{0.5, 0.3};
  Machine machine(slope.model(), options());
  machine.start_from_pose();
  for (int i = 0; i < 2000; ++i) machine.advance(1e-4);
  const double before = slope.along(machine.body(1)), a = g * (std::sin(0.5) - slope.mu * std::cos(0.5));
  for (int i = 0; i < 5000; ++i) machine.advance(1e-4);
  EXPECT_NEAR(slope.along(machine.body(1)) - before, 0.5 * a, 1e-6);
  EXPECT_NEAR(machine.force_value("touch", "friction"), -slope.mu * slope.mass * g * std::cos(0.5), 1e-5);
  EXPECT_EQ(machine.force_value("touch", "contacts"), 2);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

// Below the angle of friction it comes to rest but for the creep of regularised friction, s_0 atanh(tan/mu).
TEST_P(Outlines, BlockStopsOnAShallowIncline) {
  const Slope slope{0.2, 0.3};
  Machine machine(slope.model(), options());
  machine.start_from_pose();
  for (int i = 0; i < 5000; ++i) machine.advance(1e-4);
  EXPECT_NEAR(slope.along(machine.body(1)), slope.slip_speed * std::atanh(std::tan(0.2) / slope.mu), 1e-8);
  EXPECT_NEAR(machine.force_value("touch", "friction"), -slope.mass * g * std::sin(0.2), 1e-5);
}

// A pawl holds a loaded wheel by a tooth: torque of the load = normal force x its moment arm. The pawl is a strut whose
// square end meets the tooth's flat; the force acts between its two corners, so that it stands in balance. Deflections
// of 4e-5 m on 0.1 m; what still rings after 0.2 s is below that.
TEST_P(Outlines, PawlHoldsALoad) {
  constexpr double load = 40, arm = 0.1;
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "wheel", .mass = 5, .inertia = 0.05, .pose = {0, 0, 0}});
  m.add({.name = "pawl", .mass = 0.3, .inertia = 4e-4, .pose = {arm, 0.07, 0}});
  m.add("axle", Revolute{.body_a = ground, .body_b = 1});
  m.add("hinge", Revolute{.body_a = ground, .body_b = 2, .p_a = {arm, 0.12}, .p_b = {0, 0.05}});
  m.add("load", AppliedForce{.body = 1, .moment = load});
  const PolygonOutline tooth{.points = {{0.07, -0.03}, {0.13, -0.03}, {0.13, 0}, {0.07, 0}}};
  m.add("tooth", OutlineContact{.body_a = 1,
                                .body_b = 2,
                                .first = tooth,
                                .second = box(0.02, 0.14),
                                .law = {.normal = {.n = 1, .stiffness = 1e7, .damping = 5}}});
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 0; i < 20000; ++i) machine.advance(1e-5);
  EXPECT_NEAR(machine.force_value("tooth", "normal force"), load / arm, 1e-3 * load / arm);
  EXPECT_EQ(machine.force_value("tooth", "contacts"), 2);
  EXPECT_NEAR(machine.body(1).angle, 0, 1e-3);
  EXPECT_NEAR(machine.body(1).omega, 0, 1e-5);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Methods, Outlines,
                         testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida));

}  // namespace
}  // namespace subsoil::mbd::outline_contact_test
