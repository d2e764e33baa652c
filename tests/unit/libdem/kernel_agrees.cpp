#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/dem_reference.hpp"
#include "tests/tools/every_kernel.hpp"
#include "tests/tools/every_law.hpp"
#include "tests/tools/laws.hpp"

/// The vector kernels against a scalar contact written independently (tools/dem_reference.hpp), and lane against lane.
namespace subsoil::dem::test::kernel_agrees {
namespace {

struct Case {
  Side i, j;
  Vec3 n;
  double distance;
  Vec3 turn;  ///< of n in half the step: at surfaces given, of pairs by their velocities
  History history;
  ReferenceBond bond{};
};

Case random_case(Dice& dice, bool wall) {
  Case c;
  c.n = normalized(dice.ball(1) + Vec3{1e-3, 0, 0});
  c.i = {dice.ball(2), dice.ball(150), dice.between(5e-3, 12e-3), dice.between(1e-3, 9e-3)};
  c.j = {dice.ball(2), dice.ball(150), dice.between(5e-3, 12e-3), dice.between(1e-3, 9e-3)};
  if (wall) c.j = {dice.ball(2), dice.ball(3), 0, 0}, c.turn = cross(dice.ball(2e-3), c.n);
  c.distance = c.i.r + c.j.r - dice.between(-3e-3, 4e-3);
  c.history = {dice.ball(5e-4), dice.ball(1e-2), 0, dice.between(0, 1) < 0.5};
  c.history.rho -= dot(c.history.rho, c.n) * c.n;
  c.history.twist = dice.between(-1e-2, 1e-2);
  for (double& number : c.history.own) number = dice.between(0, 3e-3);  // overlaps; of EEPA also a pull
  c.bond.intact = !wall && dice.between(0, 1) < 0.8;
  c.bond.reference = c.i.r + c.j.r - c.distance + dice.between(-1e-4, 1e-4);
  return c;
}

/// Springs of a bond as far as its law lets them go, most of them.
void load_bond(const Law& law, Case& c, Dice& dice) {
  const Bond* bond = law->bond();
  if (bond == nullptr) return;
  const double r = bond->radius * std::min(c.i.r, c.j.r), area = pi * r * r;
  c.bond.shear = dice.ball(0.7 * bond->shear * area), c.bond.bending = dice.ball(0.3 * bond->tensile * area * r);
  for (Vec3* v : {&c.bond.shear, &c.bond.bending}) *v -= dot(*v, c.n) * c.n;
  c.bond.twisting = dice.between(-0.3, 0.3) * bond->shear * area * r;
}

/// As the engine keeps it: slips and angles in place of forces and moments.
BondMemory<double> memory_of(const Law& law, const Case& c) {
  BondMemory<double> out;
  const Bond& b = *law->bond();
  const double r = b.radius * std::min(c.i.r, c.j.r), area = pi * r * r, second = pi * std::pow(r, 4) / 4;
  const double k_n = b.modulus / (c.i.r + c.j.r), k_s = k_n / b.ratio;
  for (int d = 0; d < 3; ++d)
    out.shear[d] = c.bond.shear[d] / (k_s * area), out.bend[d] = c.bond.bending[d] / (k_n * second);
  out.twist = c.bond.twisting / (k_s * 2 * second);
  out.reference = c.bond.reference, out.state = c.bond.intact ? kBonded : kNoBond;
  return c.bond.intact ? out : BondMemory<double>{};
}

struct Answer {
  Vec3 force, torque_i, torque_j;
  double touching = 0;
  PairState state;
  double bond_state = kNoBond;
  bool broke = false;
};

Vec3 first_three(const Four& f) { return {f[0], f[1], f[2]}; }
Vec3 vector(const double (&x)[3]) { return {x[0], x[1], x[2]}; }

PairState state_of(const History& h) {
  PairState s;
  for (int d = 0; d < 3; ++d) s.xi[d] = h.xi[d], s.rho[d] = h.rho[d];
  s.twist = h.twist;
  for (int k = 0; k < kOwnMemory; ++k) s.own[k] = h.own[k];
  s.slipping = h.slipping ? 1 : 0;
  return s;
}

/// Pairs in one run of blocks, each with spheres of its own: lane k has sphere i 2 k and sphere j 2 k + 1.
std::vector<Answer> evaluate_pairs(const Kernel& kernel, const Law& law, const std::vector<Case>& cases, double dt,
                                   bool sampled = true, bool mixed = false) {
  std::vector<Sphere> spheres;
  std::vector<MixedSphere> records;
  const std::size_t blocks_needed = (cases.size() + kBlock - 1) / kBlock;
  const MemoryShape shape = MemoryShape::of(law, mixed);
  std::vector<PairBlock> blocks(blocks_needed);
  std::vector<Line> lines(shape.lines(blocks_needed));
  const auto memory = [&](std::size_t k) { return BlockMemory::at(lines.data(), blocks_needed, shape, k / kBlock); };
  for (std::uint32_t k = 0; k < blocks_needed * kBlock; ++k) {
    const std::uint32_t from = k < cases.size() ? k : k / kBlock * kBlock;  // lanes beyond repeat the block's first
    blocks[k / kBlock].i[k % kBlock] = 2 * from, blocks[k / kBlock].j[k % kBlock] = 2 * from + 1;
    if (k >= cases.size()) continue;
    const Case& c = cases[k];
    spheres.push_back({c.distance * c.n, c.i.r, c.i.v, c.i.m, c.i.w, 0, 0, SphereKind::free, 0});
    spheres.push_back({{}, c.j.r, c.j.v, c.j.m, c.j.w, 1, 0, SphereKind::free, 0});
    write_lane(memory(k), shape, k % kBlock, state_of(c.history));
    if (shape.bonds) write_bond(memory(k), shape, k % kBlock, memory_of(law, c));
  }
  for (const Sphere& s : spheres) records.push_back(rounded(s, s.m));
  std::size_t ring = 1;
  while (ring < spheres.size()) ring *= 2;
  Sums sums(ring);
  PairJob job{};
  job.record = job.accumulate = sampled;
  job.spheres = spheres.data(), job.blocks = blocks.data(), job.lines = lines.data();
  job.mixed = mixed ? records.data() : nullptr;
  std::vector<BlockShape> shapes(blocks_needed, {.lanes = kBlock, .begins = true});
  if (cases.size() % kBlock != 0) shapes.back().lanes = cases.size() % kBlock;
  job.shapes = shapes.data();
  job.count = static_cast<std::uint32_t>(blocks_needed);
  job.uniform = std::all_of(spheres.begin(), spheres.end(),
                            [&](const Sphere& s) { return s.r == spheres[0].r && s.m == spheres[0].m; });
  job.elapsed = dt;
  job.ring = sums.ring();
  kernel.pairs(law, job);
  std::vector<Answer> out;
  for (std::uint32_t k = 0; k < cases.size(); ++k) {
    const Accumulator own = sums.of(2 * k, mixed), others = sums.of(2 * k + 1, mixed);
    out.push_back({first_three(own.f), first_three(own.t), first_three(others.t), own.t[3],
                   read_lane(memory(k), shape, k % kBlock),
                   shape.bonds ? read_bond(memory(k), shape, k % kBlock).state : kNoBond, job.broke});
  }
  return out;
}

/// Up to 8 spheres at surfaces: `j` is the surface.
std::vector<Answer> evaluate_surface(const Kernel& kernel, const Law& law, const std::vector<Case>& cases, double dt) {
  std::vector<Sphere> spheres;
  for (const Case& c : cases)
    spheres.push_back({c.distance * c.n, c.i.r, c.i.v, c.i.m, c.i.w, 0, 0, SphereKind::free, 0});
  SurfaceJob job{};
  const MemoryShape shape = MemoryShape::at_surface(law);
  job.spheres = spheres.data();
  job.count = static_cast<std::uint32_t>(cases.size());
  job.elapsed = dt;
  for (std::uint32_t k = 0; k < kBlock; ++k) {
    const Case& c = cases[k < cases.size() ? k : 0];
    job.sphere[k] = k < cases.size() ? k : 0;
    for (int d = 0; d < 3; ++d)
      job.normal[d][k] = c.n[d], job.velocity[d][k] = c.j.v[d], job.angular_velocity[d][k] = c.j.w[d],
      job.turn[d][k] = c.turn[d];
    job.distance[k] = c.distance, job.mass[k] = c.i.m;
    write_lane(BlockMemory::at(job.lines, 1, shape, 0), shape, k, state_of(c.history));
  }
  kernel.surface(law, job);
  std::vector<Answer> out;
  for (std::uint32_t k = 0; k < cases.size(); ++k)
    out.push_back({first_three(job.f[k]), first_three(job.t_i[k]), first_three(job.t_j[k]), job.t_i[k][3],
                   read_lane(BlockMemory::at(job.lines, 1, shape, 0), shape, k)});
  return out;
}

/// Contacts that have touched before, for laws that remember it.
void touch(const Law& law, Case& c) {
  const bool wall = c.j.r == 0;
  const double m = wall ? c.i.m : c.i.m * c.j.m / (c.i.m + c.j.m), r = wall ? c.i.r : c.i.r * c.j.r / (c.i.r + c.j.r);
  law->normal({1e-4, 0, std::sqrt(m), r, 0}, c.history.own);
}

/// Every law, and friction by the conventions of other programs, some of which make energy.
std::vector<NamedLaw> laws_and_conventions() {
  std::vector<NamedLaw> laws = every_law();
  for (const Conventions program :
       {Conventions::lammps, Conventions::liggghts, Conventions::mercury, Conventions::edem}) {
    const std::string name = "conventions " + std::to_string(static_cast<int>(program));
    Linear springs = with(grains(), adhesion(0.2, 1e3));
    HertzMindlin hertz = elastic(1e7, 0.3, 0.7, 0.4, 0.05);
    springs.friction.take(program), hertz.friction.take(program);
    springs.friction.mu_r = 0.05, springs.friction.c_r = 1e-4;
    laws.push_back({"linear, " + name, springs});
    laws.push_back({"hertz-mindlin, " + name, hertz});
    hertz.friction.changing = Changing::rescale, hertz.friction.mu_d = 0.3, hertz.friction.k_r = 0.5;
    laws.push_back({"hertz-mindlin rescaled, " + name, hertz});
  }
  return laws;
}

bool law_twists(const Law& law) { return law->friction().resists_twist(); }

TEST(Kernels, AgreeWithTheScalarContact) {
  for (const Kernel& kernel : every_kernel())
    for (const auto& [name, law] : laws_and_conventions()) {
      const Law resolved = table(law).laws[0];
      Dice dice(7);
      int broken = 0, held = 0;
      for (int trial = 0; trial < 2000; ++trial) {
        const bool wall = trial % 3 == 0;
        Case c = random_case(dice, wall);
        if (trial % 7 == 0 && !wall) {  // uniform, which the kernel works out once for all
          c.distance += c.i.r - c.j.r;
          c.j.r = c.i.r, c.j.m = c.i.m;
        }
        if (trial % 4 < 2) touch(resolved, c);
        load_bond(resolved, c, dice);
        const double dt = trial % 5 == 0 ? 0 : 1e-5;
        const bool sampled = trial % 2 == 0;
        const Answer got = wall ? evaluate_surface(kernel, resolved, {c}, dt)[0]
                                : evaluate_pairs(kernel, resolved, {c}, dt, sampled)[0];
        if (!wall) c.turn = turn_of_pair(c.n, c.distance, c.i, c.j, dt);
        ContactResult want = reference_contact(resolved, c.n, c.distance, c.turn, c.i, c.j, dt, c.history);
        if (const Bond* bond = resolved->bond(); bond != nullptr && !wall) {
          const bool was = c.bond.intact;
          reference_bond(*bond, c.n, c.distance, c.i, c.j, dt, c.bond, want);
          EXPECT_EQ(got.broke, was && !c.bond.intact) << kernel.name << name << trial;
          EXPECT_EQ(got.bond_state == kBonded, c.bond.intact) << kernel.name << name << trial;
          broken += got.broke, held += c.bond.intact;
        }
        // Forces of up to 1 kN from terms no larger; overlaps are differences of 1e-2 m: relative error 1e-16 x
        // 1e-2/1e-5.
        const double scale = 1e-9 * (norm(want.force) + 1e-3), overlap = c.i.r + c.j.r - c.distance;
        EXPECT_LT(norm(want.force - got.force), scale) << kernel.name << name << trial;
        EXPECT_LT(norm(want.torque_i - got.torque_i), 0.02 * scale) << kernel.name << name << trial;
        EXPECT_LT(norm(want.torque_j - got.torque_j), 0.02 * scale) << kernel.name << name << trial;
        EXPECT_LT(norm(c.history.xi - vector(got.state.xi)), 1e-9 * (norm(c.history.xi) + 1e-6)) << kernel.name << name;
        if (law_twists(resolved)) {
          EXPECT_NEAR(got.state.twist, c.history.twist, 1e-9 * 1e-2) << kernel.name << name;
        }
        // Steps that are not sampled do not count what touches.
        if (wall || sampled) {
          EXPECT_EQ(got.touching, overlap > 0 ? 1 : 0);
        }
        const int numbers = resolved->own_memory();
        for (int k = 0; k < numbers; ++k)
          EXPECT_NEAR(got.state.own[k], c.history.own[k], 1e-9 * (std::abs(c.history.own[k]) + 1e-6))
              << kernel.name << name;
      }
      if (resolved->bond() != nullptr) {
        EXPECT_GT(broken, 100) << name;
        EXPECT_GT(held, 100) << name;
      }
    }
}

/// Mixed precision: the same contact from numbers rounded to float. What a float force may err by is 6e-8 of its
/// largest term, of which a contact at the edge of slipping or of a band has some that cancel; nine of ten agree to
/// 1e-5.
TEST(Kernels, MixedPrecisionAgreesWithTheScalarContact) {
  for (const Kernel& kernel : every_kernel())
    for (const auto& [name, law] : every_law()) {
      const Law resolved = table(law).laws[0];
      Dice dice(23);
      int close = 0;
      constexpr int trials = 1000;
      for (int trial = 0; trial < trials; ++trial) {
        Case c = random_case(dice, false);
        if (trial % 4 < 2) touch(resolved, c);
        c.bond.intact = false;  // floats may decide otherwise on breaking
        const Answer got = evaluate_pairs(kernel, resolved, {c}, 1e-5, trial % 2 == 0, true)[0];
        const Vec3 turn = turn_of_pair(c.n, c.distance, c.i, c.j, 1e-5);
        const ContactResult want = reference_contact(resolved, c.n, c.distance, turn, c.i, c.j, 1e-5, c.history);
        const double error = norm(want.force - got.force);
        EXPECT_LT(error, 1e-3 * norm(want.force) + 1e-2) << kernel.name << name << trial;
        EXPECT_LT(norm(want.torque_i - got.torque_i), 1e-3 * norm(want.torque_i) + 1e-4)
            << kernel.name << name << trial;
        close += error <= 1e-5 * norm(want.force);
      }
      EXPECT_GT(close, trials * 9 / 10) << kernel.name << name;
    }
}

/// Any lane of any block, whatever is beside it. (A sampled step may differ from one that is not in the last bit: the
/// compiler fuses other multiplications and additions.)
TEST(Kernels, EveryLaneGivesTheSameBits) {
  for (const Kernel& kernel : every_kernel())
    for (const auto& [name, law] : every_law()) {
      const Law resolved = table(law).laws[0];
      Dice dice(11);
      for (int trial = 0; trial < 20; ++trial) {
        Case c = random_case(dice, false);
        load_bond(resolved, c, dice);
        const bool sampled = trial % 2 == 0, mixed = trial % 4 < 2;
        const Answer alone = evaluate_pairs(kernel, resolved, {c}, 1e-5, sampled, mixed)[0];
        for (std::size_t lane = 0; lane < 43; ++lane) {
          std::vector<Case> cases(trial % 3 == 0 ? lane + 1 : 43);
          for (Case& other : cases) other = random_case(dice, false);
          cases[lane] = c;
          const Answer a = evaluate_pairs(kernel, resolved, cases, 1e-5, sampled, mixed)[lane];
          EXPECT_EQ(a.force, alone.force) << kernel.name << name << lane;
          EXPECT_EQ(a.torque_i, alone.torque_i) << kernel.name << name << lane;
          EXPECT_EQ(a.torque_j, alone.torque_j) << kernel.name << name << lane;
          for (int d = 0; d < 3; ++d) {
            EXPECT_EQ(a.state.xi[d], alone.state.xi[d]) << kernel.name << name << lane;
            EXPECT_EQ(a.state.rho[d], alone.state.rho[d]) << kernel.name << name << lane;
          }
          EXPECT_EQ(a.state.twist, alone.state.twist) << kernel.name << name << lane;
          EXPECT_EQ(a.bond_state, alone.bond_state) << kernel.name << name << lane;
          for (int k = 0; k < kOwnMemory; ++k)
            EXPECT_EQ(a.state.own[k], alone.state.own[k]) << kernel.name << name << lane;
        }
      }
    }
}

TEST(Kernels, UnknownSetIsRefused) { EXPECT_THROW(choose_kernel("sse9"), std::invalid_argument); }

}  // namespace
}  // namespace subsoil::dem::test::kernel_agrees
