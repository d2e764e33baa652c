#include <gtest/gtest.h>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/attraction.hpp"
#include "tests/tools/dem_beds.hpp"

/// Checkpoints in memory: a bed that returns to one continues with the same bits, whatever it did in between.
namespace subsoil::dem::test::checkpoint {
namespace {

void put(std::vector<double>& out, const Vec3& v) { out.insert(out.end(), {v.x, v.y, v.z}); }
void put(std::vector<double>& out, const PairState& state) {
  const auto number = [&](auto x, int) { out.push_back(static_cast<double>(x)); };
  each_field(MemoryShape::whole(), state, number, number);
}

std::vector<double> numbers_of(const std::vector<Sphere>& spheres) {
  std::vector<double> out;
  for (const Sphere& s : spheres) {
    put(out, s.x), put(out, s.v), put(out, s.w);
    out.insert(out.end(), {s.r, s.m, static_cast<double>(s.id), static_cast<double>(s.calm)});
  }
  return out;
}
std::vector<double> numbers_of(const std::vector<PairHistory>& pairs) {
  std::vector<double> out;
  for (const PairHistory& p : pairs) out.push_back(p.i), out.push_back(p.j), put(out, p.state);
  return out;
}
std::vector<double> numbers_of(const std::vector<SurfaceHistory>& contacts) {
  std::vector<double> out;
  for (const SurfaceHistory& c : contacts)
    out.push_back(c.sphere), out.push_back(c.boundary), put(out, c.normal), put(out, c.state);
  return out;
}

struct Numbers {
  std::vector<double> of_spheres;
  double lost = 0, work = 0, path = 0;
  long rebuilds = 0, steps = 0;
  bool operator==(const Numbers&) const = default;
};

/// Beds whose parts differ in what a step writes.
struct Case {
  const char* name;
  Precision precision = Precision::doubles;
  bool periodic = false, active = false, bonds = false;
  int threads = 1;
};

/// Spheres fall into a bin while a plate is pushed down on them: lists are rebuilt every few steps.
class FallingBed {
 public:
  explicit FallingBed(const Case& c) : bed_(laws(c), options(c)) {
    Dice dice(3);
    bed_.add(loose_lattice({0.018, 0.018, 0.018}, 6, 6, 6, 0.026, 0.01, 0.2, 1, dice));
    Boundary b;
    if (c.periodic) {
      add_plane(bed_, {}, {0, 1, 0});
      b.shape = Plane({}, {0, -1, 0});  // a box would have to stay away from the sides
    } else {
      add_bin(bed_, 0.18, 0.18);
      b.shape = MeshSurface(box_mesh({0.08, 0.02, 0.05}, {}));
    }
    b.pose.position = {0.09, 0.195, 0.09};
    plate_ = bed_.add(std::move(b));
    if (c.active) bed_.set_active(ActiveRule{.within = 0.03, .below = 0.2});
    if (c.bonds) bed_.let_bonds_form();
  }

  Numbers run(int steps) {
    for (int k = 0; k < steps; ++k) {
      bed_.boundary(plate_).velocity = {0, -2, 0};
      bed_.boundary(plate_).pose.position.y -= 2 * step_;
      bed_.step(step_, {.energy = k % 7 == 0});
    }
    Numbers out{.of_spheres = numbers_of(bed_.save().spheres),
                .lost = bed_.energy().lost.total(),
                .work = bed_.boundary(plate_).work,
                .path = bed_.max_speed(),
                .rebuilds = bed_.rebuilds(),
                .steps = bed_.steps()};
    return out;
  }
  Bed& bed() { return bed_; }

 private:
  static LawTable laws(const Case& c) {
    Linear law = grains(2e4, 0.5, 0.4, 0.1);
    if (c.bonds) return table(with(law, cement()));
    return table(law);
  }
  static BedOptions options(const Case& c) {
    BedOptions out = quiet({0, -9.81, 0});
    out.precision = c.precision, out.threads = c.threads, out.sample_every = 4;
    if (c.periodic) out.periodic = {.low = {0, 0, 0}, .length = {0.18, 0, 0.18}};
    return out;
  }

  static constexpr double step_ = 5e-5;
  Bed bed_;
  int plate_ = 0;
};

class Checkpoint : public testing::TestWithParam<Case> {};

TEST_P(Checkpoint, ContinuesWithTheSameBits) {
  FallingBed whole(GetParam()), one(GetParam());
  constexpr int before = 150, after = 300;
  whole.run(before), one.run(before);
  Bed::Checkpoint saved;
  one.bed().save(saved);
  const Bed::State state = saved.state();
  const Numbers exact = whole.run(after);
  EXPECT_EQ(one.run(after), exact) << "taking a checkpoint changes no bit";
  ASSERT_GT(one.bed().rebuilds(), 3) << "lists must have been rebuilt in between";
  one.bed().restore(saved);
  EXPECT_EQ(one.run(after), exact) << "other lists";
  one.bed().restore(saved);
  const Numbers same = one.run(2);
  one.bed().save(saved), one.bed().save(saved);
  one.run(3), one.bed().restore(saved);
  FallingBed third(GetParam());
  third.run(before);
  EXPECT_EQ(third.run(2), same);
  EXPECT_EQ(one.run(after - 2).of_spheres, third.run(after - 2).of_spheres) << "the same lists";
  // The arrays of a checkpoint are those that the bed saved at its instant.
  FallingBed fourth(GetParam());
  fourth.run(before);
  const Bed::State arrays = fourth.bed().save();
  EXPECT_EQ(numbers_of(state.spheres), numbers_of(arrays.spheres));
  EXPECT_EQ(numbers_of(state.pairs), numbers_of(arrays.pairs));
  EXPECT_EQ(numbers_of(state.surfaces), numbers_of(arrays.surfaces));
  EXPECT_EQ(state.parts, arrays.parts);
  EXPECT_FALSE(state.pairs.empty());
}
INSTANTIATE_TEST_SUITE_P(Beds, Checkpoint,
                         testing::Values(Case{"double"}, Case{"mixed", Precision::mixed},
                                         Case{"threads", Precision::doubles, false, false, false, 3},
                                         Case{"periodic", Precision::doubles, true},
                                         Case{"active", Precision::doubles, false, true},
                                         Case{"bonds", Precision::doubles, false, false, true}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(CheckpointOfABed, IsRefusedByAnother) {
  FallingBed one({"one"}), other({"other"});
  one.run(3), other.run(3);
  Bed::Checkpoint saved;
  EXPECT_THROW(one.bed().restore(saved), std::invalid_argument) << "empty";
  one.bed().save(saved);
  EXPECT_TRUE(saved.is_of(one.bed()));
  EXPECT_THROW(other.bed().restore(saved), std::invalid_argument);
}

}  // namespace
}  // namespace subsoil::dem::test::checkpoint
