#include <gtest/gtest.h>

#include "coupling/simulation.hpp"
#include "tests/tools/dem_beds.hpp"

/// Boundaries that a servo presses onto spheres.
namespace subsoil::coupling::test::servo {
namespace {

constexpr double radius = 0.01, k_n = 1e5, dt = 2e-6;

Servo pressing(double load, double gain, double limit) {
  return {.along = {0, -1, 0}, .load = [load](double) { return load; }, .gain = gain, .limit = limit};
}

/// A sphere on a floor, and a plate `gap` above it that looks down.
struct Press {
  dem::Bed bed;
  int plate = 0;
  explicit Press(double gap, double restitution = 0.5)
      : bed(dem::test::table(dem::test::grains(k_n, restitution, 0, 0)), dem::test::quiet()) {
    dem::test::add_plane(bed, {}, {0, 1, 0});
    plate = dem::test::add_plane(bed, {}, {0, -1, 0});
    const dem::SphereSpec ball{{0, radius, 0}, {}, {}, radius, 2500, 0};
    bed.add(std::span(&ball, 1));
    start.position = {0, 2 * radius + gap, 0};
    bed.boundary(plate).pose = start;
  }
  dem::Pose start;
  Simulation pressed_by(const Servo& servo) {
    return Simulation(&bed, nullptr, {}, {{plate, [at = start](double) { return at; }, servo}}, {.soil_step = dt});
  }
};

TEST(Servo, GoesAtItsLimitWhereNothingResists) {
  Press p(1.0);
  Simulation s = p.pressed_by(pressing(10, 0.1, 0.4));  // gain x load = 1 m/s: limited
  for (int n = 0; n < 1000; ++n) s.step();
  EXPECT_NEAR(s.servo(0).travel, 0.4 * 1000 * dt, 1e-12);
  EXPECT_NEAR(s.surface_pose(p.plate).position.y, p.start.position.y - 0.4 * 1000 * dt, 1e-12);
  EXPECT_NEAR(p.bed.boundary(p.plate).velocity.y, -0.4, 1e-9);
  Press free(1.0);
  Simulation slow = free.pressed_by(pressing(10, 0.01, 0.4));  // 0.1 m/s
  for (int n = 0; n < 1000; ++n) slow.step();
  EXPECT_NEAR(slow.servo(0).travel, 0.1 * 1000 * dt, 1e-12);
}

/// A massless plate behind a dashpot 1/K_p on the springs of two contacts in series, k/2:
/// F(t) = F_load (1 - exp(-K_p k t/2)). The sphere's own oscillation of period 2 pi sqrt(m/(2k)) = 1.5 ms is short
/// against 1/(K_p k/2) = 20 ms: it adds a share of (1.5/(2 pi 20))^2, and its damper 1 %.
TEST(Servo, MeetsTheLoadAsAPlateBehindADashpot) {
  Press p(0);
  const double load = 20, gain = 1e-3;
  Simulation s = p.pressed_by(pressing(load, gain, 1));
  double worst = 0;
  const int steps = 100000;  // 0.2 s: ten time constants
  for (int n = 0; n < steps; ++n) {
    s.step();
    const double t = n * dt, expected = load * (1 - std::exp(-gain * k_n / 2 * t));
    worst = std::max(worst, std::abs(s.servo(0).force - expected));
  }
  EXPECT_LT(worst, 0.02 * load);
  EXPECT_NEAR(s.servo(0).force, load, 1e-3 * load) << "exp(-10)";
  EXPECT_NEAR(s.servo(0).travel, 2 * load / k_n, 1e-3 * 2 * load / k_n);
}

/// The plate's mass T/K_p: in free flight its speed comes up as 1 - exp(-t/T).
TEST(Servo, LagIsAMass) {
  Press p(1.0);
  Servo servo = pressing(10, 0.01, 0.4);  // 0.1 m/s
  servo.lag = 1e-3;
  Simulation s = p.pressed_by(servo);
  for (int n = 0; n < 1000; ++n) s.step();
  const double t = 1000 * dt, lag = servo.lag;
  EXPECT_NEAR(s.servo(0).velocity, 0.1 * (1 - std::exp(-t / lag)), 1e-9);
  EXPECT_NEAR(s.servo(0).travel, 0.1 * (t - lag * (1 - std::exp(-t / lag))), 0.1 * dt) << "a step of the sum";
}

/// Damping of the contact: K_p c = 3.8 would make a massless plate jump between its limits; with a lag it settles.
TEST(Servo, LagHoldsAPlateThatDampingWouldThrow) {
  for (const double lag : {0.0, 20 * dt}) {
    Press p(0, 0.1);
    Servo servo = pressing(20, 0.1, 0.5);
    servo.lag = lag;
    Simulation s = p.pressed_by(servo);
    double worst = 0;
    for (int n = 0; n < 50000; ++n) {
      s.step();
      if (n > 40000) worst = std::max(worst, std::abs(s.servo(0).error));
    }
    if (lag > 0)
      EXPECT_LT(worst, 0.02);
    else
      EXPECT_GT(worst, 1);
  }
}

/// The load rises in time: K_p alone lags by 1/(K_p k/2) of its rate; the integral takes that away.
TEST(Servo, IntegralTakesTheLagOfARisingLoadAway) {
  for (const double integral : {0.0, 0.11}) {
    Press p(0);
    Servo servo = pressing(0, 3e-3, 1);
    servo.load = [](double t) { return 400 * t; };
    servo.integral_gain = integral;
    Simulation s = p.pressed_by(servo);
    for (int n = 0; n < 50000; ++n) s.step();
    const double lag = 400 / (3e-3 * k_n / 2);  // 2.7 N
    EXPECT_NEAR(s.servo(0).error, integral > 0 ? 0 : lag, 0.05 * lag) << integral;
  }
}

/// Work of the plate = what the contacts hold and have lost + kinetic energy. Work is the mean force of two instants
/// times the displacement, the bed's own is the leapfrog's: both of second order, 1e-4 of the work at this step.
TEST(Servo, PutsInWhatTheBedGets) {
  Press p(1e-4);
  Simulation s = p.pressed_by(pressing(20, 2e-3, 0.05));
  for (int n = 0; n < 20000; ++n) s.step({.energy = true});
  const dem::BedEnergy& e = p.bed.energy();
  EXPECT_NEAR(e.boundary_work, p.bed.boundary(p.plate).work, 1e-15);
  EXPECT_GT(e.boundary_work, 1e-3);
  EXPECT_NEAR(e.total(), e.boundary_work, 1e-3 * e.boundary_work);
}

TEST(Servo, GoesOnFromAStateWithTheSameBits) {
  const auto servo = [] {
    Servo v = pressing(20, 1e-3, 0.05);
    v.integral_gain = 0.02, v.rate_gain = 1e-7;
    return v;
  };
  Press straight(1e-4), half(1e-4), rest(1e-4);
  Simulation a = straight.pressed_by(servo()), b = half.pressed_by(servo()), c = rest.pressed_by(servo());
  for (int n = 0; n < 8000; ++n) a.step();
  for (int n = 0; n < 4000; ++n) b.step();
  rest.bed.restore(half.bed.save());
  c.restore(b.save());
  for (int n = 0; n < 4000; ++n) c.step();
  EXPECT_EQ(dem::test::hash(straight.bed), dem::test::hash(rest.bed));
  EXPECT_EQ(a.servo(0).travel, c.servo(0).travel);
  EXPECT_EQ(a.servo(0).integral, c.servo(0).integral);
  Simulation without(&rest.bed, nullptr, {}, {{rest.plate, [at = rest.start](double) { return at; }}},
                     {.soil_step = dt});
  EXPECT_THROW(without.restore(b.save()), std::invalid_argument);
}

/// Pressed while it is dragged: the given path and the servo add up.
TEST(Servo, ShiftsAGivenPath) {
  Press p(1.0);
  Simulation s(&p.bed, nullptr, {},
               {{p.plate,
                 [at = p.start](double t) {
                   return dem::Pose{at.position + dem::Vec3{0.2 * t, 0, 0}, {}};
                 },
                 pressing(10, 0.1, 0.4)}},
               {.soil_step = dt});
  for (int n = 0; n < 500; ++n) s.step();
  const dem::Vec3 moved = s.surface_pose(p.plate).position - p.start.position;
  EXPECT_NEAR(moved.x, 0.2 * 500 * dt, 1e-12);
  EXPECT_NEAR(moved.y, -0.4 * 500 * dt, 1e-12);
}

}  // namespace
}  // namespace subsoil::coupling::test::servo
