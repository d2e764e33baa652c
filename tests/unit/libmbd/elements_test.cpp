// Properties that every joint, driver and force of the lists must have; a new entry is tested by being there.

#include "libmbd/elements.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <random>
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
  double number() { return 0.3 + 0.13 * ++next; }  // growing: the second of a pair of limits is the larger
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
  template <class E>
  void choice(const char*, E&, std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>, const char*) {}
  void function(const char*, Function& f, const char*, const char*) {
    f = HarmonicFunction{.mean = number(), .amplitude = number(), .frequency = 0.4};
  }
  void optional_function(const char* k, Function& f, const char* unit, const char* m) {
    if (std::string(k) != "position") function(k, f, unit, m);  // which a velocity excludes
  }
  void optional_characteristic(const char*, Characteristic& c, const char*, const char*, const char*) {
    c = PolynomialCharacteristic{{.c = {0, number(), -number(), number()}}};
  }
};

template <class Element>
Element filled(Filler& filler) {
  Element e;
  e.describe(filler);
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

/// The ground and two bodies on random accelerated paths.
struct Paths {
  std::array<std::array<std::array<double, 3>, 3>, 2> c{};
  explicit Paths(std::mt19937& random) {
    std::uniform_real_distribution<double> number(-1, 1);
    for (auto& body : c)
      for (auto& coordinate : body)
        for (auto& coefficient : coordinate) coefficient = number(random);
  }
  std::array<BodyState, 3> at(double t) const {
    std::array<BodyState, 3> out;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto value = [&](std::size_t k) { return c[i][k][0] + t * (c[i][k][1] + t * c[i][k][2] / 2); };
      const auto rate = [&](std::size_t k) { return c[i][k][1] + t * c[i][k][2]; };
      out[i + 1] = {{value(0), value(1)}, value(2), {rate(0), rate(1)}, rate(2)};
    }
    return out;
  }
};

struct Seen {
  std::array<std::array<double, 3>, 3> wrench{};
  ForcePower power;
};
template <class Force>
Seen act(const Force& force, const std::array<BodyState, 3>& bodies, double t) {
  static const std::vector<Rut> ruts(1);
  Seen seen;
  Loads loads(seen.wrench);
  ForceValues values{};
  seen.power = force.evaluate({bodies, t, ruts}, loads, values);
  return seen;
}

// Every force: power on the bodies = work - lost - d(stored)/dt along any motion. Central differences of step 1e-5 err
// by h^2 = 1e-10 times third derivatives of order 10, and by rounding 1e-11; a contact that opens or closes within the
// step is as smooth as depth^2.5, h^1.5 = 3e-8.
TEST(Elements, ForcesKeepTheirEnergyAccount) {
  for_each_type<Forces>([](auto type) {
    Filler filler;
    const auto force = filled<decltype(type)>(filler);
    SCOPED_TRACE(filler.word);
    if constexpr (requires { force.check(); }) force.check();
    std::mt19937 random(7);
    int acting = 0;
    for (int state = 0; state < 300; ++state) {
      constexpr double h = 1e-5, t = 0.7;
      const Paths paths(random);
      const auto bodies = paths.at(t);
      const Seen now = act(force, bodies, t);
      double power = 0;
      for (std::size_t i = 1; i < 3; ++i)
        power +=
            now.wrench[i][0] * bodies[i].v.x + now.wrench[i][1] * bodies[i].v.y + now.wrench[i][2] * bodies[i].spin;
      const double stored_rate =
          (act(force, paths.at(t + h), t + h).power.stored - act(force, paths.at(t - h), t - h).power.stored) / (2 * h);
      ASSERT_NEAR(power, now.power.work - now.power.lost - stored_rate, 1e-6 * (1 + std::abs(power)))
          << "state " << state;
      if constexpr (requires { force.gap({}); }) {
        EXPECT_EQ(force.gap({bodies, t, {}}) < 0, now.power.stored > 0) << "gap is below 0 just where it acts";
        EXPECT_GE(now.power.lost, 0);
      }
      acting += power != 0 ? 1 : 0;
    }
    EXPECT_GT(acting, 50) << "the test saw little of the force";
  });
}

// Forces between two bodies neither push nor turn the pair, about whatever point.
TEST(Elements, ForcesBetweenBodiesKeepMomentum) {
  for_each_type<Forces>([](auto type) {
    Filler filler;
    const auto force = filled<decltype(type)>(filler);
    if constexpr (requires { force.body_a; }) {
      SCOPED_TRACE(filler.word);
      std::mt19937 random(11);
      double size = 0;
      for (int state = 0; state < 100; ++state) {
        const auto bodies = Paths(random).at(0.1);
        const auto w = act(force, bodies, 0.1).wrench;
        const double rounding = 1e-14 * (1 + std::abs(w[1][0]) + std::abs(w[1][1]) + std::abs(w[1][2]));
        EXPECT_NEAR(w[1][0] + w[2][0], 0, rounding);
        EXPECT_NEAR(w[1][1] + w[2][1], 0, rounding);
        double moment = 0;
        for (std::size_t i = 1; i < 3; ++i) moment += w[i][2] + cross(bodies[i].r, {w[i][0], w[i][1]});
        EXPECT_NEAR(moment, 0, 10 * rounding);
        size += std::abs(w[1][0]) + std::abs(w[1][2]);
      }
      EXPECT_GT(size, 1) << "the test saw little of the force";
    }
  });
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
