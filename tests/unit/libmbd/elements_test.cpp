// Properties that every joint, driver and force of the lists must have; a new entry is tested by being there.

#include "libmbd/elements.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <random>
#include <string>
#include <type_traits>
#include <utility>

#include "libmbd/base/slope.hpp"

namespace subsoil::mbd::elements_test {
namespace {

template <class Tuple, class Action>
void for_each_type(Action action) {
  [&]<std::size_t... i>(std::index_sequence<i...>) { (action(std::tuple_element_t<i, Tuple>{}), ...); }
  (std::make_index_sequence<std::tuple_size_v<Tuple>>{});
}

/// Fills an element with unremarkable numbers through its own declaration, and notes what it declares.
struct Filler {
  std::string motion = "velocity";  // which of its functions a driver gets
  bool flags = false;
  std::string word{}, first_key{};
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
  void quantity(const char* k, double& value, const char*, const char*, const char*) {
    if (std::isnan(value) || value == 0) value = number();
    if (std::string(k) == "mu_k") value = 0.1;  // at most mu_s
    if (std::string(k) == "length") value = 0;  // beside a radius
    if (std::string(k) == "rod") value = 0.1;   // thinner than the bore
    if (std::string(k) == "tank pressure") value = 0.1;
    if (std::string(k) == "bulk modulus") value = 3;
    if (std::string(k) == "rated drop") value = 2;
    if (std::string(k) == "stop stiffness") value = 50;
  }
  void exponent(const char*, double& value, const char*, const char*) {
    value = 1 + number();
  }  // contacts ask for 1 or more
  void optional_quantity(const char* k, double& value, const char*, const char*, const char*) {
    const std::string name = k;
    if (name == "stick stiffness" && word.ends_with("contact")) return;  // as many states as places: contacts_test
    value = name == "restitution" ? 0.5 : number();
  }
  void text(const char*, std::string&, const char*) {}
  void optional_body(const char*, int& b, const char*) { b = 3; }
  void vector(const char*, std::array<double, 2>& value, const char*, const char*) { value = {number(), -number()}; }
  void flag(const char*, bool& value, const char*) { value = flags; }
  /// Convex and closed where it is a cam's profile: a circle of 0.5 m pushed out of its centre.
  void table(const char*, std::vector<double>& xs, std::vector<double>& ys, const char*, const char*, const char*) {
    for (int i = 0; i < 24; ++i) xs.push_back(i * 0.26), ys.push_back(0.5 + 0.1 * std::cos(i * 0.26));
  }
  void outline(const char*, std::vector<std::array<double, 2>>& points, const char*) {
    points = {{-1, 0}, {-0.4, 0.7}, {0.3, 0.9}, {1.1, 0.4}, {1.3, -0.6}};
  }
  void joint(const char* k, std::string& name, const char*) { key(k), name = "pin"; }
  /// A variant: its first kind.
  template <class Variant>
  void form(const char*, Variant& value, const char*) {
    Filler kind;
    std::get<0>(value).describe(kind);
  }
  template <class E>
  void choice(const char*, E&, std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>, const char*) {}
  void function(const char*, Function& f, const char*, const char*) {
    f = HarmonicFunction{.mean = number(), .amplitude = number(), .frequency = 0.4};
  }
  void optional_function(const char* k, Function& f, const char* unit, const char* m) {
    if (k == motion || std::string(k) == "valve" || std::string(k) == "voltage" || std::string(k) == "share")
      function(k, f, unit, m);
  }
  void optional_characteristic(const char*, Characteristic& c, const char*, const char*, const char*) {
    c = PolynomialCharacteristic{{.c = {0, number(), -number(), number()}}};
  }
};

template <class Element>
Element filled(Filler& filler) {
  Element e;
  e.describe(filler);
  if constexpr (requires {
                  Element::has.prepare;
                  e.prepare();
                })
    e.prepare();
  if constexpr (std::is_same_v<Element, JointFriction>) e.attach(Revolute{.body_a = 1, .body_b = 2}, 1);
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
/// Three bodies that fly on parabolas and turn with constant angular acceleration, all of them random.
class Flight {
 public:
  explicit Flight(std::mt19937& random) {
    for (auto& body : c_)
      for (auto& coordinate : body)
        for (double& value : coordinate) value = 3 * (static_cast<double>(random()) / 4294967296.0) - 1.5;
  }
  std::array<double, 3> position(std::size_t i, double t) const {
    return each(i, [t](const auto& c) { return c[0] + t * (c[1] + t * c[2] / 2); });
  }
  std::array<double, 3> velocity(std::size_t i, double t) const {
    return each(i, [t](const auto& c) { return c[1] + t * c[2]; });
  }
  std::array<double, 3> acceleration(std::size_t i) const {
    return each(i, [](const auto& c) { return c[2]; });
  }
  std::array<BodyState, 3> states(double t) const {
    std::array<BodyState, 3> s;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto q = position(i, t), v = velocity(i, t);
      s[i] = {{q[0], q[1]}, q[2], {v[0], v[1]}, v[2]};
    }
    return s;
  }

 private:
  template <class Use>
  std::array<double, 3> each(std::size_t i, Use use) const {
    return {use(c_[i][0]), use(c_[i][1]), use(c_[i][2])};
  }
  std::array<std::array<std::array<double, 3>, 3>, 3> c_{};
};

BodyState shifted(BodyState b, std::size_t k, double by) {
  return {{b.r.x + (k == 0 ? by : 0), b.r.y + (k == 1 ? by : 0)}, b.angle + (k == 2 ? by : 0), b.v, b.omega};
}

template <class Constraint>
ConstraintRows<Constraint::rows> rows_of(const Constraint& c, const std::array<BodyState, 3>& s, double t) {
  ConstraintRows<Constraint::rows> rows;
  if constexpr (Constraint::has.third_body) {
    c.evaluate(s[0], s[1], s[2], t, rows);
  } else {
    c.evaluate(s[0], s[1], t, rows);
  }
  return rows;
}
template <class Constraint>
void settle(Constraint& c, const std::array<BodyState, 3>& s, double t) {
  if constexpr (Constraint::has.third_body) {
    c.initialise_from_pose(s[0], s[1], s[2], t);
  } else if constexpr (Constraint::has.initialise_from_pose) {
    c.initialise_from_pose(s[0], s[1], t);
  }
}

const std::array<double, 3>& on_body(const ConstraintRow& row, std::size_t i) {
  return i == 0 ? row.on_a : i == 1 ? row.on_b : row.on_c;
}

/// dPhi/dt along the flight, from the rows: Phi_q q' + Phi_t.
double phi_rate(const ConstraintRow& row, const Flight& flight, double t) {
  double rate = row.phi_t;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto v = flight.velocity(i, t);
    for (std::size_t k = 0; k < 3; ++k) rate += on_body(row, i)[k] * v[k];
  }
  return rate;
}

/// Phi_q and Phi_t against differences of Phi, then gamma against differences of Phi_q q' + Phi_t along a flight:
/// d/dt (Phi_q q' + Phi_t) = Phi_q q'' - gamma. Central differences of step 1e-5 err by 1e-10 times third derivatives
/// (up to some hundred near a centre of curvature) and 1e-11 of rounding, so 1e-6 of the value's size is wide. A spline
/// bends its second derivative at a knot: a step across one errs by 1e-5 of that bend, and the flights avoid it.
template <class Constraint>
void check_constraint(const Constraint& c, const Flight& flight, double t) {
  constexpr double h = 1e-5;
  const auto s = flight.states(t);
  const auto now = rows_of(c, s, t);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      auto plus = s, minus = s;
      plus[i] = shifted(s[i], k, h), minus[i] = shifted(s[i], k, -h);
      const auto ahead = rows_of(c, plus, t), behind = rows_of(c, minus, t);
      for (std::size_t row = 0; row < now.size(); ++row)
        EXPECT_NEAR(on_body(now[row], i)[k], (ahead[row].phi - behind[row].phi) / (2 * h),
                    1e-6 * (1 + std::abs(on_body(now[row], i)[k])))
            << "row " << row << ", coordinate " << k << " of body " << i;
    }
  if constexpr (Constraint::has.pin)  // solvers leave these out
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(on_body(now[0], i)[1], 0);
      EXPECT_EQ(on_body(now[1], i)[0], 0);
    }
  const auto later = rows_of(c, s, t + h), sooner = rows_of(c, s, t - h);
  const auto ahead = rows_of(c, flight.states(t + h), t + h), behind = rows_of(c, flight.states(t - h), t - h);
  for (std::size_t row = 0; row < now.size(); ++row) {
    EXPECT_NEAR(now[row].phi_t, (later[row].phi - sooner[row].phi) / (2 * h), 1e-6 * (1 + std::abs(now[row].phi_t)));
    double second = -now[row].gamma, size = 1 + std::abs(now[row].gamma);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto q2 = flight.acceleration(i);
      for (std::size_t k = 0; k < 3; ++k)
        second += on_body(now[row], i)[k] * q2[k], size += std::abs(on_body(now[row], i)[k] * q2[k]);
    }
    const double difference = (phi_rate(ahead[row], flight, t + h) - phi_rate(behind[row], flight, t - h)) / (2 * h);
    EXPECT_NEAR(difference, second, 1e-6 * size) << "row " << row;
  }
}

/// What acts between bodies neither pushes nor turns them together, wherever they are: a constraint of their relative
/// state alone has rows that add up to no force and no moment about the origin. (Pin and weld have rows along the
/// world's axes, which do so only where the joint is closed.)
template <class Constraint>
void check_balance(const Constraint& c, const std::array<BodyState, 3>& s, double t) {
  if constexpr (std::is_same_v<Constraint, Revolute> || std::is_same_v<Constraint, Fixed>) return;
  if constexpr (std::is_same_v<Constraint, Coupler>) return;  // of coordinates in the world: the ground takes the rest
  for (const ConstraintRow& row : rows_of(c, s, t)) {
    std::array<double, 3> sum{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& on = on_body(row, i);
      sum[0] += on[0], sum[1] += on[1], sum[2] += on[2] + cross(s[i].r, {on[0], on[1]});
    }
    for (const double part : sum) EXPECT_NEAR(part, 0, 1e-12);
  }
}

constexpr int flights = 30;

TEST(Elements, JointsHaveTheirOwnDerivatives) {
  for_each_type<Joints>([](auto type) {
    std::mt19937 random(7);
    for (int i = 0; i < flights; ++i) {
      Filler filler{.flags = i % 2 == 1};
      auto joint = filled<decltype(type)>(filler);
      SCOPED_TRACE(filler.word + ", flight " + std::to_string(i));
      if constexpr (decltype(type)::has.check) joint.check();
      const Flight flight(random);
      settle(joint, Flight(random).states(0), 0);
      check_constraint(joint, flight, 0.3);
      check_balance(joint, flight.states(0.3), 0.3);
    }
  });
}

TEST(Elements, DriversHaveTheirOwnDerivatives) {
  for_each_type<Drivers>([](auto type) {
    std::mt19937 random(8);
    for (int i = 0; i < flights; ++i) {
      Filler filler{.motion = std::array{"position", "velocity", "acceleration"}[i % 3]};
      auto driver = filled<decltype(type)>(filler);
      SCOPED_TRACE(filler.word + " by " + filler.motion + ", flight " + std::to_string(i));
      driver.check();
      const Flight flight(random);
      settle(driver, flight.states(0.1), 0.1);
      const ConstraintRow start = rows_of(driver, flight.states(0.1), 0.1)[0];
      // A velocity starts from the pose, an acceleration from pose and velocity.
      EXPECT_NEAR(i % 3 > 0 ? start.phi : 0, 0, 1e-15);
      EXPECT_NEAR(i % 3 > 1 ? phi_rate(start, flight, 0.1) : 0, 0, 1e-14);
      check_constraint(driver, flight, 0.3);
      if (driver.body_a() != ground) check_balance(driver, flight.states(0.3), 0.3);
    }
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

constexpr std::array<double, 3> lambda{5, 30, -40};  // of the equations of a joint with friction, from its row 1 on

struct Seen {
  std::array<std::array<double, 3>, 3> wrench{};
  ForcePower power;
};
constexpr std::array<double, 2> element_states{0.7, 1.6};
template <class Force>
Seen act(const Force& force, const std::array<BodyState, 3>& bodies, double t,
         std::span<const double> states = element_states) {
  static const std::vector<Rut> ruts(1);
  Seen seen;
  Loads loads(seen.wrench);
  ForceValues values{};
  seen.power = force.evaluate({bodies, t, ruts, lambda, states}, loads, values);
  return seen;
}
template <class Force>
std::size_t state_count_of_any(const Force& force) {
  if constexpr (Force::has.states) return state_count_of(force);
  return 0;
}
/// States a little later (or earlier), from their rates; the second order cancels in central differences.
template <class Force>
std::array<double, 2> states_after(const Force& force, const std::array<BodyState, 3>& bodies, double t, double h) {
  auto x = element_states;
  if constexpr (Force::has.states) {
    const auto rates = remembering(force).state_rates({bodies, t, {}, lambda, element_states});
    for (std::size_t i = 0; i < rates.size(); ++i) x[i] += h * rates[i];
  }
  return x;
}

// Every force: power on the bodies = work - lost - d(stored)/dt along any motion. Central differences of step 1e-5 err
// by h^2 = 1e-10 times third derivatives of order 10, and by rounding 1e-11; a contact that opens or closes within the
// step is as smooth as depth^2.5, h^1.5 = 3e-8.
TEST(Elements, ForcesKeepTheirEnergyAccount) {
  for_each_type<Forces>([](auto type) {
    Filler filler;
    const auto force = filled<decltype(type)>(filler);
    SCOPED_TRACE(filler.word);
    if constexpr (decltype(type)::has.check) force.check();
    std::mt19937 random(7);
    int acting = 0;
    for (int state = 0; state < 300; ++state) {
      constexpr double h = 1e-5, t = 0.7;
      const Paths paths(random);
      const auto bodies = paths.at(t);
      if constexpr (decltype(type)::has
                        .gaps) {  // one of many is often about to open, where d^n has no third derivative
        std::vector<double> gaps(force.gap_count());
        force.gaps({bodies, t, {}}, gaps);
        if (std::any_of(gaps.begin(), gaps.end(), [](double gap) { return std::abs(gap) < 1e-2; })) continue;
      }
      const Seen now = act(force, bodies, t);
      double power = 0;
      for (std::size_t i = 1; i < 3; ++i)
        power +=
            now.wrench[i][0] * bodies[i].v.x + now.wrench[i][1] * bodies[i].v.y + now.wrench[i][2] * bodies[i].omega;
      const auto later = states_after(force, bodies, t, h), sooner = states_after(force, bodies, t, -h);
      const double stored_rate = (act(force, paths.at(t + h), t + h, later).power.stored -
                                  act(force, paths.at(t - h), t - h, sooner).power.stored) /
                                 (2 * h);
      ASSERT_NEAR(power, now.power.work - now.power.lost - stored_rate, 1e-6 * (1 + std::abs(power)))
          << "state " << state;
      if constexpr (decltype(type)::has.gap) {
        if (state_count_of_any(force) == 0) {  // else it stores energy in its states besides
          EXPECT_EQ(force.gap({bodies, t, {}}) < 0, now.power.stored > 0) << "gap is below 0 just where it acts";
        }
        EXPECT_GE(now.power.lost, 0);
      }
      acting += power != 0 ? 1 : 0;
    }
    EXPECT_GT(acting, 50) << "the test saw little of the force";
  });
}

/// Wrenches on both bodies, and the rates of the force's states.
template <class Force>
Eigen::VectorXd effects(const Force& force, const std::array<BodyState, 3>& bodies, double t,
                        const std::array<double, 2>& states) {
  const Seen seen = act(force, bodies, t, states);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(8);
  for (std::size_t i = 1; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) out[static_cast<Eigen::Index>(3 * (i - 1) + k)] = seen.wrench[i][k];
  if constexpr (Force::has.states) {
    const auto rates = remembering(force).state_rates({bodies, t, {}, lambda, states});
    for (std::size_t i = 0; i < rates.size(); ++i) out[static_cast<Eigen::Index>(6 + i)] = rates[i];
  }
  return out;
}

/// One of 14 numbers that a force depends on: three coordinates of two bodies, their rates, two states.
void shift(std::array<BodyState, 3>& bodies, std::array<double, 2>& states, std::size_t which, double by) {
  if (which >= 12) {
    states[which - 12] += by;
    return;
  }
  BodyState& b = bodies[1 + which % 6 / 3];
  const std::size_t k = which % 3;
  if (which < 6)
    b = shifted(b, k, by);
  else
    (k == 0 ? b.v.x : k == 1 ? b.v.y : b.omega) += by;
}

// Stiffness, damping and what states do, of every force: what modes and equilibria are linearised with, against the
// five-point difference of order 4 at the step 1e-4, where that agrees with itself at half the step. It errs by 1e-16
// of the fifth derivative, up to 1e4 of the value beside a touch, and by 1e-12 of rounding.
TEST(Elements, ForcesHaveTheirStiffnessAndDamping) {
  for_each_type<Forces>([](auto type) {
    Filler filler;
    const auto force = filled<decltype(type)>(filler);
    SCOPED_TRACE(filler.word);
    std::mt19937 random(13);
    int compared = 0;
    for (int state = 0; state < 40; ++state) {
      const auto bodies = Paths(random).at(0.7);
      for (std::size_t which = 0; which < 14; ++which) {
        const auto f = [&](double by) {
          auto b = bodies;
          auto x = element_states;
          shift(b, x, which, by);
          return effects(force, b, 0.7, x);
        };
        const auto difference = [&](double h) {
          return Eigen::VectorXd((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h));
        };
        const Eigen::VectorXd rough = difference(1e-4), fine = difference(5e-5);
        const double size = 1 + fine.cwiseAbs().maxCoeff();
        if ((rough - fine).cwiseAbs().maxCoeff() > 1e-8 * size) continue;  // a law changes within the step
        const Slope slope = slope_at_zero(f, 1e-4, 0);
        ASSERT_LT((slope.value - fine).cwiseAbs().maxCoeff(), 3e-8 * size) << "state " << state << ", " << which;
        compared += fine.isZero(0) ? 0 : 1;
      }
    }
    EXPECT_GT(compared, 30) << "the test saw little of the force";
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
    on_bodies += w[i][0] * bodies[i].v.x + w[i][1] * bodies[i].v.y + w[i][2] * bodies[i].omega;
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
}  // namespace subsoil::mbd::elements_test
