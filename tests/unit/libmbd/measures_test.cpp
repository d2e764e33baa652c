// Measures of machines whose motion at the start is known in closed form.

#include "libmbd/measures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"
#include "libmbd/measures/acceleration.hpp"
#include "libmbd/measures/angle.hpp"
#include "libmbd/measures/distance.hpp"
#include "libmbd/measures/energy.hpp"
#include "libmbd/measures/force.hpp"
#include "libmbd/measures/position.hpp"
#include "libmbd/measures/reaction.hpp"
#include "libmbd/measures/velocity.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::measures_test {
namespace {

constexpr double g = 9.81;

std::map<std::string, double> columns_of(const Machine& machine) {
  std::vector<double> values(machine.column_names().size());
  machine.columns(values);
  std::map<std::string, double> by_name;
  for (std::size_t i = 0; i < values.size(); ++i) by_name[machine.column_names()[i]] = values[i];
  return by_name;
}

/// A body whose centre follows a parabola while it turns with a constant angular acceleration.
struct Flight {
  Vec2 r, v, a;
  double angle, omega, alpha;
  Vec2 centre(double t) const { return r + t * v + 0.5 * t * t * a; }
  double angle_at(double t) const { return angle + t * omega + 0.5 * t * t * alpha; }
  Vec2 point(const Marker& m, double t) const {
    const double c = std::cos(angle_at(t)), s = std::sin(angle_at(t));
    return centre(t) + Vec2{c * m.p[0] - s * m.p[1], s * m.p[0] + c * m.p[1]};
  }
};

const Flight first{{0.3, -0.2}, {1.5, 0.4}, {0.7, -g}, 0.4, -2.1, 5};
const Flight second{{-1.1, 0.9}, {-0.8, 2.2}, {-1.3, -g}, -0.9, 3.3, -4};
const Marker world{.name = "ground"};
const Marker p{.name = "p", .body = 1, .p = {0.25, -0.4}, .angle = 0.3};
const Marker q{.name = "q", .body = 2, .p = {-0.15, 0.35}, .angle = -1.2};

/// Two free bodies in flight, each under a force and moment that give the wanted accelerations.
Model two_flights() {
  Model m;
  m.gravity = {0, -g};
  for (const Flight* f : {&first, &second}) {
    const std::string name = f == &first ? "first" : "second";
    const int body = m.add({.name = name,
                            .mass = 2,
                            .inertia = 0.5,
                            .pose = {f->r.x, f->r.y, f->angle},
                            .velocity = {f->v.x, f->v.y, f->omega}});
    m.add("load on " + name, AppliedForce{.body = body, .fx = 2 * f->a.x, .moment = 0.5 * f->alpha});
  }
  return m;
}

/// Where q's observer sees p, in q's axes, at time t: of the closed forms alone.
Vec2 seen(double t) {
  const Vec2 d = first.point(p, t) - second.point(q, t);
  const double turn = second.angle_at(t) + q.angle, c = std::cos(turn), s = std::sin(turn);
  return {c * d.x + s * d.y, c * d.y - s * d.x};
}

/// Central difference of eighth order (Fornberg 1988): at steps of 10 ms and rates of 5 rad/s off by some 1e-12 of the
/// value, half of it truncation; once more differentiated, by some 1e-10.
template <class F>
double rate_of(F f, double t) {
  constexpr double h = 0.01, weights[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  double sum = 0;
  for (int k = 1; k <= 4; ++k) sum += weights[k - 1] * (f(t + k * h) - f(t - k * h));
  return sum / h;
}

// What an observer on a flying, turning body sees is the derivative of the place at which he sees it.
TEST(Measures, AnObserverOnABodySeesTheDerivativesOfThePlace) {
  Machine machine(two_flights());
  machine.start_from_pose();
  machine.measure("place", PositionMeasure{.of = p, .from = q, .in = q});
  machine.measure("speed", VelocityMeasure{.of = p, .from = q, .in = q});
  machine.measure("push", AccelerationMeasure{.of = p, .from = q, .in = q});
  const auto found = columns_of(machine);
  const auto x = [](double t) { return seen(t).x; };
  const auto y = [](double t) { return seen(t).y; };
  const auto vx = [&](double t) { return rate_of(x, t); };
  const auto vy = [&](double t) { return rate_of(y, t); };
  EXPECT_NEAR(found.at("place.x"), x(0), 1e-14);
  EXPECT_NEAR(found.at("place.y"), y(0), 1e-14);
  EXPECT_NEAR(found.at("speed.x"), vx(0), 1e-10);
  EXPECT_NEAR(found.at("speed.y"), vy(0), 1e-10);
  EXPECT_NEAR(found.at("push.x"), rate_of(vx, 0), 1e-9);
  EXPECT_NEAR(found.at("push.y"), rate_of(vy, 0), 1e-9);
}

TEST(Measures, DistancesAndAnglesFollowTheGeometry) {
  Machine machine(two_flights());
  machine.start_from_pose();
  machine.measure("gap", DistanceMeasure{{p, q}});
  machine.measure("parting", DistanceRateMeasure{{p, q}});
  machine.measure("turn", AngleMeasure{.of = p, .from = q});
  machine.measure("turning", AngularVelocityMeasure{.of = p, .from = q});
  machine.measure("spin up", AngularAccelerationMeasure{.of = p, .from = q});
  machine.measure("from afar", VelocityMeasure{.of = p, .part = VectorPart::size});
  machine.measure("corner", CornerMeasure{{p, q, world}});
  const auto found = columns_of(machine);
  const auto gap = [](double t) { return length(first.point(p, t) - second.point(q, t)); };
  EXPECT_NEAR(found.at("gap"), gap(0), 1e-14);
  EXPECT_NEAR(found.at("parting"), rate_of(gap, 0), 1e-11);
  EXPECT_NEAR(found.at("turn"), 0.4 + 0.3 + 0.9 + 1.2, 1e-15);
  EXPECT_NEAR(found.at("turning"), -2.1 - 3.3, 1e-15);
  EXPECT_NEAR(found.at("spin up"), 5.0 + 4.0, 1e-13);
  const Vec2 arm = first.point(p, 0) - first.r;
  EXPECT_NEAR(found.at("from afar"), std::hypot(1.5 + 2.1 * arm.y, 0.4 - 2.1 * arm.x), 1e-14);
  const Vec2 at = second.point(q, 0), e = first.point(p, 0) - at, f = Vec2{} - at;
  EXPECT_NEAR(std::cos(found.at("corner")), dot(e, f) / (length(e) * length(f)), 1e-14);
  EXPECT_GT(found.at("corner") * cross(e, f), 0) << "counter-clockwise from the first line";
}

/// A rod of 3 kg and 1.6 m on a pin at the origin, `angle` above the level, turning at `spin`.
constexpr double mass = 3, rod_length = 1.6;
Model pendulum(double angle, double spin) {
  const double half = rod_length / 2;
  Model m;
  m.gravity = {0, -g};
  m.add({.name = "rod",
         .mass = mass,
         .inertia = mass * rod_length * rod_length / 12,
         .pose = {half * std::cos(angle), half * std::sin(angle), angle},
         .velocity = {-half * std::sin(angle) * spin, half * std::cos(angle) * spin, spin}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_a = {0, 0}, .p_b = {-half, 0}});
  return m;
}

// A rod on a pin: along it the pin carries m (g sin(angle) - spin^2 l/2), across it a quarter of the weight's part
// m g cos(angle), since the rod takes three quarters of it by falling.
TEST(Measures, ReactionOfAPinInTheRodsAxesAndAboutItsEnd) {
  const double angle = 0.6, spin = 2.5;
  Machine machine(pendulum(angle, spin));
  machine.start_from_pose();
  const Marker rod{.name = "rod", .body = 1}, tip{.name = "tip", .body = 1, .p = {rod_length / 2, 0}};
  ReactionMeasure on_rod, on_ground, about_tip;
  on_rod.element = on_ground.element = about_tip.element = "pin";
  on_rod.on = about_tip.on = 1, on_rod.in = about_tip.in = rod;
  about_tip.about = tip, about_tip.part = WrenchPart::moment;
  machine.measure("pin on rod", on_rod);
  machine.measure("pin on ground", on_ground);
  machine.measure("lever", about_tip);
  const auto found = columns_of(machine);
  const double along = mass * (g * std::sin(angle) - spin * spin * rod_length / 2),
               across = mass * g * std::cos(angle) / 4;
  EXPECT_NEAR(found.at("pin on rod.x"), along, 1e-12);
  EXPECT_NEAR(found.at("pin on rod.y"), across, 1e-12);
  EXPECT_NEAR(found.at("pin on rod.moment"), 0, 1e-12);
  EXPECT_NEAR(found.at("pin on ground.x"), -along * std::cos(angle) + across * std::sin(angle), 1e-12);
  EXPECT_NEAR(found.at("pin on ground.y"), -along * std::sin(angle) - across * std::cos(angle), 1e-12);
  EXPECT_NEAR(found.at("lever"), -across * rod_length, 1e-12);
}

// A spring of 200 N/m and 2.5 m, stretched to 3 m, pulls the rod's tip straight up: the level rod is turned about its
// centre by 100 N x 0.8 m, and pulled down by the same is the ground, with no moment about the line of action.
TEST(Measures, ForceOfASpringOnEitherBody) {
  Model m;
  m.gravity = {0, -g};
  m.add({.name = "rod", .mass = mass, .inertia = 1, .pose = {rod_length / 2, 0, 0}});
  m.add("spring", SpringDamper{.body_a = ground,
                               .body_b = 1,
                               .p_a = {rod_length, 3},
                               .p_b = {rod_length / 2, 0},
                               .stiffness = 200,
                               .free_length = 2.5});
  Machine machine(m);
  machine.start_from_pose();
  ForceMeasure on_rod, on_ground;
  on_rod.element = on_ground.element = "spring";
  on_ground.on = ground, on_ground.about = {.name = "anchor", .p = {rod_length, 7}};
  machine.measure("on rod", on_rod);
  machine.measure("on ground", on_ground);
  const auto found = columns_of(machine);
  EXPECT_NEAR(found.at("on rod.x"), 0, 1e-12);
  EXPECT_NEAR(found.at("on rod.y"), 100, 1e-12);
  EXPECT_NEAR(found.at("on rod.moment"), 80, 1e-12);
  EXPECT_NEAR(found.at("on ground.y"), -100, 1e-12);
  EXPECT_NEAR(found.at("on ground.moment"), 0, 1e-12);
}

TEST(Measures, EnergyOfABody) {
  Machine machine(two_flights());
  machine.start_from_pose();
  machine.measure("account", EnergyMeasure{.body = 1});
  machine.measure("all", EnergyMeasure{.body = 1, .part = EnergyMeasure::Part::sum});
  const auto found = columns_of(machine);
  EXPECT_NEAR(found.at("account.kinetic"), 0.5 * (2 * (1.5 * 1.5 + 0.4 * 0.4) + 0.5 * 2.1 * 2.1), 1e-14);
  EXPECT_NEAR(found.at("account.potential"), -2 * g * 0.2, 1e-14);
  EXPECT_NEAR(found.at("all"), found.at("account.kinetic") + found.at("account.potential"), 1e-14);
}

TEST(Measures, RefuseJointsAndBodiesThatAreNotThere) {
  Machine machine(pendulum(0, 0));
  ReactionMeasure reaction;
  reaction.element = "pim";
  EXPECT_EQ(test::message_of([&] { machine.measure("r", reaction); }), "no joint 'pim'; there are pin");
  Model m;
  for (const char* name : {"a", "b", "c"}) m.add({.name = name, .mass = 1, .inertia = 1});
  m.add("pin", Revolute{.body_a = 1, .body_b = 2});
  Machine three(m);
  reaction.element = "pin", reaction.on = 3;
  EXPECT_EQ(test::message_of([&] { three.measure("r", reaction); }),
            "joint 'pin' does not act on 'c'; let `on` be one of a, b");
}

}  // namespace
}  // namespace subsoil::mbd::measures_test
