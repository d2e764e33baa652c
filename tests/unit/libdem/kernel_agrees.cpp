#include <gtest/gtest.h>

#include "libdem/kernel/batch.hpp"
#include "tests/tools/dem_reference.hpp"

/// The vector kernels against a scalar contact written independently (tools/dem_reference.hpp), and lane against lane.
namespace subsoil::dem::test {
namespace {

std::vector<Kernel> kernels() {
  std::vector<Kernel> found;
  for (const char* name : {"portable", "avx2", "avx512"}) try {
      found.push_back(choose_kernel(name));
    } catch (const std::invalid_argument&) {  // not on this machine
    }
  return found;
}

struct Case {
  Side i, j;
  Vec3 n;
  double distance;
  History history;
};

Case random_case(Dice& dice, bool wall) {
  Case c;
  c.n = normalized(dice.ball(1) + Vec3{1e-3, 0, 0});
  c.i = {dice.ball(2), dice.ball(150), dice.between(5e-3, 12e-3), dice.between(1e-3, 9e-3)};
  c.j = {dice.ball(2), dice.ball(150), dice.between(5e-3, 12e-3), dice.between(1e-3, 9e-3)};
  if (wall) c.j = {dice.ball(2), dice.ball(3), 0, 0};
  c.distance = c.i.r + c.j.r - dice.between(-3e-3, 4e-3);
  c.history = {dice.ball(5e-4), dice.ball(1e-2), dice.between(0, 1) < 0.5};
  return c;
}

/// What a batch points to.
struct Records {
  Sphere owner[Batch::lanes], other[Batch::lanes];
  PairState state[Batch::lanes];
  Batch batch;

  void put(int k, const Case& c, int law) {
    // A surface stands behind itself by its negative radius (Batch::other), so that a deep centre keeps its normal.
    const double behind = c.j.r > 0 ? 0 : 2 * c.i.r;
    owner[k] = {(c.distance + behind) * c.n, c.i.r, c.i.v, c.i.m, c.i.w, 0, 0, 0};
    other[k] = {{}, c.j.r - behind, c.j.v, c.j.m, c.j.w, 1, 0, 0};
    state[k] = {};
    for (int d = 0; d < 3; ++d) state[k].xi[d] = c.history.xi[d], state[k].rho[d] = c.history.rho[d];
    state[k].slipping = c.history.slipping ? 1 : 0;
    batch.owner[k] = &owner[k], batch.other[k] = &other[k], batch.state[k] = &state[k];
    batch.law[k] = static_cast<unsigned char>(law);
  }
};

Vec3 first_three(const Four& f) { return {f[0], f[1], f[2]}; }
Vec3 vector(const double (&x)[3]) { return {x[0], x[1], x[2]}; }

TEST(Kernels, AgreeWithTheScalarContact) {
  for (const Kernel& kernel : kernels())
    for (const auto& [name, law] : every_law()) {
      const LawTable laws = table(law);
      Dice dice(7);
      for (int trial = 0; trial < 2000; ++trial) {
        const bool wall = trial % 3 == 0;
        Case c = random_case(dice, wall);
        Records r;
        r.put(0, c, 0);
        const double dt = trial % 5 == 0 ? 0 : 1e-5;
        kernel.evaluate(laws, r.batch, 1, dt);
        const ContactResult want =
            std::visit([&](const auto& l) { return reference_contact(l, c.n, c.distance, c.i, c.j, dt, c.history); },
                       laws.laws[0]);
        const ContactForce& got = r.batch.out[0];
        // Forces of up to 1 kN from terms no larger; overlaps are differences of 1e-2 m: relative error 1e-16 x
        // 1e-2/1e-5.
        const double scale = 1e-9 * (norm(want.force) + 1e-3), overlap = c.i.r + c.j.r - c.distance;
        EXPECT_LT(norm(want.force - first_three(got.f)), scale) << kernel.name << name << trial;
        EXPECT_LT(norm(want.torque_i - first_three(got.t_i)), 0.02 * scale) << kernel.name << name << trial;
        EXPECT_LT(norm(want.torque_j - first_three(got.t_j)), 0.02 * scale) << kernel.name << name << trial;
        EXPECT_LT(norm(c.history.xi - vector(r.state[0].xi)), 1e-9 * (norm(c.history.xi) + 1e-6))
            << kernel.name << name;
        EXPECT_NEAR(got.f[3], overlap / (wall ? c.i.r : std::min(c.i.r, c.j.r)), 1e-12) << kernel.name << name;
        EXPECT_EQ(got.t_i[3], overlap > 0 ? 1 : 0);
      }
    }
}

/// Any lane, any number of lanes, any law in the lanes beside it.
TEST(Kernels, EveryLaneGivesTheSameBits) {
  for (const Kernel& kernel : kernels())
    for (const auto& [name, law] : every_law()) {
      LawTable laws = table(law);
      laws.laws.push_back(grains(3e4));
      Dice dice(11);
      for (int trial = 0; trial < 20; ++trial) {
        const Case c = random_case(dice, trial % 2 == 0);
        ContactForce force{};
        PairState state{};
        for (int lane = 0; lane < Batch::lanes; ++lane) {
          Records r;
          for (int k = 0; k < Batch::lanes; ++k) r.put(k, random_case(dice, k % 2 == 0), k % 2);
          r.put(lane, c, 0);
          kernel.evaluate(laws, r.batch, trial % 3 == 0 ? lane + 1 : static_cast<int>(Batch::lanes), 1e-5);
          if (lane == 0) force = r.batch.out[0], state = r.state[0];
          EXPECT_EQ(std::memcmp(&force, &r.batch.out[lane], sizeof force), 0) << kernel.name << name << lane;
          EXPECT_EQ(std::memcmp(&state, &r.state[lane], sizeof state), 0) << kernel.name << name << lane;
        }
      }
    }
}

TEST(Kernels, UnknownSetIsRefused) { EXPECT_THROW(choose_kernel("sse9"), std::invalid_argument); }

}  // namespace
}  // namespace subsoil::dem::test
