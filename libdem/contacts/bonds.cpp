#include <algorithm>
#include <cmath>

#include "libdem/laws/bond.hpp"
#include "libdem/step/bed_impl.hpp"

/// Bonds between spheres: how they form, what is noted of those that break, who holds whom.
namespace subsoil::dem {

void Bed::Impl::each_bond(const std::function<void(std::uint32_t, std::uint32_t)>& use) const {
  for (std::uint32_t r = 0; r < runs.size(); ++r) {
    const MemoryShape& shape = pair_memory[runs[r].law];
    if (!shape.bonds) continue;
    each_lane(runs[r], [&](std::uint32_t block, std::uint32_t lane) {
      if (read_bond(memory(runs[r], block), shape, lane).state != kBonded) return;
      const PairBlock& b = blocks[runs[r].first + block];
      use(b.i[lane], b.j[lane]);
    });
  }
}

/// Bonds of laws whose time has come; lists hold.
void Bed::Impl::form_bonds(double until) {
  for (std::uint32_t law = 0; law < laws.laws.size(); ++law) {
    const Bond* bond = laws.laws[law]->bond();
    if (bond == nullptr || bonds_formed[law] != 0 || bond->time > until) continue;
    bonds_formed[law] = 1;
    for (std::uint32_t r = 0; r < runs.size(); ++r)
      if (runs[r].law == law) form_bonds_of(r, bond->gap);
  }
}

void Bed::Impl::form_bonds_of(std::uint32_t r, double gap) {
  const PairRun& run = runs[r];
  each_lane(runs[r], [&](std::uint32_t block, std::uint32_t lane) {
    const PairBlock& pair = blocks[run.first + block];
    const Sphere a = sphere(pair.i[lane]), b = sphere(pair.j[lane]);
    const double overlap = a.r + b.r - norm(a.x - b.x);
    if (overlap < -gap) return;
    BondMemory<double> bond;
    bond.reference = overlap, bond.state = kBonded;
    write_bond(memory(run, block), pair_memory[run.law], lane, bond);
    ++bonds.formed;
    if (run.near) wake[run.first + block] = 0;  // from now on in reach
  });
}

/// Bonds that broke in this step, in the order of the lists; what they held is lost. Called after every sweep, so that
/// no later build of the lists can drop one.
void Bed::Impl::note_broken_bonds() {
  for (std::uint32_t r = 0; r < runs.size(); ++r) {
    if (run_broke[r] == 0) continue;
    run_broke[r] = 0;
    const PairRun& run = runs[r];
    each_lane(runs[r], [&](std::uint32_t block, std::uint32_t lane) {
      const BlockMemory lines_of = memory(run, block);
      const BondMemory<double> bond = read_bond(lines_of, pair_memory[run.law], lane);
      if (bond.state < kBrokeInTension) return;
      write_bond(lines_of, pair_memory[run.law], lane, {});
      const PairBlock& pair = blocks[run.first + block];
      const Sphere a = sphere(pair.i[lane]), b = sphere(pair.j[lane]);
      const Vec3 apart = a.x - b.x;
      const double distance = norm(apart);
      const bool tension = bond.state < kBrokeInShear;
      ++(tension ? bonds.broken_in_tension : bonds.broken_in_shear);
      lost_before.breaking += bond.released;
      broken.push_back({.time = time,
                        .ids = {std::min(a.id, b.id), std::max(a.id, b.id)},
                        .position = b.x + (0.5 * (b.r + distance - a.r) / distance) * apart,
                        .energy = bond.released,
                        .in_tension = tension});
    });
  }
}

void Bed::Impl::count_bonds(Snapshot& out) const {
  out.bonds.assign(spheres.size(), 0);
  each_bond([&](std::uint32_t a, std::uint32_t b) {
    ++out.bonds[slot_of_id[spheres[a].id]];
    ++out.bonds[slot_of_id[spheres[b].id]];
  });
}

void Bed::let_bonds_form() { impl_->bonds_may_form = true; }

void Bed::form_bonds() {
  if (!impl_->lists_hold()) impl_->rebuild();
  impl_->bonds_may_form = true;
  impl_->form_bonds(std::numeric_limits<double>::infinity());
}

bool Bed::has_bonding_laws() const { return impl_->any_bonds; }
BondCount Bed::bonds() const { return impl_->bonds; }
std::span<const BrokenBond> Bed::broken_bonds() const { return impl_->broken; }

std::vector<std::array<std::uint32_t, 2>> Bed::bonded_pairs() const {
  std::vector<std::array<std::uint32_t, 2>> out;
  const auto take = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t i = impl_->spheres[a].id, j = impl_->spheres[b].id;
    out.push_back({std::min(i, j), std::max(i, j)});
  };
  if (impl_->tiles.empty()) {
    for (const auto& part : impl_->waiting)
      for (const BondHistory& b : part.bonds) take(b.owner, b.other);
  } else {
    impl_->each_bond(take);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace subsoil::dem
