// The slider-crank of the SUNDIALS IDA example set (idaSlCrank_dns): a crank of length a about the origin, a connecting
// rod of length 1 to a slider on y = 0, a spring-damper between the middles of crank and rod, and a constant force F
// along x on a point of the rod one length beyond the slider. The rod's mass is at the slider, so its inertia there is
// J2.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::slider_crank_test {
namespace {

constexpr double a = 0.5, j1 = 1, m2 = 1, j2 = 2, k = 1, c = 1, l0 = 1, force = 1;

Model slider_crank(double q) {
  const double p = std::asin(-a * std::sin(q)), x = a * std::cos(q) + std::cos(p);
  Model m;
  m.gravity = {0, 0};
  const int crank = m.add({.name = "crank", .mass = 1, .inertia = j1, .pose = {0, 0, q}});
  // The rod's mass m2 is split between rod and slider: their centres coincide and the sum is what moves.
  const int rod = m.add({.name = "rod", .mass = m2 / 2, .inertia = j2, .pose = {x, 0, p}});
  const int slider = m.add({.name = "slider", .mass = m2 / 2, .inertia = 1, .pose = {x, 0, 0}});
  m.add("main pin", Revolute{.body_a = ground, .body_b = crank});
  m.add("crank pin", Revolute{.body_a = crank, .body_b = rod, .p_a = {a, 0}, .p_b = {-1, 0}});
  m.add("slider pin", Revolute{.body_a = rod, .body_b = slider});
  m.add("slide", Translational{.body_a = ground, .body_b = slider});
  m.add("spring", SpringDamper{.body_a = crank,
                               .body_b = rod,
                               .p_a = {a / 2, 0},
                               .p_b = {-0.5, 0},
                               .stiffness = k,
                               .free_length = l0,
                               .damping = c});
  m.add("push", AppliedForce{.body = rod, .point = {1, 0}, .fx = force});
  return m;
}

/// Minimal coordinate q: (I q')' - I_q q'^2/2 = Q.
void minimal(const test::OdeState& y, test::OdeState& d) {
  const double q = y[0], w = y[1], s = std::sin(q), co = std::cos(q);
  const double sp = -a * s, cp = std::sqrt(1 - sp * sp), p_q = -a * co / cp, p_qq = (a * s + sp * p_q * p_q) / cp;
  const double x = a * co + cp, x_q = -a * s - sp * p_q, x_qq = -a * co - cp * p_q * p_q - sp * p_qq;
  const double i = j1 + m2 * x_q * x_q + j2 * p_q * p_q, i_q = 2 * (m2 * x_q * x_qq + j2 * p_q * p_qq);
  // Spring between (a/2)(cos q, sin q) and (x - cos p/2, -sin p/2).
  const double dx = x - cp / 2 - a / 2 * co, dy = -sp / 2 - a / 2 * s;
  const double dx_q = x_q + sp * p_q / 2 + a / 2 * s, dy_q = -cp * p_q / 2 - a / 2 * co;
  const double l = std::hypot(dx, dy), l_q = (dx * dx_q + dy * dy_q) / l;
  const double tension = k * (l - l0) + c * l_q * w;
  const double general = -tension * l_q + force * (x_q - sp * p_q);
  d = {w, (general - i_q * w * w / 2) / i};
}

struct Published {
  double t, q, x, p;
};
// Printed by the example at rtol = atol = 1e-6 (libsundials-doc, idaSlCrank_dns.out), five digits.
constexpr std::array<Published, 5> published{{{2.0, 5.7904e-01, 1.3803e+00, -2.7715e-01},
                                              {4.0, -1.2064e+00, 1.0623e+00, 4.8609e-01},
                                              {6.0, -1.1080e+00, 1.1176e+00, 4.6386e-01},
                                              {8.0, 6.4422e-01, 1.3536e+00, -3.0500e-01},
                                              {10.0, 1.2757e+00, 1.0236e+00, -4.9881e-01}}};

class SliderCrank : public testing::TestWithParam<IntegratorKind> {};

// The example's own error at its tolerance is a few 1e-5 (its printed values differ from a tight solution by that); a
// wrong sign or factor anywhere moves the result by more than 1e-2.
TEST_P(SliderCrank, GivesTheDocumentedOutputsOfSundials) {
  Machine machine(slider_crank(std::numbers::pi / 2), {.integrator = GetParam()});
  machine.start_from_pose();
  for (const auto& row : published) {
    while (machine.time() < row.t - 1e-9) machine.advance(0.005);
    EXPECT_NEAR(machine.body(1).angle, row.q, 1e-4) << "t = " << row.t;
    EXPECT_NEAR(machine.body(3).r.x, row.x, 1e-4) << "t = " << row.t;
    EXPECT_NEAR(machine.body(2).angle, row.p, 1e-4) << "t = " << row.t;
  }
}

TEST_P(SliderCrank, FollowsMinimalCoordinate) {
  Machine machine(slider_crank(std::numbers::pi / 2),
                  {.integrator = GetParam(), .adams_moulton = {.order = 5}, .ida = {.rtol = 1e-11, .atol = 1e-11}});
  machine.start_from_pose();
  for (int i = 0; i < 5000; ++i) machine.advance(2e-3);
  const auto y =
      test::solve_ode([](const auto& s, auto& d, double) { minimal(s, d); }, {std::numbers::pi / 2, 0}, 0, 10);
  EXPECT_NEAR(machine.body(1).angle, y[0], 1e-8);
  EXPECT_NEAR(machine.body(1).omega, y[1], 1e-8);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Both, SliderCrank, testing::Values(IntegratorKind::adams_moulton, IntegratorKind::ida));

}  // namespace
}  // namespace subsoil::mbd::slider_crank_test
