// Contacts that close and open again within what would be one step of a method with its own step control.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/forces/disk_contact.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/outline_contact.hpp"
#include "libmbd/integrators/adaptive.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::hidden_contacts_test {
namespace {

constexpr double kStiffness = 1e7, kMass = 1, kRadius = 0.01;
const ContactLaw elastic{.normal = {.n = 1, .stiffness = kStiffness}};

class HiddenContacts : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(All, HiddenContacts, testing::Values(IntegratorKind::cvode, IntegratorKind::ida));

Model flying_ball(double speed) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "ball", .mass = kMass, .inertia = 1e-3, .pose = {0, 0, 0}, .velocity = {speed, 0, 0}});
  return m;
}

// Against a linear spring a ball turns round in half a period: where and when it is afterwards is known. 1e-6 of the
// way is a hundred times what the default tolerances (1e-8) leave of a contact.
void expect_returned(const Machine& machine, double distance, double speed, double end) {
  const double met = distance / speed, contact = std::numbers::pi * std::sqrt(kMass / kStiffness);
  EXPECT_NEAR(machine.body(1).v.x, -speed, 1e-6 * speed);
  EXPECT_NEAR(machine.body(1).r.x, distance - speed * (end - met - contact), 1e-6 * distance);
  ASSERT_EQ(machine.events().size(), 2U);
  EXPECT_NEAR(machine.events()[0].t, met, 1e-9 * end);
  EXPECT_NEAR(machine.events()[1].t, met + contact, 1e-6 * contact + 1e-9 * end);
}

TEST_P(HiddenContacts, ABallComesBackFromAPeg) {
  for (const double speed : {1.0, 10.0, 100.0})
    for (const double radius : {1e-3, 1e-2})
      for (const double interval : {1.0, 1e-2}) {
        const double distance = 5.3, end = 10 / speed;
        Model m = flying_ball(speed);
        m.add("peg", DiskContact{.body_a = ground,
                                 .body_b = 1,
                                 .p_a = {distance + radius + kRadius, 0},
                                 .radius_a = radius,
                                 .radius_b = kRadius,
                                 .law = elastic});
        if (speed * std::sqrt(kMass / kStiffness) > 0.9 * (radius + kRadius)) continue;  // it would go through
        SCOPED_TRACE(testing::Message() << speed << " m/s, " << radius << " m, every " << interval);
        Machine machine(std::move(m), {.integrator = GetParam()});
        machine.start_from_pose();
        for (double t = interval * end; t < end * (1 + 1e-9); t += interval * end) machine.advance(interval * end);
        expect_returned(machine, distance, speed, end);
      }
}

// A thin plate, as the outline of a body.
TEST_P(HiddenContacts, ABallComesBackFromAPlate) {
  const double speed = 3, distance = 7, end = 5;
  Model m = flying_ball(speed);
  const double front = distance + kRadius, back = front + 3e-3;
  OutlineContact plate{.body_a = ground, .body_b = 1, .law = elastic};
  plate.first = PolygonOutline{.points = {{front, -1}, {back, -1}, {back, 1}, {front, 1}}};
  plate.second = DiskOutline{.radius = kRadius};
  plate.prepare();
  m.add("plate", plate);
  Machine machine(std::move(m), {.integrator = GetParam()});
  machine.start_from_pose();
  machine.advance(end);
  expect_returned(machine, distance, speed, end);
}

// The tip of a turning rod meets a peg on its circle: one freedom and no loss, so it comes back as it went.
TEST_P(HiddenContacts, ARodComesBackFromAPegOnItsCircle) {
  for (const double off : {0.0, 3e-3}) {
    Model m;
    m.gravity = {0, 0};
    const double spin = 20, at = 2, length = 1;
    m.add({.name = "rod", .mass = 1, .inertia = 1. / 12, .pose = {0.5, 0, 0}, .velocity = {0, 0.5 * spin, spin}});
    m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
    m.add("peg", DiskContact{.body_a = ground,
                             .body_b = 1,
                             .p_a = {(length + off) * std::cos(at), (length + off) * std::sin(at)},
                             .p_b = {0.5, 0},
                             .radius_a = 5e-3,
                             .radius_b = 5e-3,
                             .law = elastic});
    Machine machine(std::move(m), {.integrator = GetParam()});
    machine.start_from_pose();
    machine.advance(0.15);
    EXPECT_NEAR(machine.body(1).omega, -spin, 1e-6 * spin) << off;
  }
}

// The pin of a Geneva drive enters a slot of a wheel at rest along its axis and leaves the axis as R (1 - cos phi). It
// touches where that is the clearance. Frozen, the wheel would be passed through, and the root finder would see where
// the pin comes out; what closes first is what counts.
TEST_P(HiddenContacts, APinTouchesItsSlotWhereTheClearanceEnds) {
  const double radius = 0.05, pin = 5e-3, clearance = 2e-5, side = pin + clearance, depth = 0.015;
  const double distance = radius * std::numbers::sqrt2, rate = 2 * std::numbers::pi, early = std::numbers::pi / 12;
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "crank",
         .mass = 1,
         .inertia = 1e-3,
         .pose = {0, 0, -std::numbers::pi / 4 - early},
         .velocity = {0, 0, rate}});
  m.add({.name = "wheel", .mass = 1, .inertia = 5e-4, .pose = {distance, 0, std::numbers::pi / 4}});
  m.add("O", Revolute{.body_a = ground, .body_b = 1});
  m.add("W", Revolute{.body_a = ground, .body_b = 2, .p_a = {distance, 0}});
  m.add("turn", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = rate}});
  OutlineContact slots{.body_a = 2, .body_b = 1, .law = {.normal = {.n = 1, .stiffness = 5e6}}};
  PolygonOutline cross{.points = {}, .corner_radius = 2e-4};
  for (int k = 0; k < 4; ++k) {
    const double c = std::cos(k * std::numbers::pi / 2), s = std::sin(k * std::numbers::pi / 2);
    for (const Vec2 p : {Vec2{radius, -side}, Vec2{depth, -side}, Vec2{depth, side}, Vec2{radius, side}})
      cross.points.push_back({c * p.x - s * p.y, s * p.x + c * p.y});
  }
  slots.first = cross;
  slots.second = DiskOutline{.radius = pin, .centre = {radius, 0}};
  slots.prepare();
  m.add("pin", slots);
  Machine machine(std::move(m), {.integrator = GetParam()});
  machine.start_from_pose();
  machine.advance(0.1);
  ASSERT_FALSE(machine.events().empty());
  EXPECT_NEAR(machine.events()[0].t, (early + std::acos(1 - clearance / radius)) / rate, 1e-9);
}

// Steps of free flight grow without bound, and a contact in one of them may last for any share of it: a soft peg far
// away, into which the ball dips by `depth`, is met where the straight line enters its circle.
TEST_P(HiddenContacts, ABallGrazesAPegFarAway) {
  struct Case {
    double distance, speed, radius, depth;
  };
  for (const Case& c :
       {Case{40, 1, 0.1, 0.02}, Case{10, 50, 0.01, 3e-4}, Case{1000, 1, 0.01, 1e-3}, Case{3e5, 300, 0.01, 1e-3}}) {
    SCOPED_TRACE(testing::Message() << c.distance << " m, " << c.speed << " m/s");
    Model m = flying_ball(c.speed);
    m.add("peg", DiskContact{.body_a = ground,
                             .body_b = 1,
                             .p_a = {c.distance, 2 * c.radius - c.depth},
                             .radius_a = c.radius,
                             .radius_b = c.radius,
                             .law = {.normal = {.n = 1, .stiffness = 1e-3}}});
    Machine machine(std::move(m), {.integrator = GetParam()});
    machine.start_from_pose();
    machine.advance((c.distance + 1) / c.speed);
    ASSERT_EQ(machine.events().size(), 2U);
    const double half = std::sqrt(c.depth * (4 * c.radius - c.depth));  // of the chord
    EXPECT_NEAR(machine.events()[0].t, (c.distance - half) / c.speed, 1e-3 * half / c.speed);
    EXPECT_NEAR(machine.events()[1].t, (c.distance + half) / c.speed, 1e-3 * half / c.speed);
  }
}

// A contact shorter than the first step after its touch: with no force at either end of that, ida passed the peg,
// though touch and release were events. The velocity is that of a Runge-Kutta method of order 8 (DOP853, 1e-12).
TEST_P(HiddenContacts, AShortContactActsThoughTheStepBehindItsTouchIsLonger) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "ball", .mass = 0.1, .inertia = 1e-5, .pose = {-100, 0.004, 0}, .velocity = {100, 0, 0}});
  m.add({.name = "bystander", .mass = 1, .inertia = 1e-4, .pose = {50, 0, 0}});
  m.add("peg", DiskContact{.body_a = ground,
                           .body_b = 1,
                           .radius_a = 0.002,
                           .radius_b = 0.003,
                           .law = {.normal = {.n = 1.5, .stiffness = 1e8}}});
  Machine machine(std::move(m), {.integrator = GetParam()});
  machine.start_from_pose();
  machine.advance(2);
  EXPECT_EQ(machine.events().size(), 2U);
  EXPECT_NEAR(machine.body(1).v.y, 1.029159, 2e-6);
}

// The automatic step of adams-moulton resolves an impact in parts of itself. Its touch was looked for at the ends of
// the whole step alone: the restitution was that of the slowest impact, 0.01 in place of 0.6.
TEST(AutomaticStep, TakesTheSpeedOfAnImpactWithinIt) {
  for (const double stiffness : {1e9, 1e10, 1e11})
    for (const double height : {0.01, 0.0102, 0.0107}) {
      Model m;
      m.gravity = {0, 0};
      m.add({.name = "ball", .mass = 1, .inertia = 0.004, .pose = {0, 0.1 + height, 0}, .velocity = {0, -1, 0}});
      LineContact floor{.body_a = ground, .body_b = 1, .angle_a = 0, .radius = 0.1};
      floor.law.normal = {.n = 1.5, .stiffness = stiffness, .restitution = 0.6};
      m.add("floor", floor);
      Machine machine(std::move(m),
                      {.integrator = IntegratorKind::adams_moulton, .adams_moulton = {.error_per_second = 1e-6}});
      machine.start_from_pose();
      for (int i = 0; i < 32; ++i) machine.advance(1e-3);
      SCOPED_TRACE(testing::Message() << stiffness << " N/m^1.5, " << height << " m");
      EXPECT_NEAR(machine.body(1).v.y, 0.6, 1e-5);
      EXPECT_EQ(machine.events().size(), 2U);
    }
}

// What passes beside a peg touches nothing, however near.
TEST_P(HiddenContacts, ABallPassesBesideAPeg) {
  Model m = flying_ball(10);
  m.add("peg", DiskContact{.body_a = ground,
                           .body_b = 1,
                           .p_a = {5, 2 * kRadius + 1e-6},
                           .radius_a = kRadius,
                           .radius_b = kRadius,
                           .law = elastic});
  Machine machine(std::move(m), {.integrator = GetParam()});
  machine.start_from_pose();
  machine.advance(1);
  EXPECT_EQ(machine.events().size(), 0U);
  EXPECT_NEAR(machine.body(1).r.x, 10, 1e-12);
}

// A bracket of two neighbouring times cannot be narrowed, whatever width is asked for; of a wide one |t - 0.3| is found
// to that width.
TEST(FindMinimum, EndsAtTheRoundingOfItsBracket) {
  const auto apex = [](double t) { return std::abs(t - 0.3); };
  const double none = -1;
  const Minimum narrow = find_minimum(apex, 1, std::nextafter(1, 2), 1e-30, none);
  EXPECT_NEAR(narrow.at, 1, 1e-15);
  EXPECT_NEAR(find_minimum(apex, 0, 1, 1e-12, none).at, 0.3, 1e-12);
  EXPECT_LT(find_minimum(apex, 0, 1, 1e-12, 0.1).value, 0.1) << "the first value below what is enough";
}

}  // namespace
}  // namespace subsoil::mbd::hidden_contacts_test
