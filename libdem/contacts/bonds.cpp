#include "libdem/contacts/bonds.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/contact.hpp"

namespace subsoil::dem {
namespace {

/// Share of the smaller radius that counts as touching: spheres of 5 mm whose coordinates, a hundred metres from the
/// origin, are off by some hundred roundings still do. A bond of this stretch bears a billionth of its modulus.
constexpr double kTouching = 1e-9;

/// What the contact stores that replaces a broken bond, and loses as it comes into being, J: it was not there in the
/// step before.
double taken_by_contact(const Law& law, const Sphere& a, const Sphere& b, double overlap) {
  if (!law->bond()->replaces_contact()) return 0;
  double memory[kOwnMemory] = {};
  const Approach<double> touch{.overlap = overlap,
                               .rate = 0,
                               .root_m = std::sqrt(a.m * b.m / (a.m + b.m)),
                               .r_eff = a.r * b.r / (a.r + b.r),
                               .elapsed = 1,
                               .per_sum = 1 / (a.r + b.r)};
  const NormalForce<double> contact = law->normal(touch, memory);
  return contact.stored + contact.lost;
}

}  // namespace

void each_bond(const ContactStore& contacts, const ContactLaws& laws,
               const std::function<void(std::uint32_t, std::uint32_t)>& use) {
  for (const PairRun& run : contacts.runs) {
    const MemoryShape& shape = laws.pair_memory(run.law);
    if (!shape.bonds) continue;
    contacts.each_lane(run, [&](std::uint32_t block, std::uint32_t lane) {
      if (!is_intact(read_bond(contacts.memory(run, block, shape), shape, lane).state)) return;
      const PairBlock& b = contacts.blocks[run.first + block];
      use(b.i[lane], contacts.images.sphere(b.j[lane]));
    });
  }
}

void count_bonds(const ContactStore& contacts, const ContactLaws& laws, const ParticleStore& particles, Snapshot& out) {
  out.bonds.assign(particles.size(), 0);
  each_bond(contacts, laws, [&](std::uint32_t i, std::uint32_t j) {
    ++out.bonds[particles.slot_of(particles[i])];
    ++out.bonds[particles.slot_of(particles[j])];
  });
}

void Bonds::form_due(double until, ContactStore& contacts, const ParticleStore& particles, const ContactLaws& laws) {
  for (std::uint32_t law = 0; law < laws.count(); ++law) {
    const Bond* bond = laws[law]->bond();
    if (bond == nullptr || bond->replaces_contact() || formed[law] != 0 || bond->time > until) continue;
    formed[law] = 1;
    for (const PairRun& run : contacts.runs)
      if (run.law == law) form_in_run(run, bond->gap, contacts, particles, laws.pair_memory(law));
  }
}

void Bonds::form_in_run(const PairRun& run, double gap, ContactStore& contacts, const ParticleStore& particles,
                        const MemoryShape& shape) {
  contacts.each_lane(run, [&](std::uint32_t block, std::uint32_t lane) {
    const PairBlock& pair = contacts.blocks[run.first + block];
    const Sphere a = particles.now(pair.i[lane]), b = particles.now(pair.j[lane]);
    const double overlap = a.r + b.r - norm(a.x - b.x);
    if (overlap < -gap - kTouching * std::min(a.r, b.r)) return;
    if (is_intact(read_bond(contacts.memory(run, block, shape), shape, lane).state)) return;  // came with the spheres
    BondMemory<double> bond;
    bond.reference = overlap, bond.state = kBonded;
    write_bond(contacts.memory(run, block, shape), shape, lane, bond);
    ++count.formed;
    if (run.candidates) contacts.activation[run.first + block] = 0;  // from now on active
  });
}

namespace {

/// Intact bond of a sphere that an edge touches.
struct BondUnderEdge {
  const PairRun* run;
  std::uint32_t block, lane, i, j;
  double needed;                   ///< N, to be cut
  Vec3 along;                      ///< unit, from i to j
  double pressed = 0;              ///< N, by the strongest boundary
  std::uint32_t boundary = kGone;  ///< that presses now, by
  double now = 0;                  ///< N

  /// Contacts of one boundary come one after the other. Blades on both sides hold against each other: their forces do
  /// not add up.
  void press(const EdgeContact& e) {
    if (e.boundary != boundary) boundary = e.boundary, now = 0;
    now += e.force * norm(cross(e.outward, along)) * norm(cross(e.along, along));
    pressed = std::max(pressed, now);
  }
};

/// Force that cuts the fibre that a sphere of its own material is part of; none: NaN.
double cutting_force(const Sphere& s, const ContactLaws& laws) {
  const int law = laws.between(s.material, s.material);
  const Bond* bond = law < 0 ? nullptr : laws[static_cast<std::uint32_t>(law)]->bond();
  return bond == nullptr || !bond->replaces_contact() ? std::nan("") : bond->cutting_force(s.r);
}

std::vector<BondUnderEdge> bonds_of(const std::vector<std::uint32_t>& touched, const ContactStore& contacts,
                                    const ParticleStore& particles, const ContactLaws& laws, const PeriodicCell& cell) {
  const auto is_touched = [&](std::uint32_t k) { return std::binary_search(touched.begin(), touched.end(), k); };
  std::vector<BondUnderEdge> out;
  for (const PairRun& run : contacts.runs) {
    const Bond* bond = laws[run.law]->bond();
    if (bond == nullptr || !bond->replaces_contact()) continue;
    const MemoryShape& shape = laws.pair_memory(run.law);
    contacts.each_lane(run, [&](std::uint32_t block, std::uint32_t lane) {
      const PairBlock& pair = contacts.blocks[run.first + block];
      const std::uint32_t i = pair.i[lane], j = contacts.images.sphere(pair.j[lane]);
      if (!is_touched(i) && !is_touched(j)) return;
      if (!is_intact(read_bond(contacts.memory(run, block, shape), shape, lane).state)) return;
      const Sphere a = particles.now(i), b = particles.now(j);
      out.push_back(
          {&run, block, lane, i, j, bond->cutting_force(std::min(a.r, b.r)), normalized(cell.shortest(b.x - a.x))});
    });
  }
  return out;
}

/// The bond that an edge at a sphere would cut; null: it would cut none.
BondUnderEdge* bond_at(const EdgeContact& edge, std::vector<BondUnderEdge>& bonds) {
  constexpr double beyond = 0.5;  // of the radius, from the middle of the last sphere
  BondUnderEdge* nearest = nullptr;
  double way = -2;
  int of_sphere = 0;
  for (BondUnderEdge& b : bonds) {
    if (b.i != edge.sphere && b.j != edge.sphere) continue;
    ++of_sphere;
    const double towards = (b.i == edge.sphere ? -1 : 1) * dot(edge.normal, b.along);
    if (towards > way) way = towards, nearest = &b;
  }
  return of_sphere == 1 && way < beyond ? nullptr : nearest;
}

}  // namespace

void Bonds::cut(std::span<const EdgeContact> at_edges, ContactStore& contacts, const ParticleStore& particles,
                const ContactLaws& laws, const PeriodicCell& cell) {
  std::vector<std::uint32_t> touched;
  bool strong = false;  // enough on one sphere to cut a bond with as much on the next
  for (const EdgeContact& e : at_edges) {
    const double needed = cutting_force(particles.now(e.sphere), laws);
    if (std::isnan(needed)) continue;
    touched.push_back(e.sphere);
    strong = strong || 2 * e.force >= needed;
  }
  if (!strong) return;
  std::sort(touched.begin(), touched.end());
  std::vector<BondUnderEdge> bonds = bonds_of(touched, contacts, particles, laws, cell);
  for (const EdgeContact& e : at_edges)
    if (BondUnderEdge* bond = bond_at(e, bonds)) bond->press(e);
  for (const BondUnderEdge& b : bonds) {
    if (!(b.pressed >= b.needed)) continue;
    const MemoryShape& shape = laws.pair_memory(b.run->law);
    const BlockMemory memory = contacts.memory(*b.run, b.block, shape);
    BondMemory<double> bond = read_bond(memory, shape, b.lane);
    bond.state = kCutThrough;
    write_bond(memory, shape, b.lane, bond);
  }
}

/// Blocks of a run may be of several threads.
void Bonds::mark_broken(std::uint32_t run) { std::atomic_ref(broke_in_run_[run]).store(1, std::memory_order_relaxed); }

void Bonds::record_broken(double time, ContactStore& contacts, const ParticleStore& particles, const ContactLaws& laws,
                          double& lost) {
  for (std::uint32_t r = 0; r < contacts.runs.size(); ++r) {
    if (broke_in_run_[r] == 0) continue;
    broke_in_run_[r] = 0;
    record_run(contacts.runs[r], time, contacts, particles, laws, lost);
  }
}

void Bonds::record_run(const PairRun& run, double time, ContactStore& contacts, const ParticleStore& particles,
                       const ContactLaws& laws, double& lost) {
  const MemoryShape& shape = laws.pair_memory(run.law);
  contacts.each_lane(run, [&](std::uint32_t block, std::uint32_t lane) {
    const BlockMemory memory = contacts.memory(run, block, shape);
    const BondMemory<double> bond = read_bond(memory, shape, lane);
    if (!has_broken(bond.state)) return;
    write_bond(memory, shape, lane, {});
    const PairBlock& pair = contacts.blocks[run.first + block];
    const Sphere a = particles.now(pair.i[lane]), b = particles.now(pair.j[lane]);
    const Vec3 apart = a.x - b.x;
    const double distance = norm(apart);
    const bool tension = bond.state < kBrokeInShear;
    const bool by_edge = bond.state > kBrokeInShear;
    ++(tension ? count.broken_in_tension : by_edge ? count.cut : count.broken_in_shear);
    const double energy = bond.released - taken_by_contact(laws[run.law], a, b, a.r + b.r - distance);
    lost += energy;
    broken.push_back({.time = time,
                      .ids = {std::min(a.id, b.id), std::max(a.id, b.id)},
                      .position = b.x + (0.5 * (b.r + distance - a.r) / distance) * apart,
                      .energy = energy,
                      .in_tension = tension,
                      .by_edge = by_edge});
  });
}

}  // namespace subsoil::dem
