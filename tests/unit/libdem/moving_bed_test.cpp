#include "libdem/packing/moving_bed.hpp"

#include <gtest/gtest.h>

#include <map>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/packing/fibres.hpp"
#include "libdem/packing/settle.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/message_of.hpp"

/// A window of a long bed: blocks of one periodic packing join without a sign of it, and what comes and goes is booked.
namespace subsoil::dem::test::moving_bed {
namespace {

using subsoil::test::message_of;

constexpr double kPeriod = 0.18, kDeep = 0.07, kWide = 0.13, kStep = 4e-5;
const Law kLaw = grains(5e4, 0.4, 0.5, 0.05);

BedOptions options(int threads = 1, Precision precision = Precision::doubles) {
  BedOptions o = quiet({0, -9.81, 0}, threads);
  o.precision = precision, o.sample_every = 1;
  o.periodic = {{0, 0, 0}, {0, 0, kWide}};
  return o;
}

/// Straw of 128 mm, softer than the soil and held together by bonds of its own law, which soil has too and never uses.
const Law kStraw = [] {
  Linear law = grains(5e4, 0.4, 0.5, 0.05);
  law.bond = {.kind = Bond::Kind::fibre, .modulus = 2e6, .tensile = 1e5, .shear = 1e5, .damping = 0.1};
  return Law(law);
}();
const FibreShape kStalk{.length = 0.128, .diameter = 0.016, .of = {.density = 300, .material = 0}};

/// Lies on the soil along x, across the ends of the period too.
struct StrawCover final : BedCover {
  Laid lay(Bed& bed, std::uint32_t first) override {
    FibreField field;
    field.shape = kStalk, field.count = 10;
    field.orientation = FibreField::Orientation::along, field.scatter = 0.3;
    field.region = {{0, 0.1, 0}, {kPeriod, 0.13, kWide}};
    field.cell = bed.options().periodic, field.piles = true;
    bed.insert(fibres_at(kStalk, place_fibres(field), first));
    return {.first = first, .height = 0.3, .left_out = 0};
  }
  void laid(const Laid&) override {}
};

ClumpShape ballast() {
  return clump_shape("ballast", {{{0, 0, 0}, 8e-3}, {{9e-3, 0, 0}, 7e-3}, {{3e-3, 8e-3, 2e-3}, 6e-3}}, 1800);
}

/// Rained into a box without ends, on a floor. @param clumps share of the grains
PeriodicBlock settled(const Law& law, BedCover* cover, double clumps = 0) {
  BedOptions o = options();
  o.periodic.length.x = kPeriod;
  Bed bed(table(law), o);
  add_plane(bed, {0, 0, 0}, {0, 1, 0});
  RandomFill fill;
  if (clumps > 0) fill.clumps = {clump_part(bed, bed.add_shape(ballast()), clumps)};
  fill.region = {{0, 0, 0}, {kPeriod, 0.3, kWide}};
  fill.radius = UniformRadius{0.008, 0.011};
  fill.of = {.density = 1800, .material = 0};
  fill.depth = kDeep;
  SettlePlan plan;
  plan.step = kStep, plan.until_speed = 2e-4, plan.staged = true;
  plan.cover = cover;
  fill_at_random(bed, table(law), fill, plan);
  const int floor = 0;
  return block_of(bed, std::span(&floor, 1));
}
/// Made once.
const PeriodicBlock& block() {
  static const PeriodicBlock made = settled(kLaw, nullptr);
  return made;
}
const PeriodicBlock& block_with_straw() {
  static const PeriodicBlock made = [] {
    StrawCover straw;
    return settled(kStraw, &straw);
  }();
  return made;
}

const PeriodicBlock& block_with_clumps() {
  static const PeriodicBlock made = settled(kLaw, nullptr, 0.5);
  return made;
}

struct Window {
  Bed bed;
  MovingBed moving;
  Motion tool{-1, {}, {}, {}};
  BedEnergy start;

  void step(int n, bool energy = false) {
    for (int k = 0; k < n; ++k) {
      if (tool.boundary >= 0) tool.place(bed);
      bed.step(kStep, {.energy = energy, .snapshot = nullptr});
    }
  }
  /// Steps that go on by a block where the tool has travelled one.
  void pass(int n, bool energy = false) {
    for (int k = 0; k < n; ++k) {
      const double gone = std::abs(tool.velocity.x) * bed.time();
      if (gone >= moving.way() + kPeriod) moving.advance(bed, {});
      step(1, energy);
    }
  }
  double closure() const {
    const BedEnergy& e = bed.energy();
    return e.total() - e.boundary_work - (start.total() - start.boundary_work);
  }
};

/// Spheres held at both ends do not load it, as they do not load a container's walls.
void add_floor(Bed& bed) { bed.boundary(add_plane(bed, {0, 0, 0}, {0, 1, 0})).meets_fixed = false; }

Window window_of(const PeriodicBlock& block, const Law& law, int steps, const BedOptions& o, int direction, double rear,
                 double step) {
  Window w{Bed(table(law), o),
           MovingBed(block, {.rear = rear, .step = step, .steps = steps, .direction = direction}),
           {},
           {}};
  for (const ClumpShape& shape : block.shapes) w.bed.add_shape(shape);
  add_floor(w.bed);
  w.moving.fill(w.bed);
  return w;
}

Window window(int steps, const BedOptions& o = options(), int direction = 1, double rear = 0.5, double step = kPeriod) {
  return window_of(block(), kLaw, steps, o, direction, rear, step);
}

/// A blade from above into the soil and along it, that starts in the second block.
void add_tool(Window& w, double depth, double speed) {
  Boundary b;
  b.shape = MeshSurface(box_mesh({0.012, 0.2, 0.03}));
  const int direction = w.moving.plan().direction;
  w.tool = {w.bed.add(std::move(b)),
            {{w.moving.rear() + direction * 1.5 * kPeriod, kDeep - depth + 0.1, 0.5 * kWide}, {}},
            {direction * speed, 0, 0},
            {}};
  w.tool.place(w.bed);
  const Boundary& there = w.bed.boundary(w.tool.boundary);
  const Vec3 low = there.pose.position - Vec3{0.006, 0.1, 0.015}, high = there.pose.position + Vec3{0.006, 0.1, 0.015};
  w.bed.remove_if([&](const Sphere& s) {
    Vec3 out;
    for (int d = 0; d < 3; ++d) out[d] = std::max({0.0, low[d] - s.x[d], s.x[d] - high[d]});
    return norm(out) < s.r;
  });
}

double free_mass(const Bed& bed) {
  double sum = 0;
  for (const Sphere& s : bed.spheres()) sum += is_fixed(s) ? 0 : s.m;
  return sum;
}
std::size_t free_count(const Bed& bed) {
  std::size_t sum = 0;
  for (const Sphere& s : bed.spheres()) sum += is_fixed(s) ? 0 : 1;
  return sum;
}

/// Forces between spheres by their numbers.
std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> forces(Bed& bed) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> out;
  for (const ContactRecord& c : bed.contacts())
    if (!c.at_surface) out[{std::min(c.i, c.j), std::max(c.i, c.j)}] = c.i < c.j ? c.force : -c.force;
  return out;
}

/// Largest force of a contact, and largest change of one that is in both.
struct Change {
  double largest = 0, change = 0;
  std::size_t both = 0;
};
Change change(const auto& before, const auto& after) {
  Change out;
  for (const auto& [pair, f] : before) {
    out.largest = std::max(out.largest, norm(f));
    if (const auto there = after.find(pair); there != after.end())
      out.change = std::max(out.change, norm(there->second - f)), ++out.both;
  }
  return out;
}

/// The periodic bed itself, with the numbers and contacts that its block has.
Bed periodic_bed() {
  BedOptions o = options();
  o.periodic.length.x = kPeriod;
  Bed bed(table(kLaw), o);
  add_plane(bed, {0, 0, 0}, {0, 1, 0});
  bed.insert(block().state);
  return bed;
}

Archive kept(MovingBed moving) {
  Archive out;
  moving.archive(out);
  return out;
}

/// The window as a file keeps it.
Window again(const Window& of, const BedOptions& o) {
  Window out{Bed(table(kLaw), o), MovingBed(of.moving.block(), of.moving.plan()), {}, {}};
  for (const ClumpShape& shape : of.bed.clump_shapes()) out.bed.add_shape(shape);
  add_floor(out.bed);
  Boundary tool;
  tool.shape = of.bed.boundary(of.tool.boundary).shape;
  out.bed.add(std::move(tool));
  out.tool = of.tool;
  out.bed.restore(of.bed.save());
  Archive moving = kept(of.moving).to_read();
  out.moving.archive(moving);
  moving.end();
  return out;
}

/// What its copies do is what the periodic bed does when it is stepped on: it relaxes a little after it was stopped. At
/// the ends of the window, where spheres are held, and where they are let go, forces change by no more than they do
/// there; when the window goes on, by what the dashpots of contacts pull whose spheres are held or let go.
TEST(MovingBed, BlocksJoinWithoutASign) {
  Bed itself = periodic_bed();
  const auto at_first = forces(itself);
  double own_level = 0;
  for (int k = 0; k < 1600; ++k) {
    itself.step(kStep, {.energy = true, .snapshot = nullptr});
    own_level = std::max(own_level, itself.energy().kinetic + itself.energy().rotational);
  }
  const Change own = change(at_first, forces(itself));
  ASSERT_GT(own.both, block().size());
  EXPECT_LT(own.change, 0.01 * own.largest);
  for (const int direction : {1, -1}) {
    Window w = window(3, options(), direction);
    const std::size_t count = w.bed.spheres().size();
    EXPECT_EQ(free_count(w.bed), 3 * block().size());
    auto before = forces(w.bed);
    w.step(1, true);
    w.start = w.bed.energy();
    const double stored = w.bed.energy().stored;  // and pairs with spheres held behind
    EXPECT_GT(stored, 3 * block().energy());
    EXPECT_LT(stored, 3.2 * block().energy());
    double kinetic = 0, apart = 0, joint = 0;
    for (int k = 0; k < 4; ++k) {
      for (int n = 0; n < 400; ++n) {
        w.step(1, true);
        kinetic = std::max(kinetic, w.bed.energy().kinetic + w.bed.energy().rotational);
      }
      const auto late = forces(w.bed);
      w.moving.advance(w.bed, {});
      const auto after = forces(w.bed);
      const Change joined = change(late, after);
      EXPECT_GT(joined.both, 2 * block().size());
      joint = std::max(joint, joined.change);
      apart = std::max(apart, change(before, late).change);
      before = after;
      w.step(1, true);
      EXPECT_NEAR(w.bed.energy().stored, stored, 1e-3 * stored);
      EXPECT_NEAR(w.closure(), 0, 1e-6 * stored) << k;
      EXPECT_EQ(free_count(w.bed), 3 * block().size());
      EXPECT_NEAR(static_cast<double>(w.bed.spheres().size()), static_cast<double>(count), 3.0);
    }
    EXPECT_LT(kinetic, 1.1 * 3 * own_level);
    EXPECT_LT(apart, 2 * own.change);  // the largest of three copies in four windows, that of one bed in one
    EXPECT_LT(joint, own.change);
    EXPECT_LT(joint, 1e-3 * own.largest);
    EXPECT_EQ(w.moving.entered().spheres, 4 * block().size());
    EXPECT_EQ(w.moving.left().spheres, 4 * block().size());
    EXPECT_EQ(w.moving.pushed_out(), 0u);
    EXPECT_NEAR(w.moving.front() - w.moving.rear(), direction * 3 * kPeriod, 1e-12);
    EXPECT_NEAR(w.moving.left().stored, w.moving.entered().stored, 1e-3 * w.moving.entered().stored);
  }
}

/// The window goes on by less than a period, or by more, and is shorter or longer than one: the same soil comes and
/// goes.
TEST(MovingBed, StepsNeedNotBePeriods) {
  for (const double step : {0.25 * kPeriod, 0.4 * kPeriod, 1.3 * kPeriod})
    for (const int direction : {1, -1}) {
      Window w = window(2, options(), direction, 0.5, step);
      w.step(1, true);
      w.start = w.bed.energy();
      const std::size_t count = free_count(w.bed);
      double mass = free_mass(w.bed), level = 0;
      for (int k = 0; k < 12; ++k) {
        w.moving.advance(w.bed, {});
        w.step(50, true);
        level = std::max(level, w.bed.energy().kinetic);
        EXPECT_EQ(free_count(w.bed) + w.moving.left().spheres, count + w.moving.entered().spheres);
        EXPECT_NEAR(free_mass(w.bed) + w.moving.left().mass, mass + w.moving.entered().mass, 1e-12 * mass);
        // Contacts begin and end between two steps: an error of first order in the step, 3.1e-10 J at most here
        // and 1.5e-10 at half the step.
        EXPECT_NEAR(w.closure(), 0, 2e-6 * block().energy()) << step << k;
      }
      // 12 steps are a whole number of periods but for 1.3: 15.6.
      const double periods = 12 * step / kPeriod;
      EXPECT_NEAR(static_cast<double>(w.moving.entered().spheres), periods * static_cast<double>(block().size()),
                  0.1 * static_cast<double>(block().size()));
      EXPECT_NEAR(w.moving.entered().stored, periods * block().energy(), 0.3 * block().energy());
      EXPECT_LT(level, 1e-4 * block().energy());
      std::vector<std::uint32_t> ids;
      for (const Sphere& s : w.bed.spheres()) {
        ids.push_back(s.id);
        EXPECT_LT(norm(s.x - w.moving.place_at_rest(s.id)), 1e-4);
      }
      std::sort(ids.begin(), ids.end());
      EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());
    }
}

/// Mean and its standard error, of means over stretches long enough to know nothing of each other.
struct Mean {
  std::vector<double> of_stretch;
  double sum = 0;
  int count = 0;
  void add(double x, int stretch) {
    sum += x;
    if (++count == stretch) of_stretch.push_back(sum / count), sum = 0, count = 0;
  }
  double mean() const {
    double all = 0;
    for (const double x : of_stretch) all += x / static_cast<double>(of_stretch.size());
    return all;
  }
  double error2() const {
    const double n = static_cast<double>(of_stretch.size());
    double all = 0;
    for (const double x : of_stretch) all += (x - mean()) * (x - mean());
    return all / (n * (n - 1));
  }
};

/// The long bed is made of the same blocks. So both beds are one and the same but for rounding until the ends of the
/// window have a say; impacts make roundings larger without end, so that in the end only means are alike.
TEST(MovingBed, DraftIsThatOfALongBed) {
  Window moving = window(5), still = window(8);
  add_tool(moving, 0.045, 1.2), add_tool(still, 0.045, 1.2);
  const auto draft = [](const Window& w) { return -w.bed.boundary(w.tool.boundary).wrench.force.x; };
  Mean of_moving, of_still;
  double early = 0;
  const int all = static_cast<int>(3.2 * kPeriod / (1.2 * kStep));
  for (int k = 0; k < all; ++k) {
    moving.pass(1), still.step(1);
    if (k < 300) early = std::max(early, std::abs(draft(moving) - draft(still)));
    if (k < all / 4) continue;
    of_moving.add(draft(moving), all / 40), of_still.add(draft(still), all / 40);
  }
  EXPECT_EQ(moving.moving.advanced(), 3);
  EXPECT_EQ(still.moving.advanced(), 0);
  EXPECT_LT(early, 1e-6 * of_still.mean());
  const double apart = of_moving.mean() - of_still.mean(), error = std::sqrt(of_moving.error2() + of_still.error2());
  EXPECT_GT(of_still.mean(), 10);
  EXPECT_LT(error, 0.2 * of_still.mean());
  EXPECT_LT(std::abs(apart), 3 * error);
}

TEST(MovingBed, EnergyMassAndMomentumAreBooked) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    Window w = window(4, options(1, precision));
    add_tool(w, 0.045, 2);
    w.step(1, true);
    w.bed.reset_energy_balance();
    w.step(1, true);
    w.start = w.bed.energy();
    const double mass = free_mass(w.bed);
    const std::size_t count = free_count(w.bed);
    for (int k = 0; k < 30; ++k) {
      w.pass(static_cast<int>(0.1 * kPeriod / (2 * kStep)), true);
      const CarriedSoil &in = w.moving.entered(), &out = w.moving.left();
      EXPECT_EQ(free_count(w.bed) + out.spheres, count + in.spheres);
      EXPECT_NEAR(free_mass(w.bed) + out.mass, mass + in.mass, 1e-12 * mass);
      const double work = std::abs(w.bed.energy().boundary_work);
      EXPECT_NEAR(w.closure(), 0, (precision == Precision::doubles ? 2e-3 : 4e-3) * work + 1e-5) << k;
    }
    EXPECT_EQ(w.moving.advanced(), 2);
    EXPECT_GT(norm(w.moving.left().momentum), 0);
    EXPECT_EQ(w.moving.entered().momentum, Vec3{});
    EXPECT_GT(w.moving.left().mass, 0);
  }
}

TEST(MovingBed, SameBitsOnAnyNumberOfThreadsAndAfterARestart) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    const auto at = [&](int threads) {
      Window w = window(4, options(threads, precision));
      add_tool(w, 0.045, 3);
      return w;
    };
    Window one = at(1), two = at(2), first = at(2);
    const int half = static_cast<int>(1.1 * kPeriod / (3 * kStep));
    one.pass(2 * half), two.pass(2 * half), first.pass(half);
    EXPECT_EQ(one.moving.advanced(), 2);
    EXPECT_EQ(hash(one.bed), hash(two.bed));
    EXPECT_EQ(kept(one.moving), kept(two.moving));
    Window second = again(first, options(1, precision));
    EXPECT_EQ(second.moving.advanced(), 1);
    second.pass(half);
    EXPECT_EQ(hash(one.bed), hash(second.bed));
    EXPECT_EQ(kept(one.moving), kept(second.moving));
  }
}

/// Positions are doubles in both precisions: a hundred metres away forces are the same to rounding, which is 1.4e-14 m
/// of overlaps of some 1e-5.
TEST(MovingBed, AHundredMetresAway) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    Window near = window(3, options(1, precision)), far = window(3, options(1, precision), 1, 100.5);
    near.step(300, true), far.step(300, true);
    const Change c = change(forces(near.bed), forces(far.bed));
    EXPECT_LT(c.change, (precision == Precision::doubles ? 1e-7 : 1e-5) * c.largest);
    EXPECT_NEAR(near.bed.energy().stored, far.bed.energy().stored, 1e-4 * near.bed.energy().stored);
  }
}

/// Two spheres beyond what is held ahead: one where the next block comes, one above it.
TEST(MovingBed, SpheresPushedOverTheHeldOnesAreTakenOut) {
  Window w = window(3);
  const double x = w.moving.front() + w.moving.held_length() + 0.02, m = 1800 * sphere_volume(0.01);
  const std::size_t count = free_count(w.bed);
  Bed::State two;
  two.spheres = {{{x, 0.03, 0.06}, 0.01, {}, m, {}, 1000000, 0, SphereKind::free, 0},
                 {{x, 0.2, 0.06}, 0.01, {}, m, {}, 1000001, 0, SphereKind::free, 0}};
  w.bed.insert(two);
  w.moving.advance(w.bed, {});
  EXPECT_EQ(w.moving.pushed_out(), 1u);
  EXPECT_EQ(w.moving.left().spheres, block().size() + 1);
  EXPECT_EQ(free_count(w.bed), count + 1);
  EXPECT_EQ(sphere(w.bed, 1000001).x.y, 0.2);
  EXPECT_THROW(sphere(w.bed, 1000000), std::out_of_range);
  w.step(10);
  EXPECT_LT(w.bed.max_overlap(), 0.1);
}

/// Half of the grains are clumps. They lie across the ends of the period and of the window, where they are held and
/// released as a whole; a packing of them joins as one of spheres does (StepsNeedNotBePeriods, which argues the
/// bounds).
TEST(MovingBed, ClumpsLieAcrossItsEnds) {
  const PeriodicBlock& of = block_with_clumps();
  std::size_t across = 0;
  for (const Clump& c : of.clumps)
    for (std::uint32_t m = 0; m < 3; ++m) {
      const double x = of.sphere(c.first_sphere + m).x.x - of.low;
      across += x < 0 || x >= of.length ? 1 : 0;
    }
  EXPECT_GT(across, 5u);
  for (const double step : {0.4 * kPeriod, 1.3 * kPeriod})
    for (const int direction : {1, -1}) {
      Window w = window_of(of, kLaw, 2, options(), direction, 0.5, step);
      w.step(1, true);
      w.start = w.bed.energy();
      const std::size_t count = free_count(w.bed), clumps = w.bed.clumps().size();
      EXPECT_GT(3 * clumps, count / 2);
      const double mass = free_mass(w.bed);
      double level = 0;
      for (int k = 0; k < 10; ++k) {
        w.moving.advance(w.bed, {});
        w.step(50, true);
        level = std::max(level, w.bed.energy().kinetic + w.bed.energy().rotational);
        EXPECT_EQ(free_count(w.bed) + w.moving.left().spheres, count + w.moving.entered().spheres);
        EXPECT_NEAR(free_mass(w.bed) + w.moving.left().mass, mass + w.moving.entered().mass, 1e-12 * mass);
        EXPECT_NEAR(w.closure(), 0, 2e-6 * of.energy()) << step << k;
      }
      EXPECT_NEAR(static_cast<double>(w.bed.clumps().size()), static_cast<double>(clumps),
                  0.2 * static_cast<double>(clumps));
      EXPECT_LT(level, 1e-4 * of.energy());
      for (const Sphere& s : w.bed.spheres()) {
        EXPECT_LT(norm(s.x - w.moving.place_at_rest(s.id)), 1e-4);
        EXPECT_EQ(s.kind == SphereKind::member, w.bed.clump_of(s) >= 0);
      }
    }
}

TEST(MovingBed, ClumpsUnderAToolAreBookedWithTheSameBits) {
  const auto begin = [](int threads) {
    Window w = window_of(block_with_clumps(), kLaw, 4, options(threads), 1, 0.5, kPeriod);
    add_tool(w, 0.045, 3);
    w.step(1, true);
    w.start = w.bed.energy();
    return w;
  };
  const auto momenta = [](const Bed& bed) {
    Vec3 sum;
    for (const Clump& c : bed.clumps()) sum += c.angular_momentum + c.position;
    return sum;
  };
  Window one = begin(1), two = begin(2), first = begin(2);
  const double mass = free_mass(one.bed);
  const int half = static_cast<int>(1.1 * kPeriod / (3 * kStep));
  one.pass(2 * half, true), two.pass(2 * half, true), first.pass(half, true);
  EXPECT_EQ(one.moving.advanced(), 2);
  EXPECT_GT(one.moving.left().kinetic, 0);
  EXPECT_NEAR(free_mass(one.bed) + one.moving.left().mass, mass + one.moving.entered().mass, 1e-12 * mass);
  EXPECT_NEAR(one.closure(), 0, 4e-3 * std::abs(one.bed.energy().boundary_work));
  EXPECT_EQ(hash(one.bed), hash(two.bed));
  EXPECT_EQ(momenta(one.bed), momenta(two.bed));
  EXPECT_EQ(kept(one.moving), kept(two.moving));
  Window second = again(first, options());
  second.pass(half, true);
  EXPECT_EQ(hash(one.bed), hash(second.bed));
  EXPECT_EQ(momenta(one.bed), momenta(second.bed));
}

const Law kCement = [] {
  Linear law = grains(5e4, 0.4, 0.5, 0.05);
  law.bond = {.kind = Bond::Kind::parallel, .modulus = 2e7, .tensile = 1e6, .shear = 1e6, .damping = 0.1};
  return Law(law);
}();

/// All that touch are cemented, across the joints of blocks as within them: as many bonds as in so many periods, and
/// those to the held spheres. None breaks, none forms twice, and no energy appears. The bed relaxes as one without
/// bonds does (StepsNeedNotBePeriods).
TEST(MovingBed, CementedBlocksJoin) {
  const PeriodicBlock of = settled(kCement, nullptr);
  const std::size_t bonds = of.state.bonds.size();
  EXPECT_GT(bonds, of.size());
  std::size_t across = 0;
  for (const std::int64_t periods : of.bonds_across) across += periods != 0;
  EXPECT_GT(across, 5u);
  for (const int direction : {1, -1}) {
    Window w = window_of(of, kCement, 3, options(), direction, 0.5, 0.4 * kPeriod);
    w.bed.let_bonds_form();
    w.step(1, true);
    w.start = w.bed.energy();
    const double periods = 3 * 0.4;
    const std::size_t first = w.bed.bonded_pairs().size();
    EXPECT_GT(static_cast<double>(first), 0.95 * periods * static_cast<double>(bonds));
    EXPECT_LT(static_cast<double>(first), 1.4 * periods * static_cast<double>(bonds));
    EXPECT_EQ(w.bed.bonds().formed, first);
    double level = 0;
    for (int k = 0; k < 10; ++k) {
      w.moving.advance(w.bed, {});
      w.step(50, true);
      level = std::max(level, w.bed.energy().kinetic + w.bed.energy().rotational);
      EXPECT_EQ(w.bed.bonds().broken(), 0u);
      EXPECT_NEAR(w.closure(), 0, 2e-6 * of.energy()) << k;
      const std::size_t now = w.bed.bonded_pairs().size();
      EXPECT_NEAR(static_cast<double>(now), static_cast<double>(first), 0.1 * static_cast<double>(first));
    }
    EXPECT_LT(level, 1e-4 * of.energy());
    for (const Sphere& s : w.bed.spheres()) EXPECT_LT(norm(s.x - w.moving.place_at_rest(s.id)), 1e-4);
  }
  Linear later = grains(5e4, 0.4, 0.5, 0.05);
  later.bond = {
      .kind = Bond::Kind::parallel, .modulus = 2e7, .tensile = 1e6, .shear = 1e6, .damping = 0.1, .time = 0.1};
  EXPECT_NE(message_of([&] { settled(later, nullptr); }).find("leave `bond time` out"), std::string::npos);
}

/// Stalks lie across both ends. Those that come in bring their bonds, and none breaks or is missing: as many as in so
/// many periods, and those to the fixed spheres. No energy appears.
TEST(MovingBed, FibresLieAcrossItsEnds) {
  const PeriodicBlock& straw = block_with_straw();
  const std::size_t bonds = straw.state.bonds.size(), periods = 3;
  ASSERT_EQ(bonds, 10U * 7U);
  std::size_t across = 0;
  for (const std::int64_t periods_between : straw.bonds_across) across += periods_between != 0;
  ASSERT_GT(across, 2U);
  for (const int direction : {1, -1}) {
    Window w = window_of(straw, kStraw, static_cast<int>(periods), options(), direction, 0.5, kPeriod);
    w.step(1, true);
    w.start = w.bed.energy();
    const double stored = w.start.stored;
    EXPECT_GT(stored, 0);
    double kinetic = 0;
    for (int k = 0; k < 5; ++k) {
      // Hindmost sphere in the window, or held behind it. One or two lie over the joint by what they moved at rest.
      EXPECT_NEAR(static_cast<double>(w.bed.bonded_pairs().size()), static_cast<double>(periods * bonds + across), 2);
      for (int n = 0; n < 200; ++n) {
        w.step(1, true);
        kinetic = std::max(kinetic, w.bed.energy().kinetic + w.bed.energy().rotational);
      }
      w.moving.advance(w.bed, {});
      w.step(1, true);
      EXPECT_NEAR(w.bed.energy().stored, stored, 1e-2 * stored);
      EXPECT_NEAR(w.closure(), 0, 1e-5 * stored) << k;
      EXPECT_NEAR(static_cast<double>(free_count(w.bed)), static_cast<double>(periods * straw.size()), 3);
    }
    EXPECT_LT(kinetic, 0.02 * stored);
    EXPECT_EQ(w.bed.bonds().broken(), 0U);
  }
}

/// A blade tears through it: what breaks, what leaves and what comes in is in the balance.
TEST(MovingBed, FibresThatBreakAndLeaveAreBooked) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    Window w = window_of(block_with_straw(), kStraw, 4, options(1, precision), 1, 0.5, kPeriod);
    add_tool(w, 0.045, 2);
    w.step(1, true);
    w.bed.reset_energy_balance();
    w.step(1, true);
    w.start = w.bed.energy();
    const double mass = free_mass(w.bed);
    for (int k = 0; k < 30; ++k) {
      w.pass(static_cast<int>(0.1 * kPeriod / (2 * kStep)), true);
      EXPECT_NEAR(free_mass(w.bed) + w.moving.left().mass, mass + w.moving.entered().mass, 1e-12 * mass);
      const double work = std::abs(w.bed.energy().boundary_work);
      EXPECT_NEAR(w.closure(), 0, (precision == Precision::doubles ? 2e-3 : 4e-3) * work + 1e-5) << k;
    }
    EXPECT_EQ(w.moving.advanced(), 2);
    EXPECT_GT(w.bed.bonds().broken(), 0U);
  }
}

TEST(MovingBed, FibresMoveAlikeOnAnyNumberOfThreads) {
  const auto end = [](int threads) {
    Window w = window_of(block_with_straw(), kStraw, 3, options(threads), 1, 0.5, kPeriod);
    add_tool(w, 0.045, 4);
    w.pass(static_cast<int>(1.2 * kPeriod / (4 * kStep)));
    EXPECT_EQ(w.moving.advanced(), 1);
    return hash(w.bed);
  };
  EXPECT_EQ(end(3), end(1));
}

TEST(MovingBed, FaultsAreNamed) {
  PeriodicBlock shorter = block();
  shorter.length = 0.03;
  EXPECT_NE(
      message_of([&] { MovingBed(shorter, {.rear = 0, .step = 0.2}); }).find("two diameters of the largest grain"),
      std::string::npos);
  Bed bed(table(kLaw), options());
  EXPECT_NE(message_of([&] { block_of(bed, {}); }).find("periodic along x"), std::string::npos);
  Window w = window(2);
  Bed::State twice;
  twice.spheres = {w.bed.spheres()[0]};
  EXPECT_NE(message_of([&] { w.bed.insert(twice); }).find("already"), std::string::npos);
  twice.spheres[0].id = 999999;
  twice.pairs = {{999999, 999998, {}}};
  EXPECT_NE(message_of([&] { w.bed.insert(twice); }).find("not there"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::dem::test::moving_bed
