#include <functional>
#include <span>
#include <stdexcept>
#include <unordered_map>

#include "libdem/step/bed_impl.hpp"
#include "libdem/step/state_numbers.hpp"

/// How far the lists had come when a bed was saved. Order of sums, and so the last bits, follow the lists; these follow
/// from where spheres and boundaries were when they were built. So a restart builds them from there, puts the spheres
/// where they are, and takes over what has been added up since.
///
/// The numbers are the last of State::scalars. Where the next step builds new lists anyway their count stands alone;
/// taken away by hand, lists are built where the spheres are now, which is right but for rounding.
namespace subsoil::dem {
namespace {

void put(std::vector<double>& out, const Losses& l) {
  out.insert(out.end(), {l.damping, l.sliding, l.rolling, l.breaking});
}
Losses losses(StateReader& next) {
  Losses l;
  l.damping = next(), l.sliding = next(), l.rolling = next(), l.breaking = next();
  return l;
}

}  // namespace

void Bed::Impl::save_lists(std::vector<double>& to) const {
  if (contacts.empty() || criterion.is_stale()) {  // the next step builds new ones: their number alone
    to.push_back(static_cast<double>(now.rebuilds));
    return;
  }
  to.insert(to.end(), {static_cast<double>(particles.size()), static_cast<double>(contacts.particle_blocks.size()),
                       static_cast<double>(contacts.runs.size()), static_cast<double>(surfaces.chunks.size()),
                       criterion.skin(), static_cast<double>(now.rebuilds)});
  for (std::size_t i = 0; i < particles.size(); ++i) put(to, criterion.listed_place(i));
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const Pose& was = criterion.listed_poses()[b];
    put(to, was.position);
    to.insert(to.end(), {was.attitude.w, was.attitude.x, was.attitude.y, was.attitude.z,
                         criterion.listed_active()[b] != 0 ? 1.0 : 0.0, static_cast<double>(boundaries[b].contacts)});
  }
  criterion.save(to);
  paths.save(to);
  for (const PairRun& run : contacts.runs) {
    if (!run.candidates) continue;
    to.push_back(run.activation);
    to.insert(to.end(), contacts.activation.data() + run.first, contacts.activation.data() + run.first + run.blocks);
  }
  to.insert(to.end(),
            {static_cast<double>(balance.sampling().late()), balance.sampling().lists_were_new() ? 1.0 : 0.0});
  put(to, balance.lost_before);
  for (const BlockSums& b : balance.of_block) {
    put(to, b.lost);
    to.insert(to.end(), {b.stored, b.pairs, b.overlap});
  }
  for (const SurfaceChunk& c : surfaces.chunks) put(to, c.lost);
  to.push_back(balance.frozen_before);
  region.save_lists(to, balance.of_block);
}

void Bed::Impl::restore_lists(std::span<const double> from) {
  StateReader next{from};
  if (from.size() == 1) {
    now.rebuilds = static_cast<long>(next());
    return;
  }
  const double spheres = next(), blocks = next(), runs = next(), chunks = next(), skin = next();
  const auto rebuilds = static_cast<long>(next());
  const auto refuse = [] {
    throw std::invalid_argument(
        "restart: the state of the neighbour lists does not belong to its spheres; the file is damaged, or of another "
        "scenario");
  };
  if (spheres != static_cast<double>(particles.size()) || !(skin > 0)) refuse();

  // As things stood when the lists were built. No sphere may leave now that did not then.
  std::vector<Vec3> place;
  for (Sphere& s : particles.spheres()) {
    place.push_back(s.x);
    s.x = next.vector();
  }
  std::vector<Pose> pose;
  std::vector<char> active;
  for (Boundary& b : boundaries) {
    pose.push_back(b.pose), active.push_back(b.active);
    b.pose.position = next.vector();
    Quaternion& q = b.pose.attitude;
    q.w = next(), q.x = next(), q.y = next(), q.z = next();
    b.active = next() != 0;
    b.contacts = static_cast<int>(next());
  }
  const BedOptions given = options;
  options.skin = skin, options.floor_drop = -1e300;
  std::vector<std::uint32_t> id;
  for (const Sphere& s : particles.spheres()) id.push_back(s.id);
  const BondCount bonded = bonds.count;
  const Losses lost = balance.lost_before;
  rebuild();
  options = given;
  bool same = particles.size() == id.size();  // lists: the spheres were sorted already
  for (std::size_t k = 0; k < particles.size() && same; ++k) same = same && particles[k].id == id[k];
  if (same) {
    for (std::size_t k = 0; k < particles.size(); ++k) particles.spheres()[k].x = place[k];
  } else {
    std::unordered_map<std::uint32_t, std::size_t> index;
    for (std::size_t k = 0; k < id.size(); ++k) index[id[k]] = k;
    for (Sphere& s : particles.spheres()) s.x = place[index.at(s.id)];
  }
  particles.sync_to_mixed(threads);
  for (std::size_t b = 0; b < boundaries.size(); ++b)
    boundaries[b].pose = pose[b], boundaries[b].active = active[b] != 0;
  bonds.count = bonded, balance.lost_before = lost;
  now.rebuilds = rebuilds;
  if (!same || blocks != static_cast<double>(contacts.particle_blocks.size()) ||
      runs != static_cast<double>(contacts.runs.size()) || chunks != static_cast<double>(surfaces.chunks.size())) {
    criterion.invalidate();  // laws of another cutoff: nothing of the old lists holds, the next step builds new ones
    return;
  }

  criterion.restore(std::ref(next));
  paths.restore(std::ref(next));
  for (PairRun& run : contacts.runs) {
    if (!run.candidates) continue;
    run.activation = next();
    for (std::uint32_t k = 0; k < run.blocks; ++k) contacts.activation[run.first + k] = next();
  }
  const int late = static_cast<int>(next());
  balance.sampling().go_on(late, next() != 0);
  balance.lost_before = losses(next);
  for (BlockSums& b : balance.of_block) {
    b.lost = losses(next);
    b.stored = next(), b.pairs = next(), b.overlap = next();
  }
  for (SurfaceChunk& c : surfaces.chunks) c.lost = losses(next);
  balance.frozen_before = next();
  region.restore_lists(next, balance.of_block);
  if (next.at != from.size()) refuse();
}

}  // namespace subsoil::dem
