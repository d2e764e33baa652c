// Controllers beside the PID: formulas, transfer functions and tables of measures against closed forms.

#include "libmbd/controllers.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/equilibrium/equilibrium.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "libmbd/measures/control_input.hpp"
#include "libmbd/measures/force.hpp"
#include "libmbd/measures/position.hpp"
#include "libmbd/measures/velocity.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::controllers_test {
namespace {

MachineOptions options(IntegratorKind kind) {
  return {.integrator = kind, .ida = {.rtol = 1e-9, .atol = 1e-10}, .cvode = {.rtol = 1e-10, .atol = 1e-11}};
}

class ControllersOf : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(All, ControllersOf,
                         testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida));

constexpr double mass = 2;

/// A block on a rail along x, without gravity.
Model on_rail(double x, double v) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "block", .mass = mass, .inertia = 1, .pose = {x, 0, 0}, .velocity = {v, 0, 0}});
  m.add("rail", Translational{.body_a = ground, .body_b = 1});
  return m;
}
std::shared_ptr<ControllerInput> place() {
  return input_of(PositionMeasure{.of = {.name = "block", .body = 1}, .part = VectorPart::x});
}
std::shared_ptr<ControllerInput> speed() {
  return input_of(VelocityMeasure{.of = {.name = "block", .body = 1}, .part = VectorPart::x});
}
double output(const Machine& machine) { return machine.system().signals()[0]; }

// -k x - c v by a formula is a damped oscillator; its work is what the spring stores and the damper loses.
TEST_P(ControllersOf, AFormulaOfPlaceAndSpeedIsASpringAndDamper) {
  constexpr double k = 50, c = 3, t = 1.2;
  Model m = on_rail(0.1, 0.4);
  m.add("law", FormulaController{.text = "-50*x - 3*v",
                                 .output_unit = "N",
                                 .value = [](const double* y) { return -k * y[0] - c * y[1]; },
                                 .inputs = {place(), speed()}});
  m.add("push", AppliedForce{.body = 1, .controller = "law"});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  for (int i = 0; i < 1200; ++i) machine.advance(t / 1200);
  const double half = c / (2 * mass), w = std::sqrt(k / mass - half * half), b = (0.4 + half * 0.1) / w;
  const double e = std::exp(-half * t), x = e * (0.1 * std::cos(w * t) + b * std::sin(w * t));
  EXPECT_NEAR(machine.body(1).r.x, x, 1e-8);
  EXPECT_NEAR(output(machine), -k * x - c * machine.body(1).v.x, 1e-6);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7 * machine.energy().moved);
}

// A driven place A sin(w t) through 1/(T s + 1): A/(1 + w^2 T^2) (sin(w t) - w T cos(w t) + w T exp(-t/T)).
TEST_P(ControllersOf, ALagOfASine) {
  constexpr double amplitude = 0.3, w = 7, lag = 0.2, t = 1;
  Model m = on_rail(0, amplitude * w);
  m.add("motion", CoordinateDriver{.body = 1,
                                   .coordinate = Coordinate::x,
                                   .motion = {.position = HarmonicFunction{.amplitude = amplitude,
                                                                           .frequency = w / (2 * std::acos(-1.0))}}});
  m.add("lag", TransferFunction{.output_unit = "m", .numerator = {1}, .denominator = {lag, 1}, .input = place()});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  for (int i = 0; i < 1000; ++i) machine.advance(t / 1000);
  const double wt = w * lag,
               exact = amplitude / (1 + wt * wt) * (std::sin(w * t) - wt * std::cos(w * t) + wt * std::exp(-t / lag));
  EXPECT_NEAR(output(machine), exact, 1e-8);
}

// (b_2 s^2 + b_1 s + b_0)/(s^2 + 2 d s + w^2) of a constant: b_0/w^2 from the start on, since it starts at rest; of a
// ramp r t it follows with b_0 r t/w^2 + r (b_1 w^2 - 2 d b_0)/w^4 once its own motion, exp(-d t), has died away.
TEST_P(ControllersOf, ATransferFunctionOfSecondOrder) {
  constexpr double w = 20, d = 8, ramp = 0.05, t = 4;
  const TransferFunction law{
      .output_unit = "N", .numerator = {2, 3, 5}, .denominator = {1, 2 * d, w * w}, .input = place()};
  Model still = on_rail(0.3, 0);
  still.add("law", law);
  Machine at_rest(still, options(GetParam()));
  at_rest.start_from_pose();
  EXPECT_NEAR(output(at_rest), 5 * 0.3 / (w * w), 1e-14);
  at_rest.advance(0.1);
  EXPECT_NEAR(output(at_rest), 5 * 0.3 / (w * w), 1e-12);

  Model moving = on_rail(0, ramp);
  moving.add("law", law);
  Machine machine(moving, options(GetParam()));
  machine.start_from_pose();
  for (int i = 0; i < 2000; ++i) machine.advance(t / 2000);
  EXPECT_NEAR(output(machine), 5 * ramp * t / (w * w) + ramp * (3 * w * w - 2 * d * 5) / std::pow(w, 4), 1e-9);
}

// An integral in the transfer function holds a set point as a PI does: the steady state has no error.
TEST(TransferFunctionOf, AnIntegralFindsItsSteadyState) {
  Model m = on_rail(0.1, 0);
  m.gravity = {5, 0};
  m.add("spring", SpringDamper{.body_a = ground, .body_b = 1, .p_a = {-1, 0}, .stiffness = 100, .damping = 20});
  m.add("law", TransferFunction{.output_unit = "N", .numerator = {-30, -40}, .denominator = {1, 0}, .input = place()});
  m.add("push", AppliedForce{.body = 1, .controller = "law"});
  Machine machine(m);
  machine.start_from_towing_equilibrium(0);
  EXPECT_NEAR(machine.body(1).r.x, 0, 1e-10);
  EXPECT_NEAR(output(machine), 100 * (1.0 - 1.1) - 5 * mass, 1e-8);
}

TEST(TableOfTwoOf, IsBilinearAndConstantBeyond) {
  TableOfTwo table{.first = {0, 1, 3}, .second = {-1, 1}, .values = {0, 2, 4, 6, 10, 20}, .inputs = {place(), speed()}};
  table.check();
  const auto at = [&](double a, double b) {
    const double y[] = {a, b};
    return table.output(0, y, nullptr);
  };
  EXPECT_DOUBLE_EQ(at(0, -1), 0);
  EXPECT_DOUBLE_EQ(at(3, 1), 20);
  EXPECT_DOUBLE_EQ(at(0.5, 0), (0 + 2 + 4 + 6) / 4.0);
  EXPECT_DOUBLE_EQ(at(2, -1), 7);
  EXPECT_DOUBLE_EQ(at(2, 0), (4 + 6 + 10 + 20) / 4.0);
  EXPECT_DOUBLE_EQ(at(-9, 0), 1);
  EXPECT_DOUBLE_EQ(at(9, 9), 20);
}

std::string refusal_of(const AnyController& c) {
  Model m = on_rail(0, 0);
  m.add("law", c);
  return test::message_of<std::invalid_argument>([&] { const System system(m); });
}

TEST(Controllers, RefuseWithRuleAndCure) {
  EXPECT_EQ(refusal_of(TransferFunction{.numerator = {1, 0}, .denominator = {1}, .input = place()}),
            "controller 'law': the numerator has a higher power of s than the denominator: that is a derivative; add a "
            "lag below");
  EXPECT_EQ(refusal_of(TransferFunction{.numerator = {1}, .denominator = {0, 1}, .input = place()}),
            "controller 'law': the denominator's first coefficient must not be 0");
  EXPECT_EQ(
      refusal_of(TableOfTwo{.first = {0, 1}, .second = {0, 1}, .values = {1, 2, 3}, .inputs = {place(), speed()}}),
      "controller 'law': table of two: 2 by 2 places need 4 values, there are 3");
  EXPECT_EQ(
      refusal_of(TableOfTwo{.first = {0, 0}, .second = {0, 1}, .values = {1, 2, 3, 4}, .inputs = {place(), speed()}}),
      "controller 'law': table of two: both measures need two places or more, increasing");
}

// A formula of a force would be a function of itself; a transfer function with more poles than zeros is not.
TEST(Controllers, OfForcesNeedALag) {
  const auto refused = [](const AnyController& c) {
    Model m = on_rail(0, 0);
    m.add("spring", SpringDamper{.body_a = ground, .body_b = 1, .p_a = {-1, 0}, .stiffness = 100});
    m.add("law", c);
    return test::message_of<std::invalid_argument>([&] { const System system(m); });
  };
  const auto force = [] {
    ForceMeasure m;
    m.element = "spring", m.part = WrenchPart::x;
    return input_of(m);
  };
  const FormulaController formula{.value = [](const double* y) { return *y; }, .inputs = {force()}};
  EXPECT_NE(refused(formula).find("its own output changes at once"), std::string::npos) << refused(formula);
  EXPECT_EQ(refused(TransferFunction{.numerator = {1}, .denominator = {0.1, 1}, .input = force()}), "accepted");
}

}  // namespace
}  // namespace subsoil::mbd::controllers_test
