// Properties that every joint, driver and force of the lists must have; a new entry is tested by being there.

#include "libmbd/elements.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>

namespace subsoil::mbd {
namespace {

template <class Tuple, class Action>
void for_each_type(Action action) {
  [&]<std::size_t... i>(std::index_sequence<i...>) { (action(std::tuple_element_t<i, Tuple>{}), ...); }
  (std::make_index_sequence<std::tuple_size_v<Tuple>>{});
}

/// Fills an element with unremarkable numbers through its own declaration, and notes what it declares.
struct Filler {
  std::string word, first_key;
  int next = 0;
  double number() { return 0.3 + 0.17 * (++next % 7); }
  void key(const char* k) {
    if (first_key.empty()) first_key = k;
  }
  void card(const char* w, const char* meaning) {
    word = w;
    EXPECT_GT(std::string(meaning).size(), 10U);
  }
  void bodies(const char* k, int& a, int& b, const char*) { key(k), a = 1, b = 2; }
  void body(const char* k, int& b, const char*) { key(k), b = 2; }
  void coordinate(const char* k, int& b, Coordinate& c, const char*) { key(k), b = 2, c = Coordinate::y; }
  void joint_point(int, std::array<double, 2>& a, int, std::array<double, 2>& b, const char*) {
    a = {number(), -number()}, b = {-number(), number()};
  }
  void end_points(int a, std::array<double, 2>& pa, int b, std::array<double, 2>& pb, const char* m) {
    joint_point(a, pa, b, pb, m);
  }
  void point(const char*, int, std::array<double, 2>& p, const char*) { p = {number(), number()}; }
  void axis(const char*, int, double& angle, const char*) { angle = number(); }
  void quantity(const char*, double& value, const char*, const char*, const char*) {
    if (std::isnan(value) || value == 0) value = number();
  }
  void optional_quantity(const char*, double& value, const char*, const char*, const char*) { value = number(); }
  void text(const char*, std::string&, const char*) {}
  void joint(const char* k, std::string& name, const char*) { key(k), name = "pin"; }
  template <class E>
  void choice(const char*, E&, std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>, const char*) {}
  void function(const char*, Function& f, const char*, const char*) {
    f = HarmonicFunction{.mean = number(), .amplitude = number(), .frequency = 0.4};
  }
  void optional_function(const char* k, Function& f, const char* unit, const char* m) {
    if (std::string(k) == "velocity") function(k, f, unit, m);
  }
};

template <class Element>
Element filled(Filler& filler) {
  Element e;
  e.describe(filler);
  if constexpr (requires { e.attach(Revolute{}, 1); }) e.attach(Revolute{.body_a = 1, .body_b = 2}, 1);
  return e;
}

/// Two bodies on given accelerated paths.
BodyState moving(int which, double t) {
  const double p[2][3][3] = {{{0.2, 0.5, 0.8}, {-0.3, 0.9, -1.1}, {0.4, 1.2, 0.7}},
                             {{1.6, -0.4, 0.3}, {0.9, 0.2, 0.6}, {-0.7, 0.8, -1.3}}};
  const auto& c = p[which];
  const auto at = [&](int k) { return c[k][0] + t * (c[k][1] + t * c[k][2] / 2); };
  const auto rate = [&](int k) { return c[k][1] + t * c[k][2]; };
  return {{at(0), at(1)}, at(2), {rate(0), rate(1)}, rate(2)};
}
constexpr double acceleration[2][3] = {{0.8, -1.1, 0.7}, {0.3, 0.6, -1.3}};

BodyState shifted(BodyState b, int k, double by) {
  return {{b.r.x + (k == 0 ? by : 0), b.r.y + (k == 1 ? by : 0)}, b.angle + (k == 2 ? by : 0), b.v, b.spin};
}

template <class Constraint>
void check_constraint(const Constraint& c) {
  constexpr double t = 0.3, h = 1e-4;
  const BodyState a = moving(0, t), b = moving(1, t);
  Rows<Constraint::rows> now, plus, minus;
  c.evaluate(a, b, t, now);
  for (std::size_t i = 0; i < Constraint::rows; ++i) {
    // Columns of Phi_q by central differences: exact to h^2 = 1e-8.
    for (int k = 0; k < 3; ++k) {
      c.evaluate(shifted(a, k, h), b, t, plus), c.evaluate(shifted(a, k, -h), b, t, minus);
      EXPECT_NEAR(now[i].on_a[static_cast<std::size_t>(k)], (plus[i].phi - minus[i].phi) / (2 * h), 1e-7)
          << "row " << i << ", coordinate " << k << " of a";
      c.evaluate(a, shifted(b, k, h), t, plus), c.evaluate(a, shifted(b, k, -h), t, minus);
      EXPECT_NEAR(now[i].on_b[static_cast<std::size_t>(k)], (plus[i].phi - minus[i].phi) / (2 * h), 1e-7)
          << "row " << i << ", coordinate " << k << " of b";
    }
    c.evaluate(a, b, t + h, plus), c.evaluate(a, b, t - h, minus);
    EXPECT_NEAR(now[i].phi_t, (plus[i].phi - minus[i].phi) / (2 * h), 1e-6);
    // Along the paths d2Phi/dt2 = Phi_q q'' - gamma; second differences: h^2 = 1e-8 and rounding 1e-8.
    c.evaluate(moving(0, t + h), moving(1, t + h), t + h, plus),
        c.evaluate(moving(0, t - h), moving(1, t - h), t - h, minus);
    double right = -now[i].gamma;
    for (std::size_t k = 0; k < 3; ++k)
      right += now[i].on_a[k] * acceleration[0][k] + now[i].on_b[k] * acceleration[1][k];
    EXPECT_NEAR((plus[i].phi - 2 * now[i].phi + minus[i].phi) / (h * h), right, 1e-5) << "row " << i;
  }
}

TEST(Elements, JointsHaveTheirOwnDerivatives) {
  for_each_type<Joints>([](auto type) {
    Filler filler;
    auto joint = filled<decltype(type)>(filler);
    SCOPED_TRACE(filler.word);
    if constexpr (requires { joint.relative_angle; }) joint.relative_angle = 0.2;
    check_constraint(joint);
  });
}

TEST(Elements, DriversHaveTheirOwnDerivatives) {
  for_each_type<Drivers>([](auto type) {
    Filler filler;
    auto driver = filled<decltype(type)>(filler);
    SCOPED_TRACE(filler.word);
    driver.check();
    driver.settle_start(moving(0, 0), moving(1, 0), 0);
    Rows<1> at_start;
    driver.evaluate(moving(0, 0), moving(1, 0), 0, at_start);
    EXPECT_NEAR(at_start[0].phi, 0, 1e-15);  // a velocity starts from the pose
    check_constraint(driver);
  });
}

constexpr std::array<double, 3> lambda{5, 30, -40};  // of the equations of a joint with friction, from its row 1 on

struct Seen {
  std::array<std::array<double, 3>, 3> wrench{};
  ForcePower power;
};
template <class Force>
Seen act(const Force& force, double t, const std::vector<Rut>& ruts) {
  Seen seen;
  BodyState wheel = moving(1, t);
  wheel.r.y -= 0.5;  // deep enough for a wheel
  const std::array<BodyState, 3> bodies{BodyState{}, moving(0, t), wheel};
  Loads loads(seen.wrench);
  ForceValues values{};
  seen.power = force.evaluate({bodies, t, ruts, lambda}, loads, values);
  return seen;
}

// Every force: power on the bodies = work - lost - d(stored)/dt along any motion.
TEST(Elements, ForcesKeepTheirEnergyAccount) {
  const std::vector<Rut> ruts(1);
  for_each_type<Forces>([&](auto type) {
    Filler filler;
    const auto force = filled<decltype(type)>(filler);
    SCOPED_TRACE(filler.word);
    for (const double t : {0.05, 0.2, 0.31}) {
      constexpr double h = 1e-5;
      const Seen now = act(force, t, ruts);
      double power = 0;
      for (std::size_t i = 1; i < 3; ++i) {
        const BodyState b = moving(static_cast<int>(i) - 1, t);
        power += now.wrench[i][0] * b.v.x + now.wrench[i][1] * b.v.y + now.wrench[i][2] * b.spin;
      }
      const double stored_rate =
          (act(force, t + h, ruts).power.stored - act(force, t - h, ruts).power.stored) / (2 * h);
      EXPECT_NEAR(power, now.power.work - now.power.lost - stored_rate, 1e-6 * (1 + std::abs(power))) << "t = " << t;
      EXPECT_NE(power, 0) << "the test saw no force";
    }
  });
}

// Forces between two bodies neither push nor turn the pair.
TEST(Elements, ForcesBetweenBodiesKeepMomentum) {
  for_each_type<Forces>([](auto type) {
    Filler filler;
    const auto force = filled<decltype(type)>(filler);
    if constexpr (requires { force.body_a; }) {
      SCOPED_TRACE(filler.word);
      std::array<std::array<double, 3>, 3> w{};
      const std::array<BodyState, 3> bodies{BodyState{}, moving(0, 0.1), moving(1, 0.1)};
      Loads loads(w);
      ForceValues values{};
      force.evaluate({bodies, 0.1, {}, lambda}, loads, values);
      EXPECT_NEAR(w[1][0] + w[2][0], 0, 1e-14);
      EXPECT_NEAR(w[1][1] + w[2][1], 0, 1e-14);
      double moment = 0;
      for (std::size_t i = 1; i < 3; ++i) moment += w[i][2] + cross(bodies[i].r, {w[i][0], w[i][1]});
      EXPECT_NEAR(moment, 0, 1e-14);
    }
  });
}

// Friction in a slide: the same two accounts as in a pin, which the list above covers.
TEST(Elements, FrictionInASlide) {
  JointFriction friction{.joint = "slide", .guide = 0.4, .mu_s = 0.3, .mu_k = 0.2, .viscous = 2};
  friction.attach(Translational{.body_a = 1, .body_b = 2, .p_b = {0.1, 0.2}, .angle_a = 0.3}, 1);
  const std::array<BodyState, 3> bodies{BodyState{}, moving(0, 0.1), moving(1, 0.1)};
  std::array<std::array<double, 3>, 3> w{};
  Loads loads(w);
  ForceValues values{};
  const ForcePower power = friction.evaluate({bodies, 0.1, {}, lambda}, loads, values);
  EXPECT_NEAR(values[3], 2 * 40 / 0.4, 1e-12);  // the moment outweighs the normal force
  EXPECT_NEAR(std::hypot(w[2][0], w[2][1]), std::abs(values[0]), 1e-12);
  EXPECT_GT(power.lost, 0);
  double on_bodies = 0, moment = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    on_bodies += w[i][0] * bodies[i].v.x + w[i][1] * bodies[i].v.y + w[i][2] * bodies[i].spin;
    moment += w[i][2] + cross(bodies[i].r, {w[i][0], w[i][1]});
  }
  EXPECT_NEAR(on_bodies, -power.lost, 1e-12);
  EXPECT_NEAR(w[1][0] + w[2][0], 0, 1e-14);
  EXPECT_NEAR(w[1][1] + w[2][1], 0, 1e-14);
  EXPECT_NEAR(moment, 0, 1e-12);
}

// The word that names an element in a scenario is also its first key.
TEST(Elements, FirstKeyIsTheTypesWord) {
  const auto check = [](auto type) {
    Filler filler;
    filled<decltype(type)>(filler);
    EXPECT_EQ(filler.first_key, filler.word);
  };
  for_each_type<Joints>(check);
  for_each_type<Drivers>(check);
  for_each_type<Forces>(check);
}

}  // namespace
}  // namespace subsoil::mbd
