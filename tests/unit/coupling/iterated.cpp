#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "coupling/exchange_stability.hpp"
#include "coupling/quasi_newton.hpp"
#include "tests/unit/coupling/contact_stack.hpp"

/// The iterated exchange: its solver, order, balance of works and stability.
namespace subsoil::coupling::test::iterated {
namespace {

constexpr double kTolerance = 1e-13;  ///< m: four digits beyond what the tests look at

// --- solver ---

TEST(QuasiNewton, SolvesALinearMapThatRepetitionDiverges) {
  constexpr int n = 4;
  Eigen::MatrixXd a(n, n);
  a << -3, 1, 0, 2, 0.5, -8, 1, 0, 0, 2, 5, -1, 1, 0, 0, -20;
  const Eigen::VectorXd b = Eigen::Vector4d(1, -2, 0.5, 3);
  ASSERT_GT(a.eigenvalues().cwiseAbs().minCoeff(), 1) << "repetition must not help";
  const Eigen::VectorXd solution = (Eigen::MatrixXd::Identity(n, n) - a).colPivHouseholderQr().solve(b);
  QuasiNewton solver(Eigen::VectorXd::Zero(n));
  for (int k = 0; k < n + 2; ++k) solver.take(a * solver.at() + b);
  // Of a condition number near 100: rounding, and what the least squares lose of it.
  EXPECT_LT((solver.at() - solution).norm(), 1e-9 * solution.norm());
}

TEST(QuasiNewton, IsTheSecantMethodOfOneUnknown) {
  // z = 2 - z^3: repetition is thrown out; the root is 1.
  QuasiNewton solver(Eigen::VectorXd::Constant(1, 0.9));
  double before[2] = {0, 0}, value[2] = {0, 0};  // z and g(z) - z, the last two
  for (int k = 0; k < 8; ++k) {
    const double z = solver.at()(0), g = 2 - z * z * z;
    if (k >= 2) {
      EXPECT_NEAR(z, before[1] - value[1] * (before[1] - before[0]) / (value[1] - value[0]), 1e-9) << k;
    }
    before[0] = before[1], value[0] = value[1], before[1] = z, value[1] = g - z;
    if (std::abs(g - z) < 1e-12) break;
    solver.take(Eigen::VectorXd::Constant(1, g));
  }
  EXPECT_NEAR(solver.at()(0), 1, 1e-9);
}

// --- order and works ---

class Iterated : public testing::TestWithParam<std::tuple<double, int, mbd::IntegratorKind>> {};

/// The sphere is stepped by leapfrog, the body by the trapezoidal mean: both of second order. With a dashpot the
/// sphere's damping, of half a step before, leaves first order.
TEST_P(Iterated, IsOfSecondOrderOnAContactSpring) {
  const auto [restitution, soil_steps, integrator] = GetParam();
  const Stack s{.restitution = restitution};
  const auto end = exact(s);
  const double omega = std::sqrt(0.5 * s.stiffness / (s.body_mass + s.sphere_mass));
  double before = 0;
  for (const double window : {8e-5, 4e-5, 2e-5}) {
    const StackRun r = run(s, window / soil_steps, soil_steps, integrator, kTolerance);
    EXPECT_GT(r.least_force, 0.1) << "the problem must stay smooth";
    const double now = std::hypot(r.height - end[0], (r.velocity - end[1]) / omega);
    const double at_once = [&] {
      const StackRun once = run(s, window / soil_steps, soil_steps, integrator);
      return std::hypot(once.height - end[0], (once.velocity - end[1]) / omega);
    }();
    EXPECT_LT(now, at_once) << window;
    if (before > 0 && restitution == 1) {
      EXPECT_NEAR(std::log2(before / now), 2, 0.1) << window;
    }
    before = now;
  }
}
INSTANTIATE_TEST_SUITE_P(Exchange, Iterated,
                         testing::Combine(testing::Values(1.0, 0.7), testing::Values(1, 4),
                                          testing::Values(mbd::IntegratorKind::adams_moulton,
                                                          mbd::IntegratorKind::ida)));

TEST(InterfaceWork, OfBothSidesIsTheSameWhereTheyAgree) {
  for (const double restitution : {1.0, 0.5})
    for (const int soil_steps : {1, 8}) {
      const double step = 1e-5;
      const Stack s{.restitution = restitution};
      const StackRun r = run(s, step, soil_steps, mbd::IntegratorKind::adams_moulton, kTolerance);
      // Forces of at most 10 N along 2,000 steps that end within the tolerance.
      EXPECT_NEAR(r.work.error(), 0, 10 * 2000 * kTolerance) << restitution << " " << soil_steps;
    }
}

// --- stability ---

/// A body that lies on one fixed sphere: a mass on a spring and a dashpot, and nothing else that yields.
struct OnASphere {
  double mass, stiffness = 2e5, restitution = 0.5, radius = 0.006, density = 2600, step = 5e-6;

  double sphere_mass() const { return density * 4 / 3 * M_PI * std::pow(radius, 3); }
  dem::SphereSpec ball() const {
    return {.position = {},
            .velocity = {},
            .angular_velocity = {},
            .radius = radius,
            .density = density,
            .material = 0,
            .kind = dem::SphereKind::fixed};
  }
  ContactMode mode() const {
    return {stiffness, 2 * dem::damping_ratio(restitution) * std::sqrt(sphere_mass() * stiffness), mass};
  }
};

/// Heights above the rest at the ends of machine steps, over the overlap at rest; the body starts from -0.001.
std::vector<double> measured(const OnASphere& s, int soil_steps, double tolerance, Method method, int windows,
                             ExchangeCount* count = nullptr) {
  const double g = 9.81, rest = s.mass * g / s.stiffness;
  dem::Bed bed(dem::test::table(dem::test::grains(s.stiffness, s.restitution, 0, 0)), dem::test::quiet({0, -g, 0}));
  bed.add(std::vector{s.ball()});
  const int face = dem::test::add_plane(bed, {}, {0, -1, 0});
  mbd::Model model;
  model.gravity = {0, -g};
  const double height = s.radius - 1.001 * rest;
  const int body = model.add({.name = "weight", .mass = s.mass, .inertia = 1, .pose = {0, height, 0}});
  mbd::MachineOptions options;
  if (method == Method::exact) options.adams_moulton.wrench_jump = mbd::WrenchJump::restart;
  mbd::Machine machine(model, options);
  machine.set_external_wrench(body, 0, 1.001 * s.mass * g, 0);  // of its contact there
  machine.start_from_pose();
  Simulation simulation(&bed, &machine, {{body, face}}, {},
                        {.soil_step = s.step, .soil_steps = soil_steps, .tolerance = tolerance});
  std::vector<double> out;
  for (int w = 0; w < windows; ++w) {
    for (int k = 0; k < soil_steps; ++k) simulation.step();
    out.push_back((machine.body(body).r.y - (s.radius - rest)) / rest);
    EXPECT_LT(std::abs(out.back()), 1) << "the contact must stay closed";
  }
  if (count != nullptr) *count = simulation.exchange();
  return out;
}

/// The same by the recurrence, soil step by soil step: place x, u = v H, its last change g, the surface's last place p.
class Recurrence {
 public:
  Recurrence(const ContactMode& m, double soil_step, int soil_steps, Method method, bool iterated)
      : n_(soil_steps), method_(method), iterated_(iterated) {
    const double window = soil_steps * soil_step;
    a_ = m.stiffness * window * window / m.mass, c_ = m.damping * window / m.mass;
    g_ = -a_ * x_;  // the force at the start
  }
  /// One window; returns the new place.
  double advance() {
    double z = x_ + u_ + 0.5 * g_, f = 0;
    // z = g(z) is linear: two values give its solution.
    const auto ends_at = [&](double end) {
      double sum = 0, before = p_, at = 0;
      const int instants = iterated_ ? n_ + 1 : n_;
      for (int j = 0; j < instants; ++j) {
        const double t = static_cast<double>(j) / n_;
        at = iterated_ ? x_ + (end - x_) * t : x_ + u_ * t + 0.5 * g_ * t * t;
        const double share = iterated_ && (j == 0 || j == n_) ? 0.5 : 1;
        sum += share * (-a_ * at - c_ * n_ * (at - before)) / n_;
        if (j < n_) last_ = at;
        before = at;
      }
      f = sum;
      return x_ + moved(f);
    };
    if (iterated_) {
      const double at_0 = ends_at(0), at_1 = ends_at(1);
      z = at_0 / (1 - (at_1 - at_0));
      ends_at(z);
    }
    z = ends_at(z);
    p_ = last_, g_ = f, x_ = z;
    u_2_ = u_1_, u_1_ = u_, u_ += f;
    return x_;
  }
  /// Norm over that of the window before, at the end of many.
  double growth() {
    double log_of = 0;
    constexpr int windows = 4000;
    for (int w = -100; w < windows; ++w) {  // the first show the start
      advance();
      const double norm = std::hypot(x_, u_, p_);
      for (double* v : {&x_, &u_, &g_, &p_, &u_1_, &u_2_}) *v /= norm;
      if (w >= 0) log_of += std::log(norm);
    }
    return std::exp(log_of / windows);
  }

 private:
  double moved(double f) const {
    return method_ == Method::exact ? u_ + 0.5 * f : (9 * (u_ + f) + 19 * u_ - 5 * u_1_ + u_2_) / 24;
  }

  int n_;
  Method method_;
  bool iterated_;
  double a_ = 0, c_ = 0, x_ = -1e-3, u_ = 0, g_ = 0, p_ = -1e-3, u_1_ = 0, u_2_ = 0, last_ = 0;
};

/// Soil steps per machine step from which the explicit exchange grows.
int bound_of(const OnASphere& s, Method method) {
  int n = 1;
  while (n < 2000 && explicit_growth(s.mode(), s.step, n, method) < 1) ++n;
  return n;
}

TEST(ExplicitGrowth, OfOneSoilStepHasTheClosedBound) {
  // Jury's condition of the cubic for n = 1, by hand: c (1 - c/2) > (a/2)(1 + c/2).
  for (const double mass : {0.5, 0.01, 1e-3, 1e-4})
    for (const double step : {1e-6, 5e-6, 2e-5, 5e-5, 1e-4, 2e-4}) {
      const ContactMode m = OnASphere{.mass = mass}.mode();
      const double a = m.stiffness * step * step / mass, c = m.damping * step / mass;
      const bool stable = c * (1 - c / 2) > a / 2 * (1 + c / 2);
      EXPECT_EQ(explicit_growth(m, step, 1, Method::exact) < 1, stable) << mass << " " << step;
    }
}

/// The largest eigenvalue is the growth of the recurrence; a complex pair beats, by less than 1/4000 per window.
TEST(Growth, IsThatOfTheRecurrence) {
  for (const double mass : {0.5, 0.05, 0.002})
    for (const int n : {1, 7, 60, 200})
      for (const Method method : {Method::exact, Method::adams_moulton_4}) {
        const OnASphere s{.mass = mass};
        Recurrence once(s.mode(), s.step, n, method, false), agreed(s.mode(), s.step, n, Method::exact, true);
        EXPECT_NEAR(once.growth() / explicit_growth(s.mode(), s.step, n, method), 1, 2e-3) << mass << " " << n;
        EXPECT_NEAR(agreed.growth() / iterated_growth(s.mode(), s.step, n), 1, 2e-3) << mass << " " << n;
      }
}

/// Bed and machine together do what the recurrence does, on both sides of the bound of the explicit exchange.
TEST(Growth, OfBedAndMachineIsThatOfTheRecurrence) {
  const OnASphere s{.mass = 0.05};
  const Method shift = Method::adams_moulton_4;
  for (const Method method : {Method::exact, shift}) {
    const int bound = bound_of(s, method);
    ASSERT_GT(bound, 20);
    ASSERT_LT(bound, 2000);
    for (const double share : {0.7, 0.95, 1.05}) {
      const int n = static_cast<int>(share * bound), windows = 16;
      EXPECT_EQ(explicit_growth(s.mode(), s.step, n, method) > 1, share > 1);
      Recurrence once(s.mode(), s.step, n, method, false), agreed(s.mode(), s.step, n, Method::exact, true);
      ExchangeCount count;
      // Adams-Moulton has its order from the fourth window on; before, it starts by Runge-Kutta, which is exact here.
      const auto explicitly = measured(s, n, 0, method, windows);
      const auto iteratively = measured(s, n, 1e-16, Method::exact, windows, &count);
      double largest_once = 1e-3, largest_agreed = 1e-3;
      for (int w = 0; w < windows; ++w) {
        const auto k = static_cast<std::size_t>(w);
        const double x = once.advance(), y = agreed.advance();
        largest_once = std::max(largest_once, std::abs(x)), largest_agreed = std::max(largest_agreed, std::abs(y));
        // The tolerance of the iteration is 4e-11 of the overlap.
        EXPECT_NEAR(iteratively[k], y, 1e-6 * largest_agreed) << n << " " << w;
        if (method == Method::exact) {
          EXPECT_NEAR(explicitly[k], x, 1e-6 * largest_once) << n << " " << w;
        }
      }
      EXPECT_EQ(count.windows, windows) << n;
      EXPECT_EQ(count.open, 0) << n;
      EXPECT_LT(largest_agreed, 1.01e-3) << n;
      // A linear contact has a secant that hits.
      EXPECT_LE(static_cast<double>(count.evaluations), 4.0 * static_cast<double>(count.windows)) << n;
    }
  }
  // By Adams-Moulton, whose first windows differ: on both sides of its own bound the end is smaller or larger.
  const int bound = bound_of(s, shift);
  for (const int n : {bound * 9 / 10, bound * 11 / 10}) {
    const auto heights = measured(s, n, 0, shift, 14);
    const double first = std::hypot(heights[4], heights[5], heights[6]),
                 last = std::hypot(heights[11], heights[12], heights[13]);
    EXPECT_EQ(last > first, n > bound) << n << ": " << first << " to " << last;
  }
}

TEST(Growth, OfALightBodyIsStoppedByIterationWithOneSoilStep) {
  // m < C H/2: the dashpot alone throws it.
  OnASphere s{.mass = 1};
  s.mass = 0.8 * 0.5 * s.mode().damping * s.step;
  ASSERT_GT(explicit_growth(s.mode(), s.step, 1, Method::exact), 1);
  ASSERT_LT(iterated_growth(s.mode(), s.step, 1), 1);
  const auto heights = measured(s, 1, 1e-16, Method::exact, 200);
  EXPECT_LT(std::abs(heights.back()), 2e-5);  // by theory it is at rest; the tolerance is 2e-6 of the overlap
}

TEST(Growth, IteratedIsNeverAboveOne) {
  for (double a = 1e-6; a < 1e9; a *= 10)
    for (double c = 1e-9; c < 1e7; c *= 10)
      for (const int n : {1, 2, 10, 1000}) {
        const double step = 1.0 / n;  // H = 1 s, m = 1 kg
        EXPECT_LT(iterated_growth({a, c, 1}, step, n), 1 + 1e-9) << a << " " << c << " " << n;
      }
}

// --- what a run sees ---

TEST(Exchange, CountsWindowsThatDoNotAgree) {
  const OnASphere s{.mass = 0.05};
  dem::Bed bed(dem::test::table(dem::test::grains(s.stiffness, 0.5, 0, 0)), dem::test::quiet({}));
  bed.add(std::vector{s.ball()});
  const int face = dem::test::add_plane(bed, {}, {0, -1, 0});
  mbd::Model model;
  model.gravity = {0, 0};
  const int body = model.add({.name = "weight", .mass = s.mass, .inertia = 1, .pose = {0, 0.9 * s.radius, 0}});
  mbd::Machine machine(model);
  machine.start_from_pose();
  // One evaluation cannot agree on a spring: the first guess knows nothing of its force.
  Simulation simulation(&bed, &machine, {{body, face}}, {},
                        {.soil_step = s.step, .soil_steps = 20, .tolerance = 1e-12, .most_iterations = 1});
  for (int k = 0; k < 40; ++k) simulation.step();
  EXPECT_EQ(simulation.exchange().windows, 2);
  EXPECT_EQ(simulation.exchange().open, 2);
  EXPECT_GT(simulation.exchange().widest, 1e-12);
}

/// A state inside a window holds the path and the wrench that were agreed upon.
TEST(Exchange, ContinuesFromInsideAWindowWithTheSameBits) {
  const auto height = [](long save_at) {
    const Stack s{.restitution = 0.7};
    dem::Bed bed(dem::test::table(dem::test::grains(s.stiffness, s.restitution, 0, 0)),
                 dem::test::quiet({0, -s.gravity, 0}));
    const dem::SphereSpec ball{
        {0, s.sphere_start(), 0}, {}, {}, s.radius, s.sphere_mass / (4.0 / 3.0 * M_PI * std::pow(s.radius, 3)), 0};
    bed.add(std::span(&ball, 1));
    dem::test::add_plane(bed, {}, {0, 1, 0});
    const int face = dem::test::add_plane(bed, {0, -s.face, 0}, {0, -1, 0});
    mbd::Model model;
    model.gravity = {0, -s.gravity};
    const int body =
        model.add({.name = "weight", .mass = s.body_mass, .inertia = 1e-3, .pose = {0, s.body_start(), 0}});
    mbd::Machine machine(model);
    machine.start_from_pose();
    Simulation simulation(&bed, &machine, {{body, face}}, {}, {.soil_step = 1e-5, .soil_steps = 8, .tolerance = 1e-12});
    for (long k = 0; k < 100; ++k) {
      if (k == save_at) {
        const dem::Bed::State soil = bed.save();
        const ExchangeState state = simulation.save();
        const mbd::Snapshot of_machine = machine.snapshot();
        for (int later = 0; later < 30; ++later) simulation.step();
        bed.restore(soil), machine.restore(of_machine), simulation.restore(state);
      }
      simulation.step();
    }
    return std::array{machine.body(body).r.y, bed.spheres()[0].x.y, bed.spheres()[0].v.y};
  };
  EXPECT_EQ(height(-1), height(43));
}

}  // namespace
}  // namespace subsoil::coupling::test::iterated
