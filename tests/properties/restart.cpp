#include <gtest/gtest.h>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

/// A run saved half way and continued in a fresh bed ends where the straight run ends, with the same bits. Without the
/// state of the lists these are built anew, so sums run in another order: rounding, amplified by collisions of some
/// hundred steps.
namespace subsoil::dem::test::restart {
namespace {

struct Scene {
  Bed bed;
  Motion tool;
};

Scene scene(const Law& law, bool with_spheres, Precision precision = Precision::doubles) {
  BedOptions options = quiet({0.4, -9.81, 0}, 1);
  options.floor_drop = -0.05;
  options.precision = precision;
  Scene s{Bed(table(law), options), {}};
  if (with_spheres) {
    Dice dice(31);
    s.bed.add(loose_lattice({0, 0, 0}, 8, 5, 8, 0.0197, 0.01, 0.2, 0.4, dice));
    const SphereSpec fallen{{1, -0.1, 0}, {0, -2, 0}, {}, 0.01, 1800, 0};
    s.bed.add(std::span(&fallen, 1));
  }
  if (with_spheres) s.bed.let_bonds_form();
  add_bin(s.bed, 0.16, 0.16);
  Boundary b;
  b.shape = MeshSurface(box_mesh({0.03, 0.05, 0.03}));
  s.tool = {s.bed.add(std::move(b)), {{0.08, 0.122, 0.08}, {}}, {0.5, -1.2, 0}, {0, 0, 3}};
  return s;
}

void advance(Scene& s, int steps) {
  for (int n = 0; n < steps; ++n) {
    s.tool.place(s.bed);
    s.bed.step(1e-5, {.energy = true, .snapshot = nullptr});
  }
}

void drop_lists(Bed::State& state) { state.parts.drop("lists"), state.parts.drop("since"); }

/// Goes on in a fresh bed from a state as a file keeps it.
Scene continued(const Law& law, Scene& from, Precision precision, bool with_lists) {
  Scene on = scene(law, false, precision);
  on.tool.place(on.bed);
  Bed::State state = from.bed.save();
  if (!with_lists) drop_lists(state);
  on.bed.restore(state);
  return on;
}

void expect_same_bits(const Scene& a, const Scene& b, const std::string& name) {
  EXPECT_EQ(hash(a.bed), hash(b.bed)) << name;
  EXPECT_EQ(a.bed.rebuilds(), b.bed.rebuilds()) << name;
  EXPECT_EQ(a.bed.bonded_pairs(), b.bed.bonded_pairs()) << name;
  EXPECT_EQ(a.bed.broken_bonds().size(), b.bed.broken_bonds().size()) << name;
  const BedEnergy &e = a.bed.energy(), &f = b.bed.energy();
  EXPECT_EQ(e.total(), f.total()) << name;
  EXPECT_EQ(e.lost.total(), f.lost.total()) << name;
  EXPECT_EQ(e.boundary_work, f.boundary_work) << name;
  EXPECT_EQ(a.bed.max_overlap(), b.bed.max_overlap()) << name;
  const Wrench &p = a.bed.boundary(5).wrench, &q = b.bed.boundary(5).wrench;
  EXPECT_TRUE(p.force == q.force && p.moment == q.moment) << name;
}

/// Saved before the first lists, between two rebuilds, and late; the bed itself must not notice that it was saved.
TEST(Restart, EndsWithTheSameBits) {
  long rebuilt = 0;
  int laws = 0;
  for (const auto& [name, law] : every_law()) {
    const Precision precision = laws++ % 3 == 0 ? Precision::mixed : Precision::doubles;
    Scene straight = scene(law, true, precision), saved = scene(law, true, precision);
    int at = 0;
    for (const int stop : {0, 137, 220}) {
      advance(straight, stop - at), advance(saved, stop - at), at = stop + 60;
      Scene on = continued(law, saved, precision, true);
      const long before = on.bed.rebuilds();
      advance(on, 60), advance(straight, 60), advance(saved, 60);
      if (stop > 0) rebuilt += on.bed.rebuilds() - before;
      expect_same_bits(straight, on, name);
      expect_same_bits(straight, saved, name);
    }
  }
  EXPECT_GT(rebuilt, laws / 4) << "lists were built in the part that was gone on with";
}

TEST(Restart, ListsThatDoNotBelongAreRefused) {
  const Law law = grains();
  Scene a = scene(law, true);
  advance(a, 50);
  const Bed::State good = a.bed.save();
  ASSERT_GT(good.parts.columns().at("lists/places").size(), 100u);
  const auto refused = [&](const std::function<void(Archive::Columns&)>& damage) {
    Bed::State state = good;
    Archive::Columns columns = good.parts.columns();
    damage(columns);
    state.parts = Archive(std::move(columns), good.parts.texts());
    Scene b = scene(law, false);
    try {
      b.bed.restore(state);
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused([](Archive::Columns&) {}));
  EXPECT_TRUE(refused([](Archive::Columns& c) { c.at("lists/spheres")[0] += 1; }));
  EXPECT_TRUE(refused([](Archive::Columns& c) { c["unknown"] = {1}; }));
  // Each number of each field is needed, and none more; which field lacks one is named.
  for (const auto& [name, column] : good.parts.columns()) {
    if (column.empty()) continue;
    EXPECT_TRUE(refused([&](Archive::Columns& c) { c.at(name).pop_back(); })) << name;
    EXPECT_TRUE(refused([&](Archive::Columns& c) { c.at(name).push_back(0); })) << name;
  }
}

/// A law of another reach makes other lists: then these are built where the spheres are.
TEST(Restart, OtherReachesAreTaken) {
  Scene a = scene(grains(), true);
  advance(a, 60);
  Scene b = scene(soil(), false);  // attracts over a distance
  b.tool.place(b.bed);
  b.bed.restore(a.bed.save());
  for (std::uint32_t id = 0; id < 320; ++id) {
    EXPECT_EQ(sphere(a.bed, id).x, sphere(b.bed, id).x);
    EXPECT_EQ(sphere(a.bed, id).v, sphere(b.bed, id).v);
  }
  const long before = b.bed.rebuilds();
  advance(b, 20);
  EXPECT_GT(b.bed.rebuilds(), before);
}

TEST(Restart, EndsWhereTheStraightRunEnds) {
  for (const auto& [name, law] : every_law()) {
    Scene straight = scene(law, true), first = scene(law, true);
    advance(straight, 400);
    advance(first, 200);
    Scene second = continued(law, first, Precision::doubles, false);
    EXPECT_EQ(second.bed.time(), first.bed.time());
    EXPECT_EQ(second.bed.steps(), 200);
    EXPECT_EQ(second.bed.bonded_pairs(), first.bed.bonded_pairs()) << name;
    const std::size_t broken_before = second.bed.bonds().broken();
    advance(second, 200);
    if (second.bed.has_bonding_laws()) {
      EXPECT_GT(broken_before, 0u) << name;  // saved in the middle of breaking
      EXPECT_GT(second.bed.bonds().broken(), broken_before) << name;
    }
    EXPECT_EQ(second.bed.bonds().formed, straight.bed.bonds().formed) << name;
    EXPECT_EQ(second.bed.bonds().broken_in_tension, straight.bed.bonds().broken_in_tension) << name;
    EXPECT_EQ(second.bed.bonds().broken_in_shear, straight.bed.bonds().broken_in_shear) << name;
    ASSERT_EQ(second.bed.broken_bonds().size(), straight.bed.broken_bonds().size()) << name;
    double apart = 0;
    ASSERT_EQ(straight.bed.spheres().size(), 320u);
    ASSERT_EQ(second.bed.spheres().size(), 320u);
    for (std::uint32_t id = 0; id < 320; ++id)
      apart = std::max(apart, norm(sphere(straight.bed, id).x - sphere(second.bed, id).x));
    EXPECT_LT(apart, 1e-12 * 0.16) << name;
    EXPECT_EQ(second.bed.removed_count(), 1u);
    const BedEnergy &a = straight.bed.energy(), &b = second.bed.energy();
    const double scale = a.kinetic + a.lost.damping + a.lost.sliding;
    // dashpots are kept as floats in the records and in the state alike
    EXPECT_NEAR(a.total(), b.total(), 1e-9 * scale) << name;
    EXPECT_NEAR(a.lost.sliding, b.lost.sliding, 1e-9 * scale) << name;
    EXPECT_NEAR(a.lost.breaking, b.lost.breaking, 1e-9 * scale) << name;
    EXPECT_NEAR(a.boundary_work, b.boundary_work, 1e-9 * scale) << name;
    EXPECT_LT(norm(straight.bed.boundary(5).wrench.force - second.bed.boundary(5).wrench.force), 1e-6) << name;
  }
}

/// What mixed precision keeps in float is saved as it is: what is left is the order of sums, which may move the
/// rounding of a velocity, 1e-7 of it.
TEST(Restart, EndsWhereTheStraightRunEndsInMixedPrecision) {
  for (const auto& [name, law] : every_law()) {
    Scene straight = scene(law, true, Precision::mixed), first = scene(law, true, Precision::mixed);
    advance(straight, 400);
    advance(first, 200);
    Scene second = continued(law, first, Precision::mixed, false);
    for (std::uint32_t id = 0; id < 320; ++id) {
      EXPECT_EQ(sphere(first.bed, id).x, sphere(second.bed, id).x) << name;
      EXPECT_EQ(sphere(first.bed, id).v, sphere(second.bed, id).v) << name;
    }
    advance(second, 200);
    double apart = 0;
    for (std::uint32_t id = 0; id < 320; ++id)
      apart = std::max(apart, norm(sphere(straight.bed, id).x - sphere(second.bed, id).x));
    EXPECT_LT(apart, 1e-7 * 0.16) << name;
  }
}

TEST(Restart, AHistoryLeftOutIsSeen) {
  const Law law = grains(1e5, 0.5, 0.5, 0.1);
  Scene straight = scene(law, true), second = scene(law, false);
  advance(straight, 400);
  second.tool.place(second.bed);
  Bed::State state = straight.bed.save();
  ASSERT_FALSE(state.pairs.empty());
  for (PairHistory& p : state.pairs) p.state.xi[0] = 0;
  drop_lists(state);
  second.bed.restore(state);
  advance(straight, 100), advance(second, 100);
  double apart = 0;
  for (std::uint32_t id = 0; id < 320; ++id)
    apart = std::max(apart, norm(sphere(straight.bed, id).x - sphere(second.bed, id).x));
  EXPECT_GT(apart, 1e-9);
}

TEST(Restart, OtherSurfacesAreRefused) {
  Scene a = scene(grains(), true);
  advance(a, 5);
  Bed b(table(grains()), quiet());
  add_plane(b, {}, {0, 1, 0});
  EXPECT_THROW(b.restore(a.bed.save()), std::invalid_argument);
}

/// What the contacts of a law without bonds remember has no room for one.
TEST(Restart, BondsOfALawWithoutAreRefused) {
  for (const auto& [name, law] : every_law()) {
    Scene a = scene(law, true), without = scene(grains(), false);
    if (!a.bed.has_bonding_laws()) continue;
    advance(a, 5);
    ASSERT_GT(a.bed.bonds().intact(), 0u) << name;
    EXPECT_THROW(without.bed.restore(a.bed.save()), std::invalid_argument) << name;
    // Laws exchanged during the run: the bonds are gone, and counted so.
    LawTable plain = table(grains());
    const std::size_t formed = a.bed.bonds().formed;
    a.bed.set_laws(plain);
    advance(a, 5);
    EXPECT_EQ(a.bed.bonds().intact(), 0u) << name;
    EXPECT_EQ(a.bed.bonds().formed, formed) << name;
  }
}

}  // namespace
}  // namespace subsoil::dem::test::restart
