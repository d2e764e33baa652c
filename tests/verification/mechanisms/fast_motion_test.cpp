// Motions that are fast for their step or their distance from the origin: cost and estimated error are what they must.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/integrators/cvode.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::fast_motion_test {
namespace {

const Cvode& cvode(const Machine& machine) { return dynamic_cast<const Cvode&>(machine.integrator()); }

/// 1 kg on a spring and a damper along x, 0.1 m from its rest at x = `origin` + 1 m.
Model oscillator(double stiffness, double damping, double origin = 0) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "mass", .mass = 1, .inertia = 1, .pose = {origin + 1.1, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 1});
  m.add("spring", SpringDamper{.body_a = ground,
                               .body_b = 1,
                               .p_a = {origin, 0},
                               .stiffness = stiffness,
                               .free_length = 1,
                               .damping = damping});
  return m;
}

void move_to(Machine& machine, double end) {
  machine.start_from_pose();
  while (machine.time() < end - 1e-9) machine.advance(0.05);
}

// 1 km from the origin x is known to 1e-13 m, a stiffness of 1e9 N/m makes of it 1e-4 m/s^2: a tolerance below what
// that does to the velocity asks for steps that cannot be. Evaluations as at the origin, give or take a half.
TEST(FastMotion, FarFromTheOriginCostsNoMore) {
  long evaluations[2];
  for (const int far : {0, 1}) {
    const double origin = far ? 1000 : 0;
    Machine machine(oscillator(1e9, 3e4, origin), {.integrator = IntegratorKind::cvode, .cvode = {1e-12, 1e-12}});
    move_to(machine, 0.05);
    evaluations[far] = cvode(machine).evaluations();
    EXPECT_NEAR(machine.body(1).r.x, origin + 1, 1e-9);  // 750 times of decay
  }
  EXPECT_LT(evaluations[1], 1.5 * static_cast<double>(evaluations[0]));
}

/// Two bars of 1 m that fall from a level pose, their pin at x = `origin`.
Model two_bars(double origin) {
  Model m;
  for (int i = 0; i < 2; ++i) {
    m.add({.name = "bar " + std::to_string(i), .mass = 1, .inertia = 1.0 / 12, .pose = {origin + i + 0.5, 0, 0}});
    m.add("pin " + std::to_string(i),
          Revolute{.body_a = i, .body_b = i + 1, .p_a = {i ? 0.5 : origin, 0}, .p_b = {-0.5, 0}});
  }
  return m;
}

// 1000 km from the origin places are known to 1e-10 m, and so are angles of bars of 1 m that are made of them: Newton's
// iteration of ida cannot ask for 1e-12. They fall as at the origin, to what 1e-10 m in some hundred steps grows to.
TEST(FastMotion, IdaFallsFarFromTheOriginAsAtIt) {
  double angles[2];
  for (const int far : {0, 1}) {
    Machine machine(two_bars(far ? 1e6 : 0), {.integrator = IntegratorKind::ida});
    move_to(machine, 2);
    angles[far] = machine.body(2).angle;
  }
  EXPECT_NEAR(angles[1], angles[0], 1e-5);
}

// A ball on an elastic floor, steps of a seventh of the contact: nearly all of the error is made where contacts restart
// the method; between them the acceleration is constant. The estimate tells the speed that the bounces lose or win, by
// the energy, within a factor of a few, as without events (HonestRuns.TheEstimateOfTheStepTellsTheError).
TEST(FastMotion, TheEstimateOfFixedStepsCoversEvents) {
  constexpr double h = 2e-3, height = 0.2;
  Model m;
  m.add({.name = "ball", .mass = 1, .inertia = 1, .pose = {0, height, 0}});
  m.add("floor",
        LineContact{.body_a = ground, .body_b = 1, .law = {.normal = {.n = 1, .stiffness = 5e4, .damping = 0}}});
  Machine machine(m, {});
  machine.start_from_pose();
  while (machine.time() < 2) machine.advance(h);
  const double speed = std::sqrt(2 * 9.81 * height);
  const double lost = std::abs(machine.energy().balance()) / (speed * speed);  // of the speed, as a share
  EXPECT_GT(lost, 1e-5) << "the case is too easy to tell anything";
  const double estimate = machine.integrator().step_error().sum();
  EXPECT_GT(estimate, 0.3 * lost);
  EXPECT_LT(estimate, 30 * lost);
}

/// Maximum difference of a body's place from that by cvode, and what fixed steps are estimated to err by.
struct Erred {
  double error = 0, estimate = 0;
};
Erred compare(const Model& model, const AdamsMoultonOptions& adams, double end) {
  constexpr double h = 1e-3;
  Machine reference(model, {.integrator = IntegratorKind::cvode, .cvode = {1e-12, 1e-12}});
  Machine machine(model, {.adams_moulton = adams});
  reference.start_from_pose(), machine.start_from_pose();
  Erred out;
  while (machine.time() < end - h / 2) {
    reference.advance(h), machine.advance(h);
    const int last = static_cast<int>(model.bodies.size());
    const Vec2 off = machine.body(last).r - reference.body(last).r;
    out.error = std::max(out.error, length(off) / machine.system().length_scale());
  }
  out.estimate = machine.integrator().step_error().sum();
  return out;
}

Model bouncing(double stiffness) {
  Model m;
  m.add({.name = "ball", .mass = 1, .inertia = 1, .pose = {0, 0.2, 0}});
  m.add("floor",
        LineContact{
            .body_a = ground, .body_b = 1, .law = {.normal = {.n = 1.5, .stiffness = stiffness, .damping = 0.05}}});
  return m;
}
Model rope() {
  Model m;
  for (int i = 0; i < 8; ++i) {
    const std::string n = std::to_string(i);
    m.add({.name = "link " + n, .mass = 0.1, .inertia = 1e-4, .pose = {0.05 + 0.1 * i, 0, 0}});
    m.add("pin " + n, Revolute{.body_a = i, .body_b = i + 1, .p_a = {i ? 0.05 : 0.0, 0}, .p_b = {-0.05, 0}});
  }
  return m;
}
/// Two cranks of 0.5 m whose ends a coupler joins.
Model watts_linkage() {
  Model m;
  constexpr double a = 0.5, x = 1, y = 0.3;
  const Vec2 one{a * std::cos(1.2), a * std::sin(1.2)}, other{x - a * std::cos(0.4), y - a * std::sin(0.4)},
      line = other - one, middle = 0.5 * (one + other);
  const double l = length(line), angle = std::atan2(line.y, line.x);
  m.add({.name = "one", .mass = 1, .inertia = a * a / 12, .pose = {one.x / 2, one.y / 2, 1.2}});
  m.add({.name = "other",
         .mass = 1,
         .inertia = a * a / 12,
         .pose = {(x + other.x) / 2, (y + other.y) / 2, std::atan2(other.y - y, other.x - x)}});
  m.add({.name = "coupler", .mass = 1, .inertia = l * l / 12, .pose = {middle.x, middle.y, angle}});
  m.add("A", Revolute{.body_a = ground, .body_b = 1, .p_b = {-a / 2, 0}});
  m.add("B", Revolute{.body_a = 1, .body_b = 3, .p_a = {a / 2, 0}, .p_b = {-l / 2, 0}});
  m.add("C", Revolute{.body_a = 3, .body_b = 2, .p_a = {l / 2, 0}, .p_b = {a / 2, 0}});
  m.add("D", Revolute{.body_a = ground, .body_b = 2, .p_a = {x, y}, .p_b = {-a / 2, 0}});
  return m;
}

// Steps of 1 ms that are halved to an error of 1e-6 per run. Five impacts and the whip of a rope magnify it: measured
// 1e-9 and 4e-7 of the length, a hundredth of what is warned of.
TEST(FastMotion, StepsHalvedToTheirErrorFollowImpactsRopesAndLinkages) {
  for (const double stiffness : {1e4, 1e5, 3e5, 1e6, 1e7}) {
    const Erred e = compare(bouncing(stiffness), {.error_per_second = 1e-6 / 1.9}, 1.9);
    EXPECT_LT(e.error, 1e-6) << stiffness;
    EXPECT_LT(e.estimate, 3e-6) << stiffness;
  }
  EXPECT_LT(compare(rope(), {.error_per_second = 0.5e-6}, 2).error, 1e-5);
  EXPECT_LT(compare(watts_linkage(), {.error_per_second = 0.2e-6}, 5).error, 1e-5);
}

// Steps of 1 ms as they are: the estimate covers the error, by what errors of velocity move the machine until the end.
// It does not know where the motion magnifies them: three times as much is allowed to linkages.
TEST(FastMotion, TheEstimateOfFixedStepsCoversTheErrorOfImpactsAndLinkages) {
  for (const double stiffness : {1e4, 3e4, 1e5, 3e5, 1e6}) {
    const Erred e = compare(bouncing(stiffness), {}, 1.9);
    EXPECT_GT(e.estimate, e.error) << stiffness;
    EXPECT_LT(e.estimate, 100 * e.error) << stiffness;
  }
  for (const Model& m : {rope(), watts_linkage()}) {
    const Erred e = compare(m, {}, 2);
    EXPECT_GT(3 * e.estimate, e.error);
  }
}

}  // namespace
}  // namespace subsoil::mbd::fast_motion_test
