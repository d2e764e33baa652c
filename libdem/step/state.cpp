#include <algorithm>
#include <string>
#include <unordered_map>

#include "libdem/step/bed_impl.hpp"

/// Full state of a bed for a restart. Histories travel by sphere ids, so the lists may be built anew in any order; how
/// far they had come stands beside (list_state.cpp).
namespace subsoil::dem {
namespace {

/// Of a state without any they begin at zero: their user asks for them from now on.
void archive_loads(Archive& a, std::vector<Boundary>& boundaries) {
  std::size_t faces = 0;
  for (const Boundary& b : boundaries) faces += b.loads ? b.loads->faces.size() : 0;
  if (a.reads() ? !a.has("loads") : faces == 0) return;
  const std::size_t kept = faces;
  a.group("loads", [&] { a("faces", faces); });
  if (faces != kept)
    throw std::invalid_argument(
        "restart: the state has kept the loads of other surfaces than the scenario; use the scenario it was written "
        "from, or leave `wear` out of all of them");
  for (Boundary& b : boundaries)
    if (b.loads)
      for (FaceLoad& f : b.loads->faces) a("loads", f);
}

void archive_boundaries(Archive& a, std::vector<Boundary>& boundaries) {
  std::size_t count = boundaries.size();
  a("boundary count", count);
  if (count != boundaries.size())
    throw std::invalid_argument(
        "restart: the state has other surfaces than the scenario; use the scenario it was written from");
  for (Boundary& b : boundaries) {
    // At t_n; given again before the next step. Walls stand where it says, shifted to their datum or not.
    a.group("boundaries", [&] {
      a("wrench", b.wrench)("work", b.work);
      a("position", b.pose_before.position)("attitude", b.pose_before.attitude);
    });
    if (a.reads()) b.pose = b.pose_before;
  }
}

}  // namespace

void archive(Archive& a, const char* name, Losses& lost) {
  a.group(name, [&] {
    a("damping", lost.damping)("sliding", lost.sliding)("rolling", lost.rolling)("breaking", lost.breaking);
    if (!a.reads() || a.has("yielding")) a("yielding", lost.yielding);
  });
}

/// Throws std::invalid_argument for a sphere that the bed's laws do not know.
const Sphere& Bed::Impl::checked(const Sphere& s) const {
  if (s.material >= laws.table().materials)
    throw std::invalid_argument("restart: the state has more materials than the scenario");
  return s;
}

/// Counts, what has formed, and what broke.
void Bed::Impl::archive_bonding(Archive& a) {
  if (a.reads()) {
    bonds.count = {}, bonds.broken.clear(), bonds.may_form = false;
    std::fill(bonds.formed.begin(), bonds.formed.end(), 0);
  }
  if (a.reads() ? !laws.any_bonds() && !a.has("bonding") : !laws.any_bonds()) return;
  std::vector<char> formed = bonds.formed;
  a.group("bonding", [&] {
    BondCount& n = bonds.count;
    a("may form", bonds.may_form)("formed", n.formed)("broken in tension", n.broken_in_tension);
    a("broken in shear", n.broken_in_shear)("cut", n.cut)("removed", n.removed);
    a("laws", formed);
    std::size_t count = bonds.broken.size();
    a("broken count", count);
    if (a.reads()) bonds.broken.clear();
    for (std::size_t k = 0; k < count; ++k) {
      if (a.reads()) bonds.broken.emplace_back();
      BrokenBond& b = bonds.broken[k];
      a.group("broken", [&] {
        a("ids", b.ids)("time", b.time)("position", b.position)("energy", b.energy)("in tension", b.in_tension);
        a("by edge", b.by_edge);
      });
    }
  });
  if (formed.size() != bonds.formed.size())
    throw std::invalid_argument(
        "restart: the state has other bonds than the scenario; use the scenario it was written from");
  bonds.formed = std::move(formed);
  for (std::uint32_t law = 0; law < bonds.formed.size(); ++law)
    if (bonds.formed[law] != 0 && !laws.pair_memory(law).bonds)
      throw std::invalid_argument(
          "restart: the state has bonds of a law that has none in the scenario; use the scenario it was written from");
}

/// All but spheres, histories and lists. Spheres are there already where it reads.
void Bed::Impl::archive(Archive& a) {
  a("time", now.time)("step before", now.dt_before)("steps", now.steps)("fallen", now.fallen);
  Losses lost = a.reads() ? Losses{} : balance.lost(surfaces.chunks);
  dem::archive(a, "lost", lost);
  if (a.reads()) balance.lost_before = lost;
  a("removed", balance.removed);
  double frozen = a.reads() ? 0 : balance.frozen();
  if (a.reads() ? a.has("frozen") : region.on()) a("frozen", frozen);
  if (a.reads()) balance.frozen_before = frozen;
  a.group("sleep", [&] { region.archive(a, particles.size()); });
  archive_boundaries(a, boundaries);
  archive_loads(a, boundaries);
  a("fixed", fixed)("clumps", clumps);
  if (a.reads()) forces.reset_work();
  if (a.reads() ? a.has("forces on spheres") : forces.any()) a("forces on spheres", forces);
  archive_bonding(a);
}

Bed::State Bed::save() const {
  if (impl_->by_engine.began) impl_->take_back(true);
  return impl_->state();
}

Bed::State Bed::Impl::state() {
  particles.sync_from_mixed(threads);
  region.keep(particles.spheres());
  Impl& d = *this;
  State out;
  const auto spheres = d.particles.spheres();
  const auto id = [&](std::uint32_t i) { return spheres[i].id; };
  out.spheres.assign(spheres.begin(), spheres.end());
  if (!d.region.on())
    for (Sphere& s : out.spheres) s.calm = 0;
  for (const PairHistories& part :
       d.contacts.empty() ? d.contacts.waiting() : d.contacts.histories(d.laws, d.threads)) {
    for (const PairHistory& p : part.pairs) out.pairs.push_back({id(p.i), id(p.j), p.state});
    for (const BondHistory& b : part.bonds) out.bonds.push_back({id(b.i), id(b.j), b.state});
  }
  for (const SurfaceHistory& c : d.contacts.empty() ? d.surfaces.waiting : d.surfaces.histories(d.laws))
    out.surfaces.push_back({id(c.sphere), c.boundary, c.normal, c.state});
  d.archive(out.parts);
  d.save_lists(out.parts);
  return out;
}

void Bed::Impl::take_contacts(const State& in, const std::function<std::uint32_t(std::uint32_t)>& place) {
  PairHistories& waiting = contacts.begin_waiting();
  for (const PairHistory& p : in.pairs) waiting.pairs.push_back({place(p.i), place(p.j), p.state});
  for (const BondHistory& b : in.bonds) waiting.bonds.push_back({place(b.i), place(b.j), b.state});
  for (const SurfaceHistory& c : in.surfaces) {
    if (c.boundary >= boundaries.size())
      throw std::invalid_argument(
          "restart: a contact of the state names a surface that is not there; the file is "
          "damaged");
    surfaces.waiting.push_back({place(c.sphere), c.boundary, c.normal, c.state});
  }
}

void Bed::insert(const State& part) {
  Impl& d = *impl_;
  d.set_histories_aside();
  d.particles.sync_from_mixed(d.threads);
  d.particles.drop_images();
  if (d.particles.size() + part.spheres.size() > kMostSpheres)
    throw std::invalid_argument("a bed holds " + std::to_string(kMostSpheres) + " spheres at most");
  std::unordered_map<std::uint32_t, std::uint32_t> index;
  index.reserve(d.particles.size() + part.spheres.size());
  for (std::uint32_t k = 0; k < d.particles.size(); ++k) index[d.particles[k].id] = k;
  for (const Sphere& s : part.spheres) {
    if (!index.emplace(s.id, static_cast<std::uint32_t>(d.particles.size())).second)
      throw std::invalid_argument("the bed has a sphere of number " + std::to_string(s.id) + " already");
    d.particles.restore(d.checked(s));
  }
  d.take_contacts(part, [&](std::uint32_t id) {
    const auto found = index.find(id);
    if (found == index.end())
      throw std::invalid_argument("a contact names sphere " + std::to_string(id) + ", which is not there");
    return found->second;
  });
  for (const BondHistory& b : part.bonds) {
    const int law = d.laws.between(d.particles[index.at(b.i)].material, d.particles[index.at(b.j)].material);
    if (law < 0 || d.laws[static_cast<std::uint32_t>(law)]->bond() == nullptr)
      throw std::invalid_argument("spheres " + std::to_string(b.i) + " and " + std::to_string(b.j) +
                                  " come bonded, and their law has no bond");
  }
  d.bonds.count.formed += part.bonds.size();
  d.criterion.invalidate();
}

void Bed::restore(const State& in) {
  Impl& d = *impl_;
  d.particles.clear();
  std::unordered_map<std::uint32_t, std::uint32_t> index;
  index.reserve(in.spheres.size());
  for (const Sphere& s : in.spheres) {
    index[s.id] = static_cast<std::uint32_t>(d.particles.size());
    d.particles.restore(d.checked(s));
  }
  // Histories wait for the first lists, by place of the spheres.
  d.clear_lists();
  d.take_contacts(in, [&](std::uint32_t id) {
    const auto found = index.find(id);
    if (found == index.end())
      throw std::invalid_argument(
          "restart: a contact of the state names a sphere that it does not hold; the file is "
          "damaged");
    return found->second;
  });
  Archive parts = in.parts.to_read();
  d.archive(parts);
  d.clumps.find_members([&](std::uint32_t id) { return index.contains(id); });
  d.restore_lists(parts);
  parts.end();
}

}  // namespace subsoil::dem
