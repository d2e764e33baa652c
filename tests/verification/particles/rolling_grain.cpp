// A grain that rolls round another body and spins about the normal as it goes: the normal turns in every step, so a
// rate of the middle of the step in the geometry of its end is an error of first order, by which a fine grain sticks
// between two coarse ones. The oracle is the continuous law by Runge and Kutta's fourth-order rule, written here from
// theory.md.
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/particles/fixed.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/verified.hpp"

namespace subsoil::dem::test::rolling_grain {
namespace {

/// What a support is to the grain's centre at one instant.
struct Near {
  Vec3 n;               ///< from the support to the centre
  double distance;      ///< of the centre from its surface
  Vec3 v, w;            ///< of its point under the grain; angular velocity
  Vec3 turning;         ///< dn/dt
  bool sphere = false;  ///< the contact lies in the middle of the overlap, else on the surface
};
using Support = std::function<Near(double t, const Vec3& x, const Vec3& v)>;

struct Springs {
  double k = 0, k_t = 0, k_r = 0, k_w = 0;
  double mu = 1e6;     ///< nothing slips
  double damping = 0;  ///< c_n, N s/m; c_t follows as of the linear law
};

struct Grain {
  double r = 0, m = 0;
  Vec3 gravity;
  Springs springs;
  std::vector<Support> supports;
};

/// Numbers of the continuous system: x, v, w, and of each support the springs of sliding, rolling and twist.
struct Motion {
  Vec3 x, v, w;
  std::array<Vec3, 2> slide{}, roll{};
  std::array<double, 2> twist{};

  void add(double h, const Motion& rate) {
    x += h * rate.x, v += h * rate.v, w += h * rate.w;
    for (std::size_t k = 0; k < 2; ++k)
      slide[k] += h * rate.slide[k], roll[k] += h * rate.roll[k], twist[k] += h * rate.twist[k];
  }
};

/// Rates, and the springs as friction's limit leaves them.
Motion rate_of(const Grain& g, double t, Motion& y, bool limit = false) {
  Motion out;
  Vec3 force = g.m * g.gravity, torque;
  const Springs& s = g.springs;
  for (std::size_t k = 0; k < g.supports.size(); ++k) {
    const Near at = g.supports[k](t, y.x, y.v);
    const double overlap = g.r - at.distance;
    if (overlap <= 0) {
      y.slide[k] = y.roll[k] = {}, y.twist[k] = 0;
      continue;
    }
    const double arm = at.sphere ? g.r - overlap / 2 : g.r - overlap;
    const Vec3 v = y.v - at.v, w = y.w - at.w, contact = v - arm * cross(y.w, at.n);
    const double v_n = dot(v, at.n), press = s.k * overlap - s.damping * v_n;
    const Vec3 slip = contact - v_n * at.n, rolling = w - dot(w, at.n) * at.n;
    Vec3 friction = -s.k_t * y.slide[k] - (std::sqrt(s.k_t / s.k) * s.damping) * slip;
    const double most = s.mu * std::max(press, 0.0);
    if (norm(friction) > most) {
      friction *= most / norm(friction);
      if (limit) y.slide[k] *= std::min(1.0, most / (s.k_t * norm(y.slide[k])));
    }
    force += press * at.n + friction;
    torque += cross(-arm * at.n, friction) - s.k_r * y.roll[k] - s.k_w * y.twist[k] * at.n;
    out.slide[k] = slip - dot(y.slide[k], at.turning) * at.n;
    out.roll[k] = rolling - dot(y.roll[k], at.turning) * at.n;
    out.twist[k] = dot(w, at.n);
  }
  out.x = y.v, out.v = (1 / g.m) * force, out.w = (2.5 / (g.m * g.r * g.r)) * torque;
  return out;
}

Motion integrate(const Grain& g, Motion y, double from, double dt, long steps) {
  for (long n = 0; n < steps; ++n) {
    const double t = from + static_cast<double>(n) * dt;
    const auto moved = [&](double h, const Motion& rate) {
      Motion out = y;
      out.add(h, rate);
      return out;
    };
    const Motion k1 = rate_of(g, t, y);
    Motion b = moved(dt / 2, k1);
    const Motion k2 = rate_of(g, t + dt / 2, b);
    Motion c = moved(dt / 2, k2);
    const Motion k3 = rate_of(g, t + dt / 2, c);
    Motion d = moved(dt, k3);
    const Motion k4 = rate_of(g, t + dt, d);
    y.add(dt / 6, k1), y.add(dt / 3, k2), y.add(dt / 3, k3), y.add(dt / 6, k4);
    rate_of(g, t + dt, y, true);
  }
  return y;
}

/// The engine's side of a case: its supports, and where the moving ones are.
struct Stage {
  std::vector<SphereSpec> spheres;  ///< fixed
  std::optional<Boundary> boundary;
  std::function<void(Boundary&, double t, double dt)> place;  ///< at t, after a step dt
};

constexpr double kDensity = 2500;

struct Case {
  Grain grain;
  Stage stage;
  Motion start;
  double end = 0;
};

Motion engine(const Case& c, double dt, Precision precision = Precision::doubles) {
  Linear law;
  const Springs& s = c.grain.springs;
  law.k_n = s.k, law.stiffness_ratio = s.k_t / s.k, law.damping = s.damping;
  law.friction.mu = s.mu;
  if (s.k_r > 0) {
    // The limit of rolling is far away: mu_r r_eff N against k_r rho. That of twist is 2.25 mu_t r of the overlap.
    law.friction.mu_r = 1e3, law.friction.k_r = s.k_r, law.friction.c_r = 0, law.friction.rolling_damping = 0;
  }
  const double other = c.stage.spheres.empty() ? 0 : c.stage.spheres.front().radius;
  const double r_eff = other > 0 ? c.grain.r * other / (c.grain.r + other) : c.grain.r;
  if (s.k_w > 0) law.friction.mu_t = std::sqrt(s.k_w / (2.25 * s.k)) / r_eff;
  BedOptions options = quiet(c.grain.gravity);
  options.precision = precision;
  Bed bed(table(law), options);
  std::vector<SphereSpec> all{{c.start.x, c.start.v, c.start.w, c.grain.r, kDensity, 0}};
  for (const SphereSpec& sphere : c.stage.spheres) all.push_back(fixed(sphere));
  bed.add(all);
  int index = -1;
  if (c.stage.boundary) index = bed.add(Boundary(*c.stage.boundary));
  const long steps = std::lround(c.end / dt);
  for (long n = 0; n < steps; ++n) {
    bed.step(dt);
    if (c.stage.place) c.stage.place(bed.boundary(index), static_cast<double>(n + 1) * dt, dt);
  }
  Motion out;
  out.x = sphere(bed, 0).x;
  return out;
}

/// Errors of the place at the end fall with the square of the step. `first`: the coarsest; each next is half of it.
void expect_second_order(const Case& c, double first, const char* what) {
  const Vec3 exact = integrate(c.grain, c.start, 0, first / 64, std::lround(64 * c.end / first)).x;
  const double way = norm(exact - c.start.x);
  double error[3];
  for (int k = 0; k < 3; ++k) error[k] = norm(engine(c, std::ldexp(first, -k)).x - exact);
  std::printf("    %s: %.3e of the way with 1 step, / %.2f with 2, / %.2f with 4\n", what, error[0] / way,
              error[0] / error[1], error[1] / error[2]);
  // 4 of second order, 2 of first; the coarsest step has some of the next order, too.
  EXPECT_GT(error[0] / error[1], 3.4) << what;
  EXPECT_GT(error[1] / error[2], 3.6) << what;
  EXPECT_LT(error[2] / error[1], 1) << what;
  EXPECT_LT(error[0], 0.02 * way) << what;
}

Near on_sphere(const Vec3& centre, double radius, const Vec3& x, const Vec3& v) {
  const Vec3 d = x - centre;
  const double length = norm(d);
  const Vec3 n = (1 / length) * d;
  return {n, length - radius, {}, {}, (1 / length) * (v - dot(v, n) * n), true};
}

/// On top of a body at rest, a little aside, with an overlap of 2 % under its weight; it spins about the normal and
/// rolls off. In some hundred steps of the normal spring it goes through half a radian.
Case beginning(double r, double coarse, double from_top) {
  constexpr double g = 9.81;
  Case c;
  c.grain.r = r, c.grain.m = kDensity * sphere_volume(r), c.grain.gravity = {0, -g, 0};
  Springs& s = c.grain.springs;
  s.k = c.grain.m * g / (0.02 * r), s.k_t = 0.8 * s.k;
  const double reach = coarse + r;
  const Vec3 n{std::sin(from_top), std::cos(from_top), 0};
  const Vec3 along{std::cos(from_top), -std::sin(from_top), 0};
  const double speed = 0.3 * std::sqrt(g * reach);
  c.start.x = (reach - 0.02 * r) * n;
  c.start.v = speed * along + Vec3{0, 0, 0.2 * speed};
  c.start.w = (speed / r) * (cross(n, along) + 1.5 * n);
  c.end = 0.5 * std::sqrt(reach / g);
  return c;
}

/// About 120 steps to a period of the normal spring: coarser ones have as much of the fourth order as of the second.
double coarsest(const Case& c) {
  const double period = 2 * pi * std::sqrt(c.grain.m / c.grain.springs.k);
  return c.end / std::ceil(c.end / (period / 120));
}

class Ratio : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(OfSizes, Ratio, testing::Values(1.0, 4.0, 20.0),
                         [](const auto& info) { return std::to_string(static_cast<int>(info.param)); });

TEST_P(Ratio, RoundASphereIsOfSecondOrder) {
  const double coarse = 5e-3, r = coarse / GetParam();
  Case c = beginning(r, coarse, 0.1);
  c.stage.spheres = {{{}, {}, {}, coarse, kDensity, 0}};
  c.grain.supports = {[=](double, const Vec3& x, const Vec3& v) { return on_sphere({}, coarse, x, v); }};
  expect_second_order(c, coarsest(c), "sphere");
}

TEST_P(Ratio, RoundASphereWithRollingAndTwistIsOfSecondOrder) {
  const double coarse = 5e-3, r = coarse / GetParam();
  Case c = beginning(r, coarse, 0.1);
  // Rolling and twisting through a radian take some percent of the weight times the radius.
  c.grain.springs.k_r = 0.02 * c.grain.m * 9.81 * r;
  c.grain.springs.k_w = 1e-3 * c.grain.springs.k * r * r;
  c.stage.spheres = {{{}, {}, {}, coarse, kDensity, 0}};
  c.grain.supports = {[=](double, const Vec3& x, const Vec3& v) { return on_sphere({}, coarse, x, v); }};
  // The twisting spring holds to 2 % r/(2.25 mu_t r_eff) rad.
  c.start.w -= 0.97 * dot(c.start.w, normalized(c.start.x)) * normalized(c.start.x);
  expect_second_order(c, coarsest(c), "sphere, rolling and twist");
}

TEST_P(Ratio, RoundACylinderIsOfSecondOrder) {
  const double coarse = 5e-3, r = coarse / GetParam();
  Case c = beginning(r, coarse, 0.1);
  c.stage.boundary.emplace();
  c.stage.boundary->shape = Cylinder({}, {0, 0, 1}, coarse, 1);
  c.grain.supports = {[=](double, const Vec3& x, const Vec3& v) {
    const Vec3 d{x.x, x.y, 0};
    const double length = norm(d);
    const Vec3 n = (1 / length) * d, aside{v.x, v.y, 0};
    return Near{n, length - coarse, {}, {}, (1 / length) * (aside - dot(aside, n) * n)};
  }};
  expect_second_order(c, coarsest(c), "cylinder");
}

/// Round the edge of a box: a cylinder of no radius.
TEST_P(Ratio, RoundAnEdgeOfAMeshIsOfSecondOrder) {
  const double r = 5e-3 / GetParam();
  Case c = beginning(r, 0, 0.1);
  c.stage.boundary.emplace();
  c.stage.boundary->shape = MeshSurface(box_mesh({0.1, 0.1, 0.2}, {-0.05, -0.05, 0}));
  c.grain.supports = {[=](double, const Vec3& x, const Vec3& v) {
    const Vec3 d{x.x, x.y, 0};
    const double length = norm(d);
    const Vec3 n = (1 / length) * d, aside{v.x, v.y, 0};
    return Near{n, length, {}, {}, (1 / length) * (aside - dot(aside, n) * n)};
  }};
  expect_second_order(c, coarsest(c), "edge");
}

/// On a plate that turns about an axis neither square to it nor in it, of a plane and of a mesh: dn/dt = Omega x n.
void on_a_turning_plate(const Shape& shape, double r, const char* what) {
  constexpr double g = 9.81;
  Case c;
  c.grain.r = r, c.grain.m = kDensity * sphere_volume(r), c.grain.gravity = {0, -g, 0};
  Springs& s = c.grain.springs;
  s.k = c.grain.m * g / (0.02 * r), s.k_t = 0.8 * s.k;
  const double rate = 0.5 * std::sqrt(g / (50 * r));
  const Vec3 omega{0.8 * rate, 0.5 * rate, 1.0 * rate}, at{0, -2 * r, r};  // of a point that it turns about
  c.start.x = {0, 0.98 * r, 0};
  c.start.v = cross(omega, c.start.x - at) + 0.1 * std::sqrt(g * r) * Vec3{1, 0, 0.5};
  c.start.w = omega + (0.1 * std::sqrt(g / r)) * Vec3{0.5, 3, -1};
  c.end = 8 * std::sqrt(50 * r / g) / 50;
  const auto attitude = [=](double t) { return Quaternion::from_rotation_vector(t * omega); };
  c.grain.supports = {[=](double t, const Vec3& x, const Vec3&) {
    const Vec3 n = attitude(t).rotate({0, 1, 0}), origin = at + attitude(t).rotate(-at);
    const double distance = dot(x - origin, n);
    const Vec3 point = x - distance * n;
    return Near{n, distance, cross(omega, point - at), omega, cross(omega, n)};
  }};
  c.stage.boundary.emplace();
  c.stage.boundary->shape = shape;
  c.stage.boundary->angular_velocity = omega;
  c.stage.boundary->velocity = cross(omega, -at);
  c.stage.place = [=](Boundary& b, double t, double dt) {
    b.pose.attitude = attitude(t);
    b.pose.position = at + attitude(t).rotate(-at);
    b.velocity = (1 / dt) * (b.pose.position - (at + attitude(t - dt).rotate(-at)));
    b.angular_velocity = omega;
  };
  expect_second_order(c, coarsest(c), what);
}

TEST_P(Ratio, OnATurningPlaneIsOfSecondOrder) { on_a_turning_plate(Plane({}, {0, 1, 0}), 5e-3 / GetParam(), "plane"); }
TEST_P(Ratio, OnATurningMeshIsOfSecondOrder) {
  on_a_turning_plate(MeshSurface(rectangle_mesh({-0.1, 0, -0.1}, {0, 0, 0.2}, {0.2, 0, 0})), 5e-3 / GetParam(), "mesh");
}

// Between two coarse spheres.

constexpr double kCoarse = 5e-3, kGravity = 9.81;

/// The case of Vyas et al. 2025, also of other size ratios: a grain on top of the gap between two fixed spheres that
/// touch, a degree aside. It rolls down between them, spins about both normals, and leaves them.
Case between_two(double ratio) {
  constexpr double aside = 0.01745329;
  Case c;
  const double r = kCoarse / ratio, together = kCoarse + r, reach = std::sqrt(together * together - kCoarse * kCoarse);
  c.grain.r = r, c.grain.m = kDensity * sphere_volume(r), c.grain.gravity = {0, -kGravity, 0};
  c.grain.springs = {.k = 1e4, .k_t = 8235, .mu = 0.5};
  const double loss = std::log(2), beta = loss / std::hypot(pi, loss);
  c.grain.springs.damping = 2 * beta * std::sqrt(c.grain.m * c.grain.springs.k);
  c.start.x = {kCoarse, reach * std::cos(aside), reach * std::sin(aside)};
  for (const Vec3& at : {Vec3{2 * kCoarse, 0, 0}, Vec3{}}) {
    c.stage.spheres.push_back({at, {}, {}, kCoarse, kDensity, 0});
    c.grain.supports.push_back([=](double, const Vec3& x, const Vec3& v) { return on_sphere(at, kCoarse, x, v); });
  }
  return c;
}

/// Calls at(time, kinetic energy of translation, angle from the top) after each step of the engine.
template <class At>
void roll_between(double ratio, double dt, double end, Precision precision, const At& at) {
  const Case c = between_two(ratio);
  Linear law;
  law.k_n = c.grain.springs.k, law.stiffness_ratio = c.grain.springs.k_t / law.k_n, law.restitution = 0.5;
  law.friction.mu = c.grain.springs.mu;
  BedOptions options = quiet(c.grain.gravity);
  options.precision = precision;
  Bed bed(table(law), options);
  std::vector<SphereSpec> all{{c.start.x, {}, {}, c.grain.r, kDensity, 0}};
  for (const SphereSpec& one : c.stage.spheres) all.push_back(fixed(one));
  bed.add(all);
  const long steps = std::lround(end / dt);
  for (long n = 1; n <= steps; ++n) {
    bed.step(dt);
    const Sphere& s = sphere(bed, 0);
    at(static_cast<double>(n) * dt, 0.5 * c.grain.m * dot(s.v, s.v), std::atan2(s.x.z, s.x.y) * 180 / pi);
  }
}

struct Published {
  double time, energy;  ///< s, J
};

/// LAMMPS, examples/granular, log of 18 February 2025: velocity Verlet whose history is of the middle of the step.
constexpr Published kPublished[] = {{0.030, 1.0732e-13}, {0.060, 1.0536e-12}, {0.090, 8.3125e-12},
                                    {0.120, 6.2345e-11}, {0.144, 2.7996e-10}, {0.180, 1.2744e-8}};

// The motion begins at an unstable place and grows by e in 14 ms: what differs by a share of a step at the start is as
// large a share of it later. 2 % is five steps of 1 us and the two digits of the start that the input has.
TEST(BetweenTwo, AFineGrainFallsAsThePublishedOne) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    std::size_t next = 0;
    roll_between(20, 1e-6, 0.1801, precision, [&](double t, double energy, double) {
      if (next == std::size(kPublished) || t < kPublished[next].time - 1e-9) return;
      std::printf("    %.0f ms: %.4e J, published %.4e J\n", 1e3 * t, energy, kPublished[next].energy);
      EXPECT_NEAR(energy, kPublished[next].energy, 0.02 * kPublished[next].energy) << t;
      ++next;
    });
    EXPECT_EQ(next, std::size(kPublished));
  }
}

class LeavesTwo : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(OfSizes, LeavesTwo, testing::Values(12.5, 10.0, 5.0, 4.0));

// The angle at 0.13 s, before it leaves at some 60 degrees, is that of the continuous law.
TEST_P(LeavesTwo, AtTheAngleOfTheContinuousLaw) {
  const double dt = 2e-5 * std::pow(GetParam(), -1.5), end = 0.13;  // 25 steps to a period of the contact
  const Case c = between_two(GetParam());
  double ours = 0;
  roll_between(GetParam(), dt, end, Precision::doubles, [&](double, double, double angle) { ours = angle; });
  const long steps = std::lround(end / dt);
  const Vec3 exact = integrate(c.grain, c.start, 0, end / static_cast<double>(4 * steps), 4 * steps).x;
  const double angle = std::atan2(exact.z, exact.y) * 180 / pi;
  std::printf("    ratio %.3g: %.3f degrees, the continuous law %.3f degrees\n", GetParam(), ours, angle);
  EXPECT_GT(angle, 30);
  EXPECT_NEAR(ours, angle, 0.01 * angle);
}

}  // namespace
}  // namespace subsoil::dem::test::rolling_grain
