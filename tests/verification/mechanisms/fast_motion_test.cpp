// Motions that are fast for their step or their distance from the origin: cost and estimated error are what they must.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/integrators/cvode.hpp"
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

}  // namespace
}  // namespace subsoil::mbd::fast_motion_test
