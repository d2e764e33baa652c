#include <algorithm>
#include <string>
#include <unordered_map>

#include "libdem/step/bed_impl.hpp"
#include "libdem/step/state_numbers.hpp"

/// Full state of a bed for a restart. Histories travel by sphere ids, so the lists may be built anew in any order; how
/// far they had come stands beside (list_state.cpp).
namespace subsoil::dem {
namespace {

constexpr std::size_t kBoundaryNumbers = 14, kScalars = 9;

}  // namespace

namespace {

/// Of a state without any they begin at zero: their user asks for them from now on.
void restore_loads(std::span<const double> in, std::vector<Boundary>& boundaries) {
  if (in.empty()) return;
  std::size_t faces = 0;
  for (const Boundary& b : boundaries) faces += b.loads ? b.loads->faces.size() : 0;
  if (in.size() != FaceLoad::kNumbers * faces)
    throw std::invalid_argument(
        "restart: the state has kept the loads of other surfaces than the scenario; use the scenario it was written "
        "from, or leave `wear` out of all of them");
  StateReader read{in};
  for (Boundary& b : boundaries)
    if (b.loads)
      for (FaceLoad& f : b.loads->faces)
        f.impulse = read(), f.normal_work = read(), f.shear_work = read(), f.rubbing = read(), f.cutting = read();
}

void check_arrays(const Bed::State& in) {
  const std::size_t count = in.ids.size() / 2;
  if (in.spheres.size() != 11 * count || in.pairs.size() != kPairRecord * (in.pair_ids.size() / 2) ||
      in.surfaces.size() != (3 + kPairRecord) * (in.surface_ids.size() / 2) ||
      in.bonds.size() != kBondRecord * (in.bond_ids.size() / 2) || in.broken.size() != 3 * in.broken_ids.size() ||
      (!in.calm.empty() && in.calm.size() != count) || (in.frozen.size() > 1 && in.frozen.size() != 1 + 13 * count) ||
      (!in.kinds.empty() && in.kinds.size() != count) ||
      (in.ids.size() | in.pair_ids.size() | in.surface_ids.size() | in.bond_ids.size() | in.broken_ids.size()) % 2 != 0)
    throw std::invalid_argument("restart: the arrays of the state do not belong together; the file is damaged");
}

}  // namespace

Sphere Bed::Impl::sphere_of(const State& in, std::size_t k) const {
  StateReader read{std::span<const double>(in.spheres).subspan(11 * k, 11)};
  Sphere s{};
  s.x = read.vector(), s.v = read.vector(), s.w = read.vector();
  s.r = read(), s.m = read();
  if (!in.kinds.empty() && in.kinds[k] == static_cast<std::int64_t>(SphereKind::fixed)) set_kind(s, SphereKind::fixed);
  s.id = static_cast<std::uint32_t>(in.ids[2 * k]);
  s.material = static_cast<std::uint16_t>(in.ids[2 * k + 1]);
  if (!in.calm.empty()) s.calm = static_cast<std::uint8_t>(in.calm[k]);
  if (s.material >= laws.table().materials)
    throw std::invalid_argument("restart: the state has more materials than the scenario");
  return s;
}

/// Counts, what has formed, and what broke.
void Bed::Impl::save_bonding(State& out) const {
  const auto number = [](std::size_t n) { return static_cast<double>(n); };
  out.bonding = {bonds.may_form ? 1.0 : 0.0, number(bonds.count.formed), number(bonds.count.broken_in_tension),
                 number(bonds.count.broken_in_shear), number(bonds.count.removed)};
  for (const char formed : bonds.formed) out.bonding.push_back(formed);
  for (const BrokenBond& b : bonds.broken) {
    out.broken_ids.insert(out.broken_ids.end(), {b.ids[0], b.ids[1]});
    out.broken.push_back(b.time);
    put(out.broken, b.position);
    out.broken.insert(out.broken.end(), {b.energy, b.in_tension ? 1.0 : 0.0});
  }
}

void Bed::Impl::restore_bonding(const State& in) {
  bonds.count = {}, bonds.broken.clear(), bonds.may_form = false;
  std::fill(bonds.formed.begin(), bonds.formed.end(), 0);
  if (!laws.any_bonds() && in.bonding.empty()) return;
  if (in.bonding.size() != 5 + bonds.formed.size())
    throw std::invalid_argument(
        "restart: the state has other bonds than the scenario; use the scenario it was written from");
  StateReader read{in.bonding};
  const auto count = [&] { return static_cast<std::size_t>(read()); };
  bonds.may_form = read() > 0;
  BondCount& n = bonds.count;
  n.formed = count(), n.broken_in_tension = count(), n.broken_in_shear = count(), n.removed = count();
  for (std::uint32_t law = 0; law < bonds.formed.size(); ++law) {
    bonds.formed[law] = read() > 0 ? 1 : 0;
    if (bonds.formed[law] != 0 && !laws.pair_memory(law).bonds)
      throw std::invalid_argument(
          "restart: the state has bonds of a law that has none in the scenario; use the scenario it was written from");
  }
  for (std::size_t k = 0; k < in.broken_ids.size() / 2; ++k) {
    StateReader event{std::span<const double>(in.broken).subspan(6 * k, 6)};
    BrokenBond b;
    for (std::size_t d = 0; d < 2; ++d) b.ids[d] = static_cast<std::uint32_t>(in.broken_ids[2 * k + d]);
    b.time = event(), b.position = event.vector();
    b.energy = event(), b.in_tension = event() > 0;
    bonds.broken.push_back(b);
  }
}

Bed::State Bed::save() const {
  if (impl_->by_engine.began) impl_->take_back(true);
  return impl_->state();
}

Bed::State Bed::Impl::state() {
  particles.sync_from_mixed(threads);
  region.keep(particles.spheres());
  const Impl& d = *this;
  State out;
  const bool any_fixed = std::any_of(d.particles.spheres().begin(), d.particles.spheres().end(), is_fixed);
  for (const Sphere& s : d.particles.spheres()) {
    put(out.spheres, s.x), put(out.spheres, s.v), put(out.spheres, s.w);
    out.spheres.push_back(s.r), out.spheres.push_back(own_mass(s));
    out.ids.push_back(s.id), out.ids.push_back(s.material);
    if (any_fixed) out.kinds.push_back(static_cast<std::int64_t>(s.kind));
    if (d.region.on()) out.calm.push_back(s.calm);
  }
  if (d.region.on()) out.frozen = {d.balance.frozen()};
  if (d.region.on()) d.region.save(out.frozen, d.particles.size());
  out.fixed = d.fixed.save();
  d.clumps.save(out.clumps);
  for (const Boundary& b : d.boundaries)
    if (b.loads)
      for (const FaceLoad& f : b.loads->faces)
        out.loads.insert(out.loads.end(), {f.impulse, f.normal_work, f.shear_work, f.rubbing, f.cutting});
  for (const PairHistories& part :
       d.contacts.empty() ? d.contacts.waiting() : d.contacts.histories(d.laws, d.threads)) {
    for (const PairHistory& p : part.pairs) {
      out.pair_ids.push_back(d.particles[p.i].id), out.pair_ids.push_back(d.particles[p.j].id);
      append(out.pairs, p.state);
    }
    for (const BondHistory& b : part.bonds) {
      out.bond_ids.push_back(d.particles[b.i].id), out.bond_ids.push_back(d.particles[b.j].id);
      append(out.bonds, b.state);
    }
  }
  if (d.laws.any_bonds()) d.save_bonding(out);
  for (const SurfaceHistory& c : d.contacts.empty() ? d.surfaces.waiting : d.surfaces.histories(d.laws)) {
    out.surface_ids.push_back(d.particles[c.sphere].id), out.surface_ids.push_back(c.boundary);
    put(out.surfaces, c.normal);
    append(out.surfaces, c.state);
  }
  const Losses lost = d.balance.lost(d.surfaces.chunks);
  out.scalars = {d.now.time,
                 d.now.dt_before,
                 static_cast<double>(d.now.steps),
                 static_cast<double>(d.now.fallen),
                 lost.damping,
                 lost.sliding,
                 lost.rolling,
                 d.balance.removed,
                 lost.breaking};
  for (const Boundary& b : d.boundaries) {
    put(out.scalars, b.wrench.force), put(out.scalars, b.wrench.moment);
    put(out.scalars, b.pose_before.position);
    out.scalars.insert(out.scalars.end(), {b.pose_before.attitude.w, b.pose_before.attitude.x, b.pose_before.attitude.y,
                                           b.pose_before.attitude.z, b.work});
  }
  d.save_lists(out.scalars);
  return out;
}

void Bed::Impl::take_contacts(const State& in, const std::function<std::uint32_t(std::int64_t)>& place) {
  PairHistories& waiting = contacts.begin_waiting();
  for (std::size_t k = 0; k < in.pair_ids.size() / 2; ++k)
    waiting.pairs.push_back(
        {place(in.pair_ids[2 * k]), place(in.pair_ids[2 * k + 1]), pair_state_of(in.pairs.data() + kPairRecord * k)});
  for (std::size_t k = 0; k < in.bond_ids.size() / 2; ++k)
    waiting.bonds.push_back(
        {place(in.bond_ids[2 * k]), place(in.bond_ids[2 * k + 1]), bond_memory_of(in.bonds.data() + kBondRecord * k)});
  for (std::size_t k = 0; k < in.surface_ids.size() / 2; ++k) {
    if (in.surface_ids[2 * k + 1] < 0 || in.surface_ids[2 * k + 1] >= static_cast<std::int64_t>(boundaries.size()))
      throw std::invalid_argument(
          "restart: a contact of the state names a surface that is not there; the file is "
          "damaged");
    StateReader read{std::span<const double>(in.surfaces).subspan((3 + kPairRecord) * k, 3 + kPairRecord)};
    SurfaceHistory c{
        place(in.surface_ids[2 * k]), static_cast<std::uint32_t>(in.surface_ids[2 * k + 1]), read.vector(), {}};
    c.state = pair_state_of(read.rest().data());
    surfaces.waiting.push_back(c);
  }
}

void Bed::insert(const State& part) {
  Impl& d = *impl_;
  check_arrays(part);
  d.set_histories_aside();
  d.particles.sync_from_mixed(d.threads);
  d.particles.drop_images();
  if (d.particles.size() + part.ids.size() / 2 > kMostSpheres)
    throw std::invalid_argument("a bed holds " + std::to_string(kMostSpheres) + " spheres at most");
  std::unordered_map<std::uint32_t, std::uint32_t> index;
  index.reserve(d.particles.size() + part.ids.size() / 2);
  for (std::uint32_t k = 0; k < d.particles.size(); ++k) index[d.particles[k].id] = k;
  for (std::size_t k = 0; k < part.ids.size() / 2; ++k) {
    const Sphere s = d.sphere_of(part, k);
    if (!index.emplace(s.id, static_cast<std::uint32_t>(d.particles.size())).second)
      throw std::invalid_argument("the bed has a sphere of number " + std::to_string(s.id) + " already");
    d.particles.restore(s);
  }
  d.take_contacts(part, [&](std::int64_t id) {
    const auto found = index.find(static_cast<std::uint32_t>(id));
    if (found == index.end())
      throw std::invalid_argument("a contact names sphere " + std::to_string(id) + ", which is not there");
    return found->second;
  });
  d.criterion.invalidate();
}

void Bed::restore(const State& in) {
  Impl& d = *impl_;
  // Behind them, how far the lists had come.
  if (in.scalars.size() < kScalars + kBoundaryNumbers * d.boundaries.size())
    throw std::invalid_argument(
        "restart: the state has other surfaces than the scenario, or is of an older version; use the scenario and the "
        "version it was written from");
  check_arrays(in);
  d.particles.clear();
  std::unordered_map<std::uint32_t, std::uint32_t> index;
  index.reserve(in.ids.size() / 2);
  for (std::size_t k = 0; k < in.ids.size() / 2; ++k) {
    const Sphere s = d.sphere_of(in, k);
    index[s.id] = static_cast<std::uint32_t>(k);
    d.particles.restore(s);
  }
  d.clumps.restore(in.clumps, [&](std::uint32_t id) { return index.contains(id); });
  // Histories wait for the first lists, by place of the spheres.
  d.clear_lists();
  d.region.restore(in.frozen.empty() ? std::span<const double>() : std::span(in.frozen).subspan(1));
  d.take_contacts(in, [&](std::int64_t id) {
    const auto found = index.find(static_cast<std::uint32_t>(id));
    if (found == index.end())
      throw std::invalid_argument(
          "restart: a contact of the state names a sphere that it does not hold; the file is "
          "damaged");
    return found->second;
  });
  d.restore_bonding(in);

  StateReader read{in.scalars};
  d.now.time = read(), d.now.dt_before = read();
  d.now.steps = static_cast<long>(read());
  d.now.fallen = static_cast<std::size_t>(read());
  Losses& lost = d.balance.lost_before;
  lost = {};
  lost.damping = read(), lost.sliding = read(), lost.rolling = read();
  d.balance.removed = read(), lost.breaking = read();
  d.fixed.restore(in.fixed);
  restore_loads(in.loads, d.boundaries);
  d.balance.frozen_before = in.frozen.empty() ? 0 : in.frozen.front();
  for (Boundary& b : d.boundaries) {
    b.wrench = {read.vector(), {}};
    b.wrench.moment = read.vector();
    Pose stood;  // at t_n; given anew before the next step. Walls stand where it says, shifted to their datum or not
    stood.position = read.vector();
    Quaternion& q = stood.attitude;
    q.w = read(), q.x = read(), q.y = read(), q.z = read();
    b.work = read();
    b.pose = b.pose_before = stood;
  }
  const std::span<const double> lists = read.rest();
  if (!lists.empty()) d.restore_lists(lists);
}

}  // namespace subsoil::dem
