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
      if (read_bond(contacts.memory(run, block, shape), shape, lane).state != kBonded) return;
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
    BondMemory<double> bond;
    bond.reference = overlap, bond.state = kBonded;
    write_bond(contacts.memory(run, block, shape), shape, lane, bond);
    ++count.formed;
    if (run.candidates) contacts.activation[run.first + block] = 0;  // from now on active
  });
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
    if (bond.state < kBrokeInTension) return;
    write_bond(memory, shape, lane, {});
    const PairBlock& pair = contacts.blocks[run.first + block];
    const Sphere a = particles.now(pair.i[lane]), b = particles.now(pair.j[lane]);
    const Vec3 apart = a.x - b.x;
    const double distance = norm(apart);
    const bool tension = bond.state < kBrokeInShear;
    ++(tension ? count.broken_in_tension : count.broken_in_shear);
    const double energy = bond.released - taken_by_contact(laws[run.law], a, b, a.r + b.r - distance);
    lost += energy;
    broken.push_back({.time = time,
                      .ids = {std::min(a.id, b.id), std::max(a.id, b.id)},
                      .position = b.x + (0.5 * (b.r + distance - a.r) / distance) * apart,
                      .energy = energy,
                      .in_tension = tension});
  });
}

}  // namespace subsoil::dem
