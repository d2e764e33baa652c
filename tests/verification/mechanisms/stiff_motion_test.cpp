// Motions with a fast decay or a fast oscillation: cost chooses the method of the step, the result is the closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/integrators/cvode.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "libmbd/system/beam.hpp"

namespace subsoil::mbd::stiff_motion_test {
namespace {

constexpr double pi = std::numbers::pi;

const Cvode& cvode(const Machine& machine) { return dynamic_cast<const Cvode&>(machine.integrator()); }
constexpr MachineOptions fine{.integrator = IntegratorKind::cvode, .cvode = {1e-12, 1e-12}};

/// 1 kg on a spring and a damper along x, 0.1 m from its rest at x = 1 m.
Model oscillator(double stiffness, double damping) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "mass", .mass = 1, .inertia = 1, .pose = {1.1, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 1});
  m.add("spring",
        SpringDamper{.body_a = ground, .body_b = 1, .stiffness = stiffness, .free_length = 1, .damping = damping});
  return m;
}

void move_to(Machine& machine, double end, double interval) {
  machine.start_from_pose();
  while (machine.time() < end - 1e-9) machine.advance(interval);
}

// Rates of 1/s and 1e6/s: x = (r1 e^(-r2 t) - r2 e^(-r1 t))/(r1 - r2). Explicit steps stay below 2/r1 = 2 us, so that
// 5 s take more than two million of them; backward differences take as many as the slow decay asks for. Some thousand
// steps that err by 1e-14 leave 1e-11 m.
TEST(StiffMotion, AFastDecayIsIntegratedByBackwardDifferences) {
  Machine machine(oscillator(1e6, 1e6), fine);
  move_to(machine, 5, 0.05);
  const double root = std::sqrt(0.25 * 1e12 - 1e6), r1 = 0.5 * 1e6 + root, r2 = 1e6 / r1;
  const double exact = 0.1 * (r1 * std::exp(-r2 * 5) - r2 * std::exp(-r1 * 5)) / (r1 - r2);
  EXPECT_NEAR(machine.body(1).r.x - 1, exact, 1e-11);
  EXPECT_TRUE(cvode(machine).implicit());
  EXPECT_LT(cvode(machine).steps(), 20000);
  EXPECT_LT(machine.energy().closure(), 1e-10);
}

// A critically damped mass comes to rest in 2 ms of 5 s, at a place that rounding of x and 1e8 N/m shake by 1e-12 m/s.
// Steps that resolve this shaking are 20 us at most, a quarter of a million.
TEST(StiffMotion, RoundingOfAStiffSpringAtRestAsksForNoSteps) {
  Machine machine(oscillator(1e8, 2e4), fine);
  move_to(machine, 5, 0.05);
  EXPECT_NEAR(machine.body(1).r.x, 1, 1e-13);
  EXPECT_LT(cvode(machine).steps(), 20000);
}

// A steel strip of 4 mm between clamps of 1 m, one of which slides, is bent by 5 mm in 1 s and rests: 192 EI/L^3 of it,
// which 12 elements, shear and the stretch of the bent strip change by 1e-4 each. Its damping decays by 8e8/s. Rounding
// shakes it across only once it is bent: steps that resolve this are 30 ns, 6e7 of them.
TEST(StiffMotion, RoundingOfABeamThatBendsAsksForNoSteps) {
  constexpr double height = 4e-3, width = 20e-3, young = 2e11, bent = 5e-3;
  const Beam beam{.name = "strip",
                  .points = {{0, 0}, {1, 0}},
                  .section = RectangleSection{.size = {height, width}},
                  .young = young,
                  .density = 7850,
                  .damping_ratio = 0.05};
  Model m;
  m.gravity = {0, 0};
  const DividedBeam divided = divide(beam);
  for (const Body& node : divided.nodes) m.add(node);
  const int last = static_cast<int>(divided.nodes.size());
  for (BeamElement e : divided.elements) {
    ++e.body_a, ++e.body_b;
    m.add(beam.element_name(e.body_a), e);
  }
  m.add("clamp", Fixed{.body_a = ground, .body_b = 1});
  m.add("sliding clamp", Translational{.body_a = ground, .body_b = last, .p_a = {1, 0}});
  CoordinateDriver driver{.body = (last + 1) / 2, .coordinate = Coordinate::y};
  driver.motion.position = RampFunction{.to = bent, .end = 1};
  m.add("driver", driver);
  Machine machine(std::move(m), fine);
  move_to(machine, 2, 0.01);
  const double exact = 192 * young * width * height * height * height / 12 * bent;
  EXPECT_NEAR(machine.driver_force("driver"), exact, 3e-4 * exact);
  EXPECT_LT(cvode(machine).steps(), 40000);
  EXPECT_LT(machine.energy().closure(), 1e-8);
}

// A guide that locks itself creeps at v = v_reg artanh(F/(mu_s N)); N from the moment of a side force of 5 kN. Its
// friction has a rate of mu_s N/(v_reg m) = 3e8 per second, so that explicit steps of 10 ns would be 1e8.
TEST(StiffMotion, AGuideThatLocksItselfCreeps) {
  Model m;
  const int body = m.add({.name = "m", .mass = 10, .inertia = 0.1, .pose = {0, 0.5, 0}});
  m.add("guide", Translational{.body_a = ground, .body_b = body, .p_b = {0, -0.5}, .angle_a = pi / 2});
  m.add("side", AppliedForce{.body = body, .point = {0.5, 1.5}, .fx = 5000.0});
  m.add("friction", JointFriction{.joint = "guide", .guide = 0.01, .mu_s = 1.5, .mu_k = 1.2});
  Machine machine(m, fine);
  move_to(machine, 1, 0.1);
  const double normal = 2 * 5000 * 2 / 0.01;  // the force acts 2 m above the guide's point
  EXPECT_NEAR(machine.body(body).v.y, -1e-3 * std::atanh(10 * 9.81 / (1.5 * normal)), 1e-8 * 3.3e-8);
  EXPECT_NEAR(machine.body(body).r.y, 0.5 + machine.body(body).v.y, 1e-13);
  EXPECT_LT(cvode(machine).steps(), 20000);
}

// Critically damped and shaken at its own 100 rad/s: x = 1 - F/(c w) cos(w t). A decay as fast as the motion is no
// reason for low orders, which a trial finds. 2000 rad of phase err by the step's tolerance of 1e-14 some thousandfold.
TEST(StiffMotion, ADecayAsFastAsTheMotionIsIntegratedByAdams) {
  Model m = oscillator(1e4, 200);
  m.add("shaker", AppliedForce{.body = 1, .fx = HarmonicFunction{.amplitude = 1000, .frequency = 50 / pi}});
  Machine machine(m, fine);
  move_to(machine, 20, 0.05);
  EXPECT_NEAR(machine.body(1).r.x - 1, -0.05 * std::cos(100 * machine.time()), 1e-11);
  EXPECT_FALSE(cvode(machine).implicit());
}

// An undamped oscillation at 1e4 rad/s has to be followed by any method: Adams' methods of high order do it in fewer
// evaluations, and stay. 5000 rad of phase, each of which errs by the step's tolerance of 1e-14 some hundredfold.
TEST(StiffMotion, AFastOscillationIsIntegratedByAdams) {
  Machine machine(oscillator(1e8, 0), fine);
  move_to(machine, 0.5, 0.05);
  EXPECT_FALSE(cvode(machine).implicit());
  EXPECT_NEAR(machine.body(1).r.x - 1, 0.1 * std::cos(1e4 * 0.5), 1e-7);
}

}  // namespace
}  // namespace subsoil::mbd::stiff_motion_test
