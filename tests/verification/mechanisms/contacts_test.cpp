// Contacts and stops in motion: restitution of Hunt-Crossley by Lambert's W, slip to roll in closed form, a disk in a
// bore against an independent integration, stops and a rope.

#include <gtest/gtest.h>

#include <boost/math/special_functions/lambert_w.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "libmbd/forces/disk_contact.hpp"
#include "libmbd/forces/distance_stop.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/forces/slide_stop.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::contacts_test {
namespace {

class Contacts : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const { return {.integrator = GetParam(), .ida = {.rtol = 1e-11, .atol = 1e-12}}; }
};

/// Speed at which a body leaves after meeting a Hunt-Crossley contact at speed v: with y = 1 - b v_o,
/// y - 1 - ln y = b v - ln(1 + b v), so y = -W_0(-exp(-1 - b v + ln(1 + b v))). Stiffness, exponent and mass drop out.
double rebound(double b, double v) {
  const double left = b * v - std::log1p(b * v);
  return (1 + boost::math::lambert_w0(-std::exp(-1 - left))) / b;
}

/// Greatest depth of that impact: k d^(n+1)/(n+1) = m (b v - ln(1 + b v))/b^2.
double deepest(double k, double n, double b, double m, double v) {
  return std::pow((n + 1) / k * m * (b * v - std::log1p(b * v)) / (b * b), 1 / (n + 1));
}

TEST(HuntCrossleyOracle, IsElasticInTheLimitAndFallsByTwoThirds) {
  EXPECT_NEAR(rebound(1e-3, 1), 1 - 2e-3 / 3, 1e-6);
  EXPECT_LT(rebound(0.5, 4), 0.6 * 4);
}

struct Impact {
  double n, b, speed;
};

// A ball without gravity against a wall. The contact lasts some 10 ms and is passed in 2000 steps; d^n has a kink of
// order n at touch, which leaves errors of (1/2000)^(n+1) there: 2.5e-7 for n = 1. Depths are compared with the least
// gap seen at a step's end: off by a relative 1e-7 at worst. So 1e-6 for both.
TEST_P(Contacts, BallLeavesAWallAsLambertSays) {
  for (const Impact& i : {Impact{1.5, 0.4, 2}, Impact{1, 0.1, 3}, Impact{2, 1.5, 1}}) {
    SCOPED_TRACE(testing::Message() << "n = " << i.n << ", b = " << i.b);
    constexpr double mass = 0.8, radius = 0.05, k = 2e5;
    Model m;
    m.gravity = {0, 0};
    const double start = 0.5 * i.speed * 1e-3;
    m.add({.name = "ball", .mass = mass, .inertia = 1, .pose = {0, radius + start, 0}, .velocity = {0, -i.speed, 0}});
    m.add("wall", LineContact{.body_a = ground,
                              .body_b = 1,
                              .radius = radius,
                              .law = {.normal = {.n = i.n, .stiffness = k, .damping = i.b}}});
    Machine machine(m, options());
    machine.start_from_pose();
    // 2 d / v is of the length of the contact; 5 of them are past it.
    const double depth = deepest(k, i.n, i.b, mass, i.speed), h = 2 * depth / i.speed / 1000;
    double least = 0;
    for (int step = 0; step < 5000; ++step) {
      machine.advance(h);
      least = std::min(least, machine.force_value("wall", "gap"));
    }
    ASSERT_GT(machine.force_value("wall", "gap"), 0);
    EXPECT_NEAR(machine.body(1).v.y, rebound(i.b, i.speed), 1e-6 * i.speed);
    EXPECT_NEAR(-least, depth, 1e-6 * depth);
    const double out = machine.body(1).v.y;
    EXPECT_NEAR(machine.energy().lost, 0.5 * mass * (i.speed * i.speed - out * out), 1e-6 * mass * i.speed * i.speed);
    EXPECT_EQ(machine.body(1).v.x, 0);
  }
}

// A bar on a pin swings into a rotational stop, a block on a slide into a slide stop, and a ball into the end of its
// rope: each is the same impact with its own inertia.
TEST_P(Contacts, StopsReboundAsTheBallDoes) {
  constexpr double k = 3e4, b = 0.3, v = 2;
  const HuntCrossleyForce law{.n = 1.5, .stiffness = k, .damping = b};
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "bar", .mass = 3, .inertia = 0.2, .pose = {0.4, 0, 0}, .velocity = {0, 0.4 * v, v}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.4, 0}});
  m.add("turn", RotationalStop{.body_a = ground, .body_b = 1, .limits = {.least = -1, .largest = 1e-3, .law = law}});
  m.add({.name = "block", .mass = 0.7, .inertia = 1, .pose = {0, 5, 0}, .velocity = {-v, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 2, .p_a = {0, 5}});
  m.add("end", SlideStop{.body_a = ground, .body_b = 2, .p_a = {0, 5}, .limits = {.least = -1e-3, .law = law}});
  m.add({.name = "ball", .mass = 0.7, .inertia = 1, .pose = {0, -2, 0}, .velocity = {0, -v, 0}});
  m.add("rope", DistanceStop{.body_a = ground, .body_b = 3, .limits = {.largest = 2.001, .law = law}});
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 0; i < 8000; ++i) machine.advance(1e-5);
  for (const char* stop : {"turn", "end", "rope"}) EXPECT_GT(machine.force_value(stop, "gap"), 0) << stop;
  const double out = rebound(b, v);
  EXPECT_NEAR(machine.body(1).omega, -out, 1e-6 * v);
  EXPECT_NEAR(machine.body(2).v.x, out, 1e-6 * v);
  EXPECT_NEAR(machine.body(3).v.y, out, 1e-6 * v);
}

/// A disk laid on the ground at rest depth, sliding at v.
struct Sliding {
  static constexpr double mass = 2, radius = 0.1, k = 1e5, mu = 0.25, g = 9.81, v = 1.5, slip_speed = 0.02;
  static Model model() {
    Model m;
    const double depth = std::pow(mass * g / k, 1 / 1.5);
    m.add({.name = "disk",
           .mass = mass,
           .inertia = 0.5 * mass * radius * radius,
           .pose = {0, radius - depth, 0},
           .velocity = {v, 0, 0}});
    m.add("ground",
          LineContact{
              .body_a = ground,
              .body_b = 1,
              .radius = radius,
              .law = {.normal = {.n = 1.5, .stiffness = k, .damping = 2}, .friction = mu, .slip_speed = slip_speed}});
    return m;
  }
};

// Slip to roll. The disk lies at its rest depth, so N is constant and the slip s = v + R spin obeys
// s' = -3 mu g tanh(s/s_0) exactly: sinh(s/s_0) = sinh(v_0/s_0) exp(-3 mu g t/s_0). The moment about the contact keeps
// v - R spin/2 = v_0, so the disk rolls at 2/3 v_0 whatever the law of friction. Against Coulomb's sharp law the slip
// lies above by 0 to s_0 asinh(1/2).
TEST_P(Contacts, SlidingDiskComesToRoll) {
  using S = Sliding;
  Machine machine(S::model(), options());
  machine.start_from_pose();
  const double rate = 3 * S::mu * S::g, roll_at = S::v / rate;
  for (int i = 1; i <= 4000; ++i) {
    machine.advance(1e-4);
    const double t = machine.time(), z = (S::v - rate * t) / S::slip_speed;
    // sinh(v/s_0) exp(-z') = (exp(z) - exp(z - 2 v/s_0))/2, the second term below 1e-65.
    const double slip = S::slip_speed * std::asinh(0.5 * std::exp(z));
    ASSERT_NEAR(machine.force_value("ground", "slip"), slip, 1e-6 * S::v) << "t = " << t;
    const double over = machine.force_value("ground", "slip") - std::max(0.0, S::v - rate * t);
    ASSERT_GE(over, -1e-6 * S::v);
    ASSERT_LE(over, S::slip_speed * std::asinh(0.5) + 1e-6 * S::v);
    const BodyState& d = machine.body(1);
    ASSERT_NEAR(d.v.x - 0.5 * S::radius * d.omega, S::v, 1e-9) << "moment about the contact";
  }
  ASSERT_GT(machine.time(), 1.5 * roll_at);
  const BodyState& d = machine.body(1);
  EXPECT_NEAR(d.v.x, 2.0 / 3 * S::v, 1e-6 * S::v);
  EXPECT_NEAR(-d.omega * S::radius, d.v.x, 1e-6 * S::v);
  EXPECT_NEAR(machine.energy().lost, 0.5 * S::mass * S::v * S::v / 3, 1e-6);  // a third of the energy is rubbed away
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7);
}

// A disk rolls and bounces in a bore under gravity, against its own equations of motion in x, y, angle written for this
// case alone and integrated by Runge-Kutta-Fehlberg 7(8). Smooth contact (n = 2, closed all the time): 1e-6.
TEST_P(Contacts, DiskInABoreAgainstItsOwnEquations) {
  constexpr double mass = 1, inertia = 0.02, bore = 1, r = 0.2, k = 1e5, b = 0.5, mu = 0.2, s_0 = 0.3, g = 9.81;
  const double off = bore - r + 0.01, x = off * std::sin(0.8), y = -off * std::cos(0.8);
  Model m;
  m.add({.name = "disk", .mass = mass, .inertia = inertia, .pose = {x, y, 0}});
  m.add("bore",
        DiskContact{.body_a = ground,
                    .body_b = 1,
                    .radius_a = bore,
                    .radius_b = r,
                    .side = DiskSide::inside,
                    .law = {.normal = {.n = 2, .stiffness = k, .damping = b}, .friction = mu, .slip_speed = s_0}});
  Machine machine(m, options());
  machine.start_from_pose();
  const auto right = [&](const test::OdeState& s, test::OdeState& d, double) {
    const double l = std::hypot(s[0], s[1]), ux = s[0] / l, uy = s[1] / l, depth = std::max(0.0, l - (bore - r));
    const double closing = ux * s[3] + uy * s[4];
    const double n = std::max(0.0, k * depth * depth * (1 + b * closing));
    // Velocity along the counter-clockwise direction of the bore, (-uy, ux), in the middle of the overlap: half of the
    // depth inside the disk's rim, which is at +r u from the centre.
    const double arm = r - 0.5 * depth;
    const double slip = -uy * s[3] + ux * s[4] + arm * s[5], f = -mu * n * std::tanh(slip / s_0);
    d = {s[3], s[4], s[5], (-n * ux - f * uy) / mass, (-n * uy + f * ux) / mass - g, arm * f / inertia};
  };
  test::OdeState s{x, y, 0, 0, 0, 0};
  double t = 0;
  for (int i = 1; i <= 20; ++i) {
    for (int j = 0; j < 1000; ++j) machine.advance(1e-4);
    s = test::solve_ode(right, s, t, machine.time());
    t = machine.time();
    EXPECT_NEAR(machine.body(1).r.x, s[0], 1e-6) << "t = " << t;
    EXPECT_NEAR(machine.body(1).r.y, s[1], 1e-6) << "t = " << t;
    EXPECT_NEAR(machine.body(1).omega, s[5], 1e-5) << "t = " << t;
  }
  EXPECT_GT(std::abs(machine.body(1).angle), 0.5);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-5);
}

/// Integral by Simpson's rule.
double integral(const std::function<double(double)>& f, double end) {
  constexpr int n = 2000;
  double sum = f(0) + f(end);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * f(end * i / n);
  return sum * end / (3 * n);
}

// A uniform ladder slides down a smooth wall from 60 deg, turning at sqrt(3 g (sin 60 - sin a)/l), and leaves the wall
// where its top has come to two thirds of its height. What the elastic ends give way, some 5e-8 m, sets it back by 1e-7
// of the time.
TEST_P(Contacts, LadderLeavesTheWallAtTwoThirdsOfItsHeight) {
  constexpr double l = 2, mass = 10, g = 9.81, start = std::numbers::pi / 3;
  Model m;
  m.add({.name = "ladder",
         .mass = mass,
         .inertia = mass * l * l / 12,
         .pose = {l / 2 * std::cos(start), l / 2 * std::sin(start), std::numbers::pi - start}});
  for (const auto& [name, end, along] : {std::tuple{"floor", -l / 2, 0.0}, {"wall", l / 2, -std::numbers::pi / 2}})
    m.add(name, LineContact{.body_a = ground,
                            .body_b = 1,
                            .p_b = {end, 0},
                            .angle_a = along,
                            .law = {.normal = {.n = 1, .stiffness = 1e9, .damping = 100}}});
  Machine machine(m, options());
  machine.start_from_pose();
  while (machine.time() < 0.47) machine.advance(1e-5);
  const double end = std::asin(2. / 3 * std::sin(start));
  // With a = start - u^2, without the pole at rest.
  const double leaves = integral(
      [&](double u) {
        if (u == 0) return 2 / std::sqrt(3 * g / l * std::cos(start));
        return 2 * u / std::sqrt(3 * g / l * (std::sin(start) - std::sin(start - u * u)));
      },
      std::sqrt(start - end));
  const Event& last = machine.events().back();
  EXPECT_EQ(last.name, "wall");
  EXPECT_EQ(last.direction, 1);
  EXPECT_NEAR(last.t, leaves, 5e-7);
}

// A smooth disk that is pushed over the top of a cylinder leaves where g cos a = v^2/(R + r): cos a = (2 + v_0^2/(g (R
// + r)))/3.
TEST_P(Contacts, DiskLeavesACylinder) {
  constexpr double rho = 0.6, g = 9.81, v = 0.5;
  Model m;
  m.add({.name = "disk", .mass = 1, .inertia = 0.005, .pose = {0, rho, 0}, .velocity = {v, 0, 0}});
  m.add("cylinder", DiskContact{.body_a = ground,
                                .body_b = 1,
                                .radius_a = 0.5,
                                .radius_b = 0.1,
                                .law = {.normal = {.n = 1, .stiffness = 1e8, .damping = 100}}});
  Machine machine(m, options());
  machine.start_from_pose();
  while (machine.time() < 0.53) machine.advance(2e-5);
  const double leaves =
      integral([&](double a) { return 1 / std::sqrt(v * v / (rho * rho) + 2 * g / rho * (1 - std::cos(a))); },
               std::acos((2 + v * v / (g * rho)) / 3));
  const Event& last = machine.events().back();
  EXPECT_EQ(last.direction, 1);
  EXPECT_NEAR(last.t, leaves, 5e-7);
}

INSTANTIATE_TEST_SUITE_P(Both, Contacts, testing::Values(IntegratorKind::adams_moulton, IntegratorKind::ida));

}  // namespace
}  // namespace subsoil::mbd::contacts_test
