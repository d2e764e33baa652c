// Laws over a relative measure with a peak that lies inside what would be one step of a method with its own step
// control.

#include "libmbd/integrators/profiles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "libmbd/elements.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::profiles_test {
namespace {

constexpr double mass = 2;

class Profiles : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const { return {.integrator = GetParam()}; }
};
INSTANTIATE_TEST_SUITE_P(All, Profiles, testing::Values(IntegratorKind::cvode, IntegratorKind::ida));

/// Simpson's rule on many pieces.
double integral(const std::function<double(double)>& f, double from, double to) {
  constexpr int pieces = 20000;
  const double h = (to - from) / pieces;
  double sum = 0;
  for (int i = 0; i < pieces; ++i)
    sum += h / 6 * (f(from + i * h) + 4 * f(from + (i + 0.5) * h) + f(from + (i + 1) * h));
  return sum;
}

Model block_on_a_slide(double speed) {
  Model m;
  const int block = m.add({.name = "block", .mass = mass, .inertia = 1, .pose = {1, 0, 0}, .velocity = {speed, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = block});
  return m;
}

/// A push of 3 N on a block that moves the other way, and a damper that does nothing but at about 0.5 m/s.
TEST_P(Profiles, ANarrowPeakOfADamperHoldsTheBlock) {
  for (const double v0 : {1.3, 1.6, 2.0, 2.5}) {
    Model m = block_on_a_slide(-v0);
    std::vector<double> speeds, forces;
    for (int i = -100; i <= 100; ++i) speeds.push_back(0.02 * i), forces.push_back(i == 25 ? 100 : 0);
    m.add("push", AppliedForce{.body = 1, .fx = ConstantFunction{3}});
    // In the way from x = -10 its shortening is that of the block in -x.
    m.add("damper", SpringDamper{.body_a = ground,
                                 .body_b = 1,
                                 .p_a = {-10, 0},
                                 .stiffness = 0,
                                 .damper_curve = TableCharacteristic(speeds, forces)});
    Machine machine(m, options());
    machine.start_from_pose();
    while (machine.time() < 3) machine.advance(0.1);
    EXPECT_NEAR(machine.body(1).v.x, -0.53, 0.01) << v0 << ": at the near side of the peak";
    EXPECT_NEAR(machine.force_value("damper", "force"), -3, 1e-5) << v0;
  }
}

/// A block passes a hill of 20 mm in a spring's curve and needs the integral of dx/(v0^2 - 2 U/m)^(1/2).
TEST_P(Profiles, AHillOfASpringDelaysTheBlock) {
  std::vector<double> d, force;
  for (int i = -400; i <= 400; ++i) {
    d.push_back(5e-3 * i);
    force.push_back(i == 100 ? 300 : i == 102 ? -300 : 0);
  }
  const TableCharacteristic curve(d, force);
  for (const double v0 : {3.0, 6.0}) {
    Model m = block_on_a_slide(-v0);
    m.add("spring", SpringDamper{.body_a = ground, .body_b = 1, .p_a = {-5, 0}, .stiffness = 0, .spring_curve = curve});
    Machine machine(m, options());
    machine.start_from_pose();
    double t = 0;
    while (machine.body(1).r.x > 0) machine.advance(0.05);
    t = machine.time();
    const double way = 1 - machine.body(1).r.x;
    const Characteristic law(curve);
    const double due = integral([&](double x) { return 1 / std::sqrt(v0 * v0 - 2 * law.integral(x) / mass); }, 0, way);
    EXPECT_NEAR(t, due, 1e-6 * due) << v0;
    EXPECT_GT(due, (1 + 1e-4) * way / v0) << "the hill matters";
  }
}

}  // namespace
}  // namespace subsoil::mbd::profiles_test
