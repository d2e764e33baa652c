#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <set>

#include "libdem/bed_engine.hpp"
#include "libdem/particles/rigid_rotation.hpp"
#include "tests/tools/dem_beds.hpp"

/// Forces of users on spheres: the discrete motion in closed form, their work, what they act on, restarts, faults.
namespace subsoil::dem::test::sphere_forces {
namespace {

constexpr double kRadius = 5e-3, kDensity = 1500;  // m, kg/m3
const double kMass = kDensity * sphere_volume(kRadius);

/// A bed of one sphere without gravity.
Bed one_sphere(const Vec3& x, const Vec3& v, const Vec3& w = {}, Precision precision = Precision::doubles) {
  BedOptions options = quiet();
  options.precision = precision;
  Bed bed(table(grains()), options);
  const SphereSpec s{x, v, w, kRadius, kDensity, 0};
  bed.add(std::span(&s, 1));
  return bed;
}
ClumpShape dumbbell() {
  return clump_shape("dumbbell", {{{-kRadius, 0, 0}, kRadius}, {{kRadius, 0, 0}, kRadius}}, kDensity);
}

struct Spring {  // N/m along each axis
  Vec3 k;
  Wrench operator()(const SphereAt& s) const {
    return {{-k.x * s.position.x, -k.y * s.position.y, -k.z * s.position.z}, {}};
  }
  double stored(const Vec3& x) const { return 0.5 * (k.x * x.x * x.x + k.y * x.y * x.y + k.z * x.z * x.z); }
};
struct Magnet {  // q B, N s/m
  Vec3 field;
  Wrench operator()(const SphereAt& s) const { return {cross(s.velocity, field), {}}; }
};
struct Drag {  // N s/m, N m s
  double c = 0, turning = 0;
  Wrench operator()(const SphereAt& s) const { return {-c * s.velocity, -turning * s.angular_velocity}; }
};
struct Weight {
  Vec3 g;
  Wrench operator()(const SphereAt& s) const { return {s.mass * g, {}}; }
};

/// Leapfrog in a field -k x has the motion x_n = a cos(n q), sin(q/2) = (k/m)^(1/2) dt/2, to rounding: 2,000 steps of
/// some roundings of a. Its work is the difference of the potential.
TEST(SphereForces, AHarmonicFieldIsInClosedForm) {
  const Spring field{{0.8, 0.3, 0.5}};
  const Vec3 start{0.2, -0.1, 0.3};
  Bed bed = one_sphere(start, {});
  bed.add_force("field", field);
  const double dt = 2e-3;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 x = bed.spheres()[0].x;
    bed.step(dt, {.energy = true});
    for (int d = 0; d < 3; ++d) {
      const double q = 2 * std::asin(0.5 * dt * std::sqrt(field.k[d] / kMass));
      ASSERT_NEAR(x[d], start[d] * std::cos(n * q), 1e-11) << n;
    }
    ASSERT_NEAR(bed.energy().force_work, field.stored(start) - field.stored(x), 1e-13) << n;
  }
}

/// With the velocity at t_n, v_n = (v_{n-1/2} + v_{n+1/2})/2, each step turns the velocity by q, tan(q/2) = q_B B dt/2m
/// (Boris), and does not work: |v_n| is that of the start, and the path a circle of radius dt v/sin(q). Rounding:
/// 20,000 steps that each leave some roundings of the velocity.
TEST(SphereForces, AMagneticFieldMakesNoEnergy) {
  const double dt = 1e-3, turn = 0.4, v = 2;  // rad per step
  const Magnet magnet{{0, 0, 2 * kMass / dt * std::tan(0.5 * turn)}};
  const double circle = dt * v / std::sin(turn);
  Bed bed = one_sphere({0, circle, 0}, {v, 0, 0});  // v x B is -y: the centre is the origin
  bed.add_force("magnet", magnet);
  double kinetic = 0;
  for (int n = 0; n < 20000; ++n) {
    ASSERT_NEAR(norm(bed.spheres()[0].x), circle, 1e-10 * circle) << n;
    bed.step(dt, {.energy = true});
    if (n == 1) kinetic = bed.energy().kinetic;
    if (n > 1) {
      ASSERT_NEAR(bed.energy().kinetic, kinetic, 1e-10 * kinetic) << n;
    }
    ASSERT_NEAR(bed.energy().force_work, 0, 1e-10 * kinetic) << n;
  }
}

/// Drag at the velocity at t_n: v_{n+1/2} = g' + (v_{n-1/2} - g') (1 - a)/(1 + a), a = c dt/2m, g' the speed at which
/// the sphere falls at last; stable where explicit drag is not resolved. The torque likewise.
TEST(SphereForces, StokesDragIsInClosedForm) {
  for (const double a : {1e-3, 0.1, 0.5}) {
    const double dt = 1e-4, c = 2 * a * kMass / dt, inertia = 0.4 * kMass * kRadius * kRadius;
    Bed bed = one_sphere({0, 0, 0}, {1, 0, 0}, {0, 0, 30});
    bed.set_gravity({0, -9.81, 0});
    bed.add_force("drag", Drag{c, c * inertia / kMass});
    const double last = 9.81 * kMass / c, factor = (1 - a) / (1 + a);
    // The first kick is half a step, at the velocity of the start.
    double vx = 1 - a, vy = -0.5 * 9.81 * dt, w = 30 * (1 - a);
    for (int n = 0; n < 200; ++n) {
      bed.step(dt, {.energy = true});
      const Sphere& s = bed.spheres()[0];
      ASSERT_NEAR(s.v.x, vx, 1e-13) << a << ' ' << n;
      ASSERT_NEAR(s.v.y, vy, 1e-13) << a << ' ' << n;
      ASSERT_NEAR(s.w.z, w, 1e-11) << a << ' ' << n;
      vx *= factor, vy = -last + (vy + last) * factor, w *= factor;
    }
  }
}

/// The end of a fall through a fluid against v_T (1 - exp(-t/tau)): a fourth of the error at half the step.
TEST(SphereForces, DragIsOfSecondOrder) {
  const double tau = 0.05, end = 0.1;
  const auto fallen = [&](int steps) {
    Bed bed = one_sphere({}, {});
    bed.set_gravity({0, -9.81, 0});
    bed.add_force("drag", Drag{kMass / tau, 0});
    for (int n = 0; n < steps; ++n) bed.step(end / steps);
    return bed.spheres()[0].x.y;
  };
  const double exact = -9.81 * tau * (end - tau * (1 - std::exp(-end / tau)));
  const double coarse = fallen(50) - exact, fine = fallen(100) - exact;
  EXPECT_NEAR(coarse / fine, 4, 0.1);
  EXPECT_LT(std::abs(fine), 1e-4 * std::abs(exact));
}

/// Beds with loose and fixed spheres and clumps in a bin.
Bed heap(int threads, Precision precision, const Vec3& gravity, int layers = 5) {
  BedOptions options = quiet(gravity, threads);
  options.precision = precision, options.skin = 1e-3;  // several rebuilds
  Bed bed(table(grains(1e4)), options);
  const int shape = bed.add_shape(dumbbell());
  Dice dice(11);
  const auto spheres = loose_lattice({0.002, 0.004, 0.002}, 12, layers, 12, 4.1 * kRadius, kRadius, 0.2, 0.3, dice);
  std::vector<SphereSpec> loose;
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const SphereSpec& s = spheres[k];
    if (k % 5 == 0) {
      const ClumpSpec c{shape, s.position, Quaternion::from_rotation_vector(dice.ball(2)), s.velocity, {}, 0};
      bed.add(std::span(&c, 1));
    } else {
      loose.push_back(k % 17 == 1 ? fixed(s) : s);
      if (k % 17 == 1) loose.back().velocity = loose.back().angular_velocity = {};
    }
  }
  bed.add(loose);
  add_bin(bed, 0.25, 0.25);
  return bed;
}

/// m g as a force of a user is gravity, on spheres and on clumps, and its work is the potential's difference. Both add
/// in another order: roundings of 1e-16, of which each of some five collisions makes ten times as much.
TEST(SphereForces, AWeightIsGravity) {
  const Vec3 g{1, -9.81, 0.5};
  Bed with = heap(1, Precision::doubles, g), without = heap(1, Precision::doubles, {});
  without.add_force("weight", Weight{g});
  double start_gravity = 0, start_work = 0;
  for (int n = 0; n < 600; ++n) {
    with.step(1e-4, {.energy = true}), without.step(1e-4, {.energy = true});
    if (n == 0) start_gravity = with.energy().gravity, start_work = without.energy().force_work;
  }
  ASSERT_GT(with.rebuilds(), 3);
  const BedEnergy &a = with.energy(), &b = without.energy();
  ASSERT_GT(a.lost.total(), 0.1 * a.kinetic) << "there must be collisions";
  for (const Sphere& s : with.spheres()) {
    const Sphere& other = sphere(without, s.id);
    EXPECT_LT(norm(s.x - other.x), 1e-9 * kRadius);
    EXPECT_LT(norm(s.v - other.v), 1e-8);
  }
  const double work = b.force_work - start_work;
  EXPECT_NEAR(start_gravity - a.gravity, work, 1e-9 * work);
  EXPECT_NEAR(a.kinetic, b.kinetic, 1e-9 * a.kinetic);
  EXPECT_NEAR(a.rotational, b.rotational, 1e-7 * a.rotational);
  EXPECT_GT(work, 0);
}

/// Energy closes as it does under gravity: the gap is of contacts that begin between two steps (tests/properties,
/// 1 % of what was turned over).
TEST(SphereForces, EnergyCloses) {
  Bed bed = heap(1, Precision::doubles, {0, -9.81, 0});
  bed.add_force("drag", Drag{0.02, 1e-7}), bed.add_force("spring", Spring{{0.5, 0, 0.5}});
  BedEnergy start;
  for (int n = 0; n < 1500; ++n) {
    bed.step(1e-4, {.energy = true});
    if (n == 1) start = bed.energy();
  }
  const BedEnergy& end = bed.energy();
  const double gap = end.total() - end.work() - (start.total() - start.work());
  EXPECT_LT(std::abs(gap), 0.01 * (end.lost.total() + std::abs(end.force_work)));
  EXPECT_GT(std::abs(end.force_work), 0.1 * end.lost.total()) << "the forces must count";
}

/// A dumbbell that turns about an axis across it, its members dragged: the moment is -c d^2/2 w, d the distance of the
/// centres, so that L_{n+1/2} = L_{n-1/2} (1 - a)/(1 + a), a = c d^2 dt/4I. Its turning leaves the axis where it is.
TEST(SphereForces, MembersBrakeTheirClump) {
  const ClumpShape shape = dumbbell();
  const double dt = 1e-4, a = 0.2, inertia = shape.inertia.z, apart = 2 * kRadius;
  ASSERT_NEAR(shape.inertia.y, inertia, 1e-12 * inertia);
  const double c = 4 * a * inertia / (apart * apart * dt), linear = c * dt / shape.mass;  // 2 c dt/2M
  Bed bed(table(grains()), quiet());
  const ClumpSpec spec{bed.add_shape(shape), {}, {}, {0, 0, 1}, {0, 0, 20}, 0};
  bed.add(std::span(&spec, 1));
  bed.add_force("drag", Drag{c, 0});
  double l = inertia * 20 * (1 - a), v = 1 - linear;
  BedEnergy start;
  for (int n = 0; n < 40; ++n) {
    bed.step(dt, {.energy = true});
    const Clump& clump = bed.clumps()[0];
    ASSERT_NEAR(clump.angular_momentum.z, l, 1e-12 * inertia * 20) << n;
    ASSERT_NEAR(clump.velocity.z, v, 1e-12) << n;
    if (n == 1) start = bed.energy();
    l *= (1 - a) / (1 + a), v *= (1 - linear) / (1 + linear);
  }
  // Work along chords against that of angles: a share (w dt)^2/6 of what the rotation loses.
  const BedEnergy& end = bed.energy();
  EXPECT_NEAR(end.total() - end.work(), start.total() - start.work(), 1e-5 * (start.kinetic + start.rotational));
  EXPECT_LT(end.rotational, 1e-3 * start.rotational);
}

/// Free spheres and members are asked for, fixed ones are not; the state that results show has the force.
TEST(SphereForces, ActOnWhatMoves) {
  Bed bed(table(grains()), quiet());
  std::vector<SphereSpec> spheres{{{0, 1, 0}, {}, {}, kRadius, kDensity, 0}, {{1, 1, 0}, {}, {}, kRadius, kDensity, 0}};
  spheres[1] = fixed(spheres[1]);
  spheres[1].velocity = {0.5, 0, 0};
  bed.add(spheres);
  const ClumpSpec clump{bed.add_shape(dumbbell()), {2, 1, 0}, {}, {}, {}, 0};
  bed.add(std::span(&clump, 1));
  std::set<std::uint32_t> asked;
  bed.add_force("push", [&](const SphereAt& s) {  // one thread
    asked.insert(s.id);
    return Wrench{{1e-3 * (1 + s.id), 0, 0}, {0, 0, 1e-6}};
  });
  const Snapshot seen = observe(bed, 1e-5);
  EXPECT_EQ(asked, (std::set<std::uint32_t>{0, 2, 3}));
  EXPECT_EQ(seen.force[0], (Vec3{1e-3, 0, 0}));
  EXPECT_EQ(seen.force[1], Vec3{});
  EXPECT_EQ(seen.force[3], (Vec3{4e-3, 0, 0}));
  EXPECT_EQ(seen.torque[2], (Vec3{0, 0, 1e-6}));
  EXPECT_EQ(sphere(bed, 1).v, (Vec3{0.5, 0, 0}));
  EXPECT_TRUE(bed.fixed_spheres()[0].force == Vec3{});
}

/// A force is asked for places in the cell.
TEST(SphereForces, FindSpheresInThePeriodicCell) {
  BedOptions options = quiet();
  options.periodic = {.low = {0, 0, 0}, .length = {1, 0, 0}};
  options.skin = 0.05;  // no new lists while the sphere is beyond the side
  Bed bed(table(grains()), options);
  const SphereSpec s{{0.99, 0.5, 0}, {1, 0, 0}, {}, kRadius, kDensity, 0};
  bed.add(std::span(&s, 1));
  double last = 0;
  bed.add_force("look", [&](const SphereAt& at) { return last = at.position.x, Wrench{}; });
  for (int n = 0; n < 21; ++n) bed.step(1e-3);
  EXPECT_GT(bed.spheres()[0].x.x, 1);
  EXPECT_NEAR(last, 0.01, 1e-12);
}

struct Numbers {
  std::uint64_t spheres;
  double work, kinetic;
  bool operator==(const Numbers&) const = default;
};
Numbers after(Bed& bed, int steps) {
  for (int n = 0; n < steps; ++n) bed.step(1e-4, {.energy = n % 9 == 0 || n + 1 == steps});
  return {hash(bed), bed.energy().force_work, bed.energy().kinetic};
}

/// Both precisions, on any number of threads.
TEST(SphereForces, SameBitsOnAnyNumberOfThreads) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    const auto run = [&](int threads) {
      Bed bed = heap(threads, precision, {0, -9.81, 0}, 8);
      bed.add_force("drag", Drag{0.02, 1e-7}), bed.add_force("magnet", Magnet{{0.01, 0.02, 0}});
      return after(bed, 120);
    };
    const Numbers one = run(1);
    for (const int threads : {2, 3}) EXPECT_EQ(run(threads), one) << threads;
  }
}

/// Pulses that grow with the steps taken: a state of its own.
struct Pulses {
  long steps = 0;
  double strength = 0;
  void begin_step(double time) { ++steps, strength = 1e-4 * static_cast<double>(steps % 7) * (1 + time); }
  Wrench operator()(const SphereAt&) const { return {{strength, 0, 0}, {}}; }
  void archive(Archive& a) { a("steps", steps); }
};
Bed pulsed() {
  Bed bed = heap(1, Precision::doubles, {0, -9.81, 0});
  bed.add_force("pulses", Pulses{}), bed.add_force("drag", Drag{0.02, 0});
  return bed;
}

TEST(SphereForces, ARestartContinuesWithTheSameBits) {
  Bed whole = pulsed();
  after(whole, 100);
  const Bed::State state = whole.save();
  Bed::Checkpoint checkpoint;
  whole.save(checkpoint);
  const Numbers end = after(whole, 200);
  EXPECT_EQ(whole.force("pulses").as<Pulses>().steps, 300);
  EXPECT_THROW(whole.force("pulses").as<Drag>(), std::invalid_argument);

  Bed other = pulsed();
  other.restore(state);
  EXPECT_EQ(other.force("pulses").as<Pulses>().steps, 100);
  EXPECT_EQ(after(other, 200), end);
  whole.restore(checkpoint);
  EXPECT_EQ(after(whole, 200), end) << "of a checkpoint";
  EXPECT_EQ(checkpoint.state().parts, state.parts);

  Bed lacking = heap(1, Precision::doubles, {0, -9.81, 0});
  lacking.add_force("drag", Drag{0.02, 0});
  try {
    lacking.restore(state);
    ADD_FAILURE() << "a restart without one of the forces is another motion";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'pulses'"), std::string::npos) << error.what();
  }
}

/// A state from before a force was added: the force begins there.
TEST(SphereForces, BeginAtARestartWithoutThem) {
  Bed before = heap(1, Precision::doubles, {0, -9.81, 0});
  after(before, 50);
  Bed bed = pulsed();
  bed.restore(before.save());
  EXPECT_EQ(bed.force("pulses").as<Pulses>().steps, 0);
  bed.step(1e-4, {.energy = true});
  EXPECT_EQ(bed.force("pulses").as<Pulses>().steps, 1);
  EXPECT_LT(std::abs(bed.energy().force_work), 1e-3);
}

template <class Force>
BedFault fault_of(Bed bed, const Force& force, double dt = 1e-4) {
  bed.add_force("mine", force);
  try {
    for (int n = 0; n < 3; ++n) bed.step(dt);
  } catch (const BedFault& fault) {
    return fault;
  }
  return BedFault({.kind = BedFault::Kind::speed, .time = -1}, "no fault");
}

TEST(SphereForces, AForceThatIsNoNumberStopsTheRun) {
  const auto broken = [](const SphereAt& s) {
    return Wrench{{s.id > 100 ? std::numeric_limits<double>::quiet_NaN() : 0, 0, 0}, {}};
  };
  for (const int threads : {1, 3}) {
    const BedFault fault = fault_of(heap(threads, Precision::doubles, {}), broken);
    EXPECT_EQ(fault.facts.kind, BedFault::Kind::force);
    EXPECT_GT(fault.facts.sphere, 100u);
    EXPECT_NE(std::string(fault.what()).find("'mine'"), std::string::npos) << fault.what();
    EXPECT_NE(std::string(fault.what()).find("nan"), std::string::npos) << fault.what();
  }
  // Of all that fail that of the lowest number is reported, whoever meets it first: sphere 101 or the next that moves.
  const auto lowest = [&](int threads) { return fault_of(heap(threads, Precision::doubles, {}), broken).facts.sphere; };
  EXPECT_EQ(lowest(1), lowest(3));
}

/// (dt/2) c/m = 1.5: each substitution is farther off by that factor.
TEST(SphereForces, AStepThatDoesNotResolveThemStopsTheRun) {
  const double dt = 1e-4;
  for (const bool clump : {false, true}) {
    Bed bed(table(grains()), quiet());
    const SphereSpec s{{}, {1, 0, 0}, {}, kRadius, kDensity, 0};
    const ClumpSpec c{bed.add_shape(dumbbell()), {}, {}, {1, 0, 0}, {}, 0};
    clump ? bed.add(std::span(&c, 1)) : bed.add(std::span(&s, 1));
    const BedFault fault = fault_of(std::move(bed), Drag{2 * 1.5 * kMass / dt, 0}, dt);
    EXPECT_EQ(fault.facts.kind, BedFault::Kind::force) << fault.what();
    EXPECT_NEAR(fault.facts.value, 1.5, clump ? 0.2 : 1e-6);  // the dumbbell's mass counts members' overlap once
    EXPECT_NE(std::string(fault.what()).find("shorten the step"), std::string::npos) << fault.what();
  }
}

TEST(SphereForces, AnExceptionOfTheUserPassesAsItIs) {
  struct Mine {};
  Bed bed = heap(3, Precision::doubles, {});
  bed.add_force("mine", [](const SphereAt& s) -> Wrench { return s.id == 77 ? throw Mine{} : Wrench{}; });
  EXPECT_THROW(bed.step(1e-4), Mine);
}

struct NoEngine : BedEngine {
  const char* name() const override { return "none"; }
  void begin(const Bed::State&, const BedOptions&, std::span<const Boundary>) override {}
  EngineSums step(const EngineStep&, std::span<Boundary>) override { return {}; }
  Bed::State collect(bool) override { return {}; }
};

TEST(SphereForces, AreRefusedWhereTheyCannotAct) {
  const auto none = [](const SphereAt&) { return Wrench{}; };
  Bed bed = one_sphere({}, {});
  EXPECT_THROW(bed.add_force("", none), std::invalid_argument);
  EXPECT_THROW(bed.add_force("a/b", none), std::invalid_argument);
  EXPECT_THROW(bed.force("drag"), std::invalid_argument);
  bed.add_force("drag", none);
  EXPECT_THROW(bed.add_force("drag", none), std::invalid_argument);
  EXPECT_THROW(bed.set_active(ActiveRule{.within = 0.1, .below = 1}), std::invalid_argument);
  EXPECT_THROW(bed.step_by(std::make_unique<NoEngine>()), std::invalid_argument);
  Bed sleepy = one_sphere({}, {});
  sleepy.set_active(ActiveRule{.within = 0.1, .below = 1});
  EXPECT_THROW(sleepy.add_force("drag", none), std::invalid_argument);
  Bed stepped = one_sphere({}, {});
  stepped.step_by(std::make_unique<NoEngine>());
  EXPECT_THROW(stepped.add_force("drag", none), std::invalid_argument);
}

}  // namespace
}  // namespace subsoil::dem::test::sphere_forces
