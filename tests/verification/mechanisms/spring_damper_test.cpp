// One degree of freedom each, closed form: the two acceptance cases of the source's authors for their solver.

#include "libmbd/forces/spring_damper.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/verified.hpp"

namespace subsoil::mbd::spring_damper_test {
namespace {

/// Damped free oscillation x'' + 2 d x' + w^2 x = 0 from (x0, v0).
struct Oscillator {
  double w2, d, x0, v0;
  double at(double t) const {
    const double wd = std::sqrt(w2 - d * d);
    return std::exp(-d * t) * (x0 * std::cos(wd * t) + (v0 + d * x0) / wd * std::sin(wd * t));
  }
};

class Closed : public testing::TestWithParam<IntegratorKind> {
 protected:
  const char* solver() const { return GetParam() == IntegratorKind::ida ? "ida" : "adams-moulton"; }
  MachineOptions options() const { return {.integrator = GetParam(), .ida = {.rtol = 1e-11, .atol = 1e-12}}; }
};

// Mass on a vertical slide, hung on a spring and damper above it. (w h)^4 = (0.02)^4 = 2e-7 relative per radian times
// 0.35: about 1e-9 of the amplitude over 2 s; IDA at 1e-11 does better than its order demands. 1e-8 for both.
TEST_P(Closed, TranslationalSpringDamper) {
  constexpr double mass = 4, k = 1600, c = 8, g = 9.81, free = 0.5, start = -0.55;
  Model m;
  const int block =
      m.add({.name = "block", .mass = mass, .inertia = 1, .pose = {0, start, 0}, .velocity = {0, 0.3, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = block, .angle_a = std::acos(-1.0) / 2});
  m.add("spring", SpringDamper{.body_a = ground, .body_b = block, .stiffness = k, .free_length = free, .damping = c});
  Machine machine(m, options());
  machine.start_from_pose();
  const double rest = -free - mass * g / k;
  const Oscillator exact{k / mass, c / (2 * mass), start - rest, 0.3};
  subsoil::test::Worst worst;
  for (int i = 1; i <= 2000; ++i) {
    machine.advance(1e-3);
    worst.take("t = " + std::to_string(machine.time()).substr(0, 5) + " s", machine.body(block).r.y - rest,
               exact.at(machine.time()));
  }
  const subsoil::test::Verified row("Machines", "Translational spring-damper",
                                    "closed form; acceptance case of Yuan & Yu 2020");
  worst.near(row, std::string("place off rest within 2 s, ") + solver(), "m", subsoil::test::absolute(1e-8),
             "(w h)^4 = 2e-7 a radian, times 0.35: 1e-9 of the amplitude");
  const double v = machine.body(block).v.y, length = -machine.body(block).r.y;
  EXPECT_NEAR(machine.force_value("spring", "force"), k * (free - length) - c * -v, 1e-9 * k);  // compression positive
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7);
  EXPECT_GT(machine.energy().lost, 0.1);
}

// A bar swinging about a pin against a torsion spring and damper, no gravity: linear at any angle.
TEST_P(Closed, RotationalSwing) {
  constexpr double mass = 3, inertia = 0.2, arm = 0.4, k = 250, c = 1.5, preload = 12, start = 0.9;
  Model m;
  m.gravity = {0, 0};
  const int bar = m.add(
      {.name = "bar", .mass = mass, .inertia = inertia, .pose = {arm * std::cos(start), arm * std::sin(start), start}});
  m.add("pin", Revolute{.body_a = ground, .body_b = bar, .p_b = {-arm, 0}});
  m.add("spring",
        RotationalSpringDamper{
            .body_a = ground, .body_b = bar, .stiffness = k, .free_angle = 0.1, .preload = preload, .damping = c});
  Machine machine(m, options());
  machine.start_from_pose();
  const double about_pin = inertia + mass * arm * arm, rest = 0.1 + preload / k;
  const Oscillator exact{k / about_pin, c / (2 * about_pin), start - rest, 0};
  subsoil::test::Worst worst;
  for (int i = 1; i <= 2000; ++i) {
    machine.advance(1e-3);
    worst.take("t = " + std::to_string(machine.time()).substr(0, 5) + " s", machine.body(bar).angle - rest,
               exact.at(machine.time()));
  }
  const subsoil::test::Verified row("Machines", "Rotational swing with spring and damper",
                                    "closed form; acceptance case of Yuan & Yu 2020");
  worst.near(row, std::string("angle off rest within 2 s, ") + solver(), "rad", subsoil::test::absolute(1e-7),
             "(w h)^4 a radian, over 40 radians");
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Both, Closed, testing::Values(IntegratorKind::adams_moulton, IntegratorKind::ida));

}  // namespace
}  // namespace subsoil::mbd::spring_damper_test
