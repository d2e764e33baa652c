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

void put(Batch& b, int lane, const Case& c) {
  for (int d = 0; d < 3; ++d) {
    b.r[d][lane] = c.distance * c.n[d];
    b.v[d][lane] = c.i.v[d] - c.j.v[d];
    b.w_i[d][lane] = c.i.w[d], b.w_j[d][lane] = c.j.w[d];
  }
  b.r_i[lane] = c.i.r, b.r_j[lane] = c.j.r, b.m_i[lane] = c.i.m, b.m_j[lane] = c.j.m;
  PairState s;
  for (int d = 0; d < 3; ++d) s.xi[d] = c.history.xi[d], s.rho[d] = c.history.rho[d];
  s.slipping = c.history.slipping ? 1 : 0;
  b.load(lane, s);
}

struct Answer {
  double numbers[19];
  explicit Answer(const Batch& b, int k)
      : numbers{b.f[0][k],   b.f[1][k],   b.f[2][k],   b.t_i[0][k], b.t_i[1][k], b.t_i[2][k], b.t_j[0][k],
                b.t_j[1][k], b.t_j[2][k], b.xi[0][k],  b.xi[1][k],  b.xi[2][k],  b.rho[0][k], b.rho[1][k],
                b.rho[2][k], b.stored[k], b.damping[k], b.sliding[k], b.rolling[k]} {}
};

TEST(Kernels, AgreeWithTheScalarContact) {
  for (const Kernel& kernel : kernels())
    for (const auto& [name, law] : every_law()) {
      const LawTable laws = table(law);
      Dice dice(7);
      for (int trial = 0; trial < 2000; ++trial) {
        const bool wall = trial % 3 == 0;
        Case c = random_case(dice, wall);
        Batch b{};
        put(b, 0, c);
        const double dt = trial % 5 == 0 ? 0 : 1e-5;
        kernel.evaluate(laws, b, 1, dt);
        const ContactResult want = std::visit(
            [&](const auto& l) { return reference_contact(l, c.n, c.distance, c.i, c.j, dt, c.history); }, laws.laws[0]);
        // Forces of up to 1 kN from terms no larger; overlaps are differences of 1e-2 m: relative error 1e-16 x 1e-2/1e-5.
        const double scale = 1e-9 * (norm(want.force) + 1e-3);
        EXPECT_LT(norm(want.force - Vec3{b.f[0][0], b.f[1][0], b.f[2][0]}), scale) << kernel.name << name << trial;
        EXPECT_LT(norm(want.torque_i - Vec3{b.t_i[0][0], b.t_i[1][0], b.t_i[2][0]}), 0.02 * scale) << kernel.name << name;
        EXPECT_LT(norm(want.torque_j - Vec3{b.t_j[0][0], b.t_j[1][0], b.t_j[2][0]}), 0.02 * scale) << kernel.name << name;
        EXPECT_LT(norm(c.history.xi - Vec3{b.xi[0][0], b.xi[1][0], b.xi[2][0]}), 1e-9 * (norm(c.history.xi) + 1e-6))
            << kernel.name << name;
      }
    }
}

TEST(Kernels, EveryLaneGivesTheSameBits) {
  for (const Kernel& kernel : kernels())
    for (const auto& [name, law] : every_law()) {
      LawTable laws = table(law);
      laws.laws.push_back(grains(3e4));  // a second law in the neighbouring lanes
      Dice dice(11);
      for (int trial = 0; trial < 20; ++trial) {
        const Case c = random_case(dice, trial % 2 == 0);
        std::vector<Answer> answers;
        for (int lane = 0; lane < Batch::lanes; ++lane) {
          Batch b{};
          for (int other = 0; other < Batch::lanes; ++other) {
            put(b, other, random_case(dice, other % 2 == 0));
            b.law[other] = other % 2;
          }
          put(b, lane, c);
          b.law[lane] = 0;
          kernel.evaluate(laws, b, trial % 3 == 0 ? lane + 1 : static_cast<int>(Batch::lanes), 1e-5);
          answers.emplace_back(b, lane);
          EXPECT_EQ(std::memcmp(&answers.back(), &answers.front(), sizeof(Answer)), 0) << kernel.name << name << lane;
        }
      }
    }
}

TEST(Kernels, UnknownSetIsRefused) { EXPECT_THROW(choose_kernel("sse9"), std::invalid_argument); }

}  // namespace
}  // namespace subsoil::dem::test
