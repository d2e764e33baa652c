// Pulses of functions of time that lie inside what would be one step of a method with its own step control.

#include "libmbd/integrators/inputs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "libmbd/elements.hpp"
#include "libmbd/integrators/adaptive.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::inputs_test {
namespace {

constexpr double mass = 2;

Model pushed(Function along_x) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "block", .mass = mass, .inertia = 1});
  m.add("push", AppliedForce{.body = 1, .fx = std::move(along_x)});
  return m;
}

ExpressionFunction formula(double (*value)(double)) {
  return {.text = "f",
          .unit = "N",
          .value_ = value,
          .first_ = value,
          .second_ = value,
          .integral_ = value,
          .double_integral_ = value};
}

struct Pulse {
  const char* name;
  Function force;
  double impulse;
  double fastest = 0;  // beside the pulse
};

class Inputs : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(All, Inputs, testing::Values(IntegratorKind::cvode, IntegratorKind::ida));

std::vector<Pulse> pulses() {
  const auto ramps = [](double rise, double hold) {
    return SumFunction{{RampFunction{.from = 0, .to = 100, .begin = 5, .end = 5 + rise},
                        RampFunction{.from = 0, .to = -100, .begin = 5 + rise + hold, .end = 5 + 2 * rise + hold}}};
  };
  return {{"ramps of 1 ms around 20 ms", ramps(1e-3, 20e-3), 100 * 21e-3},
          {"ramps of 10 us", ramps(1e-5, 0), 100 * 1e-5},
          {"half-sine of a step", formula([](double t) {
             const double s = t - 5;
             return s > 0 && s < 0.02 ? 100 * std::sin(std::numbers::pi * s / 0.02) : 0.0;
           }),
           100 * 2 * 0.02 / std::numbers::pi},
          {"parabola over a step",
           formula([](double t) { return std::max(0.0, 100 * 4 * (t - 5) * (5.02 - t) / (0.02 * 0.02)); }),
           100 * 2. / 3 * 0.02},
          {"half-sine of 2 ms", formula([](double t) {
             const double s = t - 5.2;
             return s > 0 && s < 2e-3 ? 100 * std::sin(std::numbers::pi * s / 2e-3) : 0.0;
           }),
           100 * 2 * 2e-3 / std::numbers::pi},
          {"smooth pulse", formula([](double t) { return 100 * std::exp(-std::pow((t - 5.31) / 2e-3, 2)); }),
           100 * std::sqrt(std::numbers::pi) * 2e-3},
          {"on top of a slow swing",
           SumFunction{{HarmonicFunction{.amplitude = 100, .frequency = 0.1}, ramps(1e-3, 2e-3)}}, 100 * 3e-3, 160}};
}

// The block has the speed impulse/mass afterwards, whatever the intervals asked for: to 1e-7, above what the
// default tolerances leave of a few steps at corners, and 1e-8 (rtol) of the largest speed.
TEST_P(Inputs, PulsesOnABlockAtRestGiveItTheirImpulse) {
  for (const Pulse& pulse : pulses())
    for (const double interval : {10.0, 1e-2}) {
      Machine machine(pushed(pulse.force), {.integrator = GetParam()});
      machine.start_from_pose();
      while (machine.time() < 10 - 1e-6) machine.advance(interval);
      EXPECT_NEAR(machine.body(1).v.x, pulse.impulse / mass, 1e-7 + 1e-8 * pulse.fastest)
          << pulse.name << ", every " << interval << " s";
    }
}

// Adams-Moulton halves its steps down to the pulse where it controls them, and errs by its own tolerance; steps that
// are given miss it, and the state says when. None of this where a step sees what the input does.
TEST(InputsOfAdamsMoulton, PulsesAreSeenOrSaidToBeMissed) {
  for (const Pulse& pulse : pulses()) {
    MachineOptions options{.integrator = IntegratorKind::adams_moulton};
    options.adams_moulton.longest_step = 0.02;
    options.adams_moulton.error_per_second = 1e-7;
    Machine controlled(pushed(pulse.force), options);
    controlled.start_from_pose();
    controlled.advance(10);
    EXPECT_NEAR(controlled.body(1).v.x, pulse.impulse / mass, 1e-5 * (1 + pulse.fastest)) << pulse.name;
    EXPECT_EQ(controlled.integrator().step_error().unseen, 0) << pulse.name;
    options.adams_moulton.error_per_second = std::numeric_limits<double>::infinity();
    Machine given(pushed(pulse.force), options);
    given.start_from_pose();
    given.advance(10);
    // Of the slow swing below one pulse, 6400 N s, the pulse is little.
    const double least = pulse.fastest > 0 ? 1e-4 : 0.25;
    EXPECT_GT(given.integrator().step_error().unseen, least) << pulse.name;
  }
  MachineOptions options{.integrator = IntegratorKind::adams_moulton};
  options.adams_moulton.longest_step = 0.02;
  Machine smooth(pushed(formula([](double t) { return 50 * std::sin(7 * t); })), options);
  smooth.start_from_pose();
  smooth.advance(10);
  EXPECT_LT(smooth.integrator().step_error().unseen, 1e-3);
}

// A driver whose acceleration jumps at the corners of its velocity, wherever they lie and however often, between
// samples and on them: the block goes the way under the lines, and a pendulum on it keeps the balance of energy, by
// 1e-5 of what moves.
TEST_P(Inputs, ADriverPassesCornersOfItsVelocity) {
  struct Case {
    double begin, rise, top;
    bool periodic;
  };
  for (const Case& c : {Case{0.5, 5e-3, 1, false}, Case{0.5, 2e-3, 1, false}, Case{0.2003, 2e-4, -1, false},
                        Case{0.2003, 1e-4, 0.5, false}, Case{0.5, 1e-4, 0.01, false}, Case{0, 1e-3, 0.5, true}}) {
    Model m;
    m.add({.name = "block", .mass = mass, .inertia = 1});
    m.add({.name = "bob", .mass = 1, .inertia = 0.1, .pose = {0, -0.5, 0}});
    m.add("guide", Translational{.body_a = 0, .body_b = 1});
    m.add("pin", Revolute{.body_a = 1, .body_b = 2, .p_b = {0, 0.5}});
    CoordinateDriver driver{.body = 1, .coordinate = Coordinate::x};
    driver.motion.velocity = TableFunction({c.begin, c.begin + c.rise, c.begin + 2 * c.rise}, {0, c.top, 0}, c.periodic,
                                           PiecewiseCubic::Between::linear);
    m.add("drive", driver);
    Machine machine(std::move(m), {.integrator = GetParam()});
    machine.start_from_pose();
    for (int row = 1; row <= 9; ++row) machine.advance_to(0.1 * row);
    const double way = c.periodic ? 0.9 * c.top / 2 : c.top * c.rise;
    EXPECT_NEAR(machine.body(1).r.x, way, 1e-9) << c.begin << " s, " << c.rise << " s";
    EXPECT_LT(std::abs(machine.energy().balance()), 1e-5 * machine.energy().moved + 1e-8)  // J: as tolerances are
        << c.begin << " s, " << c.rise << " s";
  }
}

// The current of a coil of 1 ms moves hardly anything at first, and steps of Adams-Moulton are made for it all the
// same: angle after a half-sine of voltage U over T, of k, R, J: U 2 T/pi/k' (1 - exp(-k'' t)) by an integration of
// its own, to 1e-7.
TEST(InputsOfAdamsMoulton, CurrentsAreHeldToTheirTolerance) {
  const auto angle = [](IntegratorKind kind) {
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "rotor", .mass = 2, .inertia = 0.01});
    m.add("pin", Revolute{.body_a = 0, .body_b = 1});
    ElectricMotor motor{.body_a = 0, .body_b = 1};
    motor.torque_constant = 0.1, motor.resistance = 1, motor.inductance = 1e-3;
    motor.voltage = formula([](double t) {
      const double s = (t - 0.133) / 0.002;
      return s > 0 && s < 1 ? 10 * std::sin(std::numbers::pi * s) : 0.0;
    });
    m.add("motor", motor);
    MachineOptions options{.integrator = kind};
    options.adams_moulton.longest_step = 1e-3, options.adams_moulton.error_per_second = 2e-6;
    Machine machine(std::move(m), options);
    machine.start_from_pose();
    for (int k = 1; k <= 500; ++k) machine.advance_to(1e-3 * k);
    return machine.body(1).angle;
  };
  EXPECT_NEAR(angle(IntegratorKind::adams_moulton), 0.0389682707, 1e-7);
  EXPECT_NEAR(angle(IntegratorKind::cvode), 0.0389682707, 1e-8);
}

// A swing that is no more than smooth costs no step beside those of the same motion without the bound.
TEST_P(Inputs, ASmoothSwingCostsNoStep) {
  Model m = pushed(formula([](double t) { return 50 * std::sin(7 * t); }));
  m.add("spring", SpringDamper{.body_a = 0, .body_b = 1, .p_a = {-1, 0}, .stiffness = 200, .damping = 1});
  Machine machine(std::move(m), {.integrator = GetParam()});
  machine.start_from_pose();
  machine.advance(10);
  const auto& method = dynamic_cast<const Adaptive&>(machine.integrator());
  EXPECT_LT(method.steps(), GetParam() == IntegratorKind::cvode ? 2000 : 20000);
}

/// Sets the function number `wanted` that an element describes to a fast swing, and counts them.
struct SwingOne {
  int wanted, functions = 0;

  template <class... A>
  void function(const char*, Function& f, A&&...) {
    if (functions++ == wanted) f = formula([](double t) { return std::sin(1e3 * t); });
  }
  template <class... A>
  void optional_function(const char* key, Function& f, A&&...) {
    function(key, f);
  }
  template <class T>
  void choice(const char*, T&, std::initializer_list<std::pair<const char*, T>>, const char*) {}

  template <class... A>
  void axis(A&&...) {}
  template <class... A>
  void bodies(A&&...) {}
  template <class... A>
  void body(A&&...) {}
  template <class... A>
  void card(A&&...) {}
  template <class... A>
  void coordinate(A&&...) {}
  template <class... A>
  void end_points(A&&...) {}
  template <class... A>
  void exponent(A&&...) {}
  template <class... A>
  void flag(A&&...) {}
  template <class... A>
  void form(A&&...) {}
  template <class... A>
  void joint(A&&...) {}
  template <class... A>
  void joint_point(A&&...) {}
  template <class... A>
  void optional_body(A&&...) {}
  template <class... A>
  void optional_characteristic(A&&...) {}
  template <class... A>
  void optional_quantity(A&&...) {}
  template <class... A>
  void outline(A&&...) {}
  template <class... A>
  void point(A&&...) {}
  template <class... A>
  void quantity(A&&...) {}
  template <class... A>
  void table(A&&...) {}
  template <class... A>
  void text(A&&...) {}
  template <class... A>
  void vector(A&&...) {}
};

/// Whether each function of time that elements of these types describe is among a machine's inputs. Returns how many.
template <class... Element>
int expect_inputs_of_all(std::tuple<Element...>*) {
  int all = 0;
  const auto expect_of = [&]<class E>(E*) {
    for (int wanted = 0;; ++wanted) {
      SwingOne swing{.wanted = wanted};
      E element;
      element.describe(swing);
      if (wanted >= swing.functions) break;
      ++all;
      Model m;
      m.add("element", element);
      EXPECT_TRUE(mbd::Inputs(m).any()) << typeid(E).name() << ", function " << wanted;
    }
  };
  (expect_of(static_cast<Element*>(nullptr)), ...);
  return all;
}

// Inputs names the members of elements that are functions of time: one that it forgets is stepped over in silence.
TEST(InputsOfElements, AllFunctionsOfTimeAreSeen) {
  EXPECT_GE(expect_inputs_of_all(static_cast<Forces*>(nullptr)), 10);
  EXPECT_EQ(expect_inputs_of_all(static_cast<Drivers*>(nullptr)), 12) << "position, velocity, acceleration of four";
}

}  // namespace
}  // namespace subsoil::mbd::inputs_test
