#include <stdexcept>
#include <unordered_map>

#include "libdem/step/bed_impl.hpp"

/// How far the lists had come when a bed was saved. Order of sums, and so the last bits, follow the lists; these follow
/// from where spheres and boundaries were when they were built. So a restart builds them from there, puts the spheres
/// where they are, and takes over what has been added up since.
///
/// Where the next step builds new lists anyway, or where a state is without them, lists are built where the spheres are
/// then: right but for rounding.
namespace subsoil::dem {
namespace {

/// What lists were built from, and what they look like.
struct Listed {
  std::size_t spheres = 0, blocks = 0, runs = 0, planes = 0, chunks = 0;
  double skin = 0;            ///< m
  std::vector<Vec3> places;   ///< of the spheres
  std::vector<Pose> poses;    ///< of the boundaries
  std::vector<char> active;   ///< likewise
  std::vector<int> contacts;  ///< likewise

  void archive(Archive& a) {
    a("spheres", spheres)("blocks", blocks)("runs", runs)("planes", planes)("chunks", chunks)("skin", skin)("places",
                                                                                                            places);
    std::size_t boundaries = poses.size();
    a("boundaries", boundaries);
    for (std::size_t b = 0; b < boundaries; ++b) {
      if (a.reads()) poses.emplace_back(), active.emplace_back(), contacts.emplace_back();
      a("position", poses[b].position)("attitude", poses[b].attitude);
      a("active", active[b])("contacts", contacts[b]);
    }
  }
};

}  // namespace

/// What has been added up in lists that are as they were.
void Bed::Impl::archive_since_listed(Archive& a) {
  a.group("criterion", [&] { criterion.archive(a); });
  a("paths", paths);
  for (PairRun& run : contacts.runs) {
    if (!run.candidates) continue;
    a("activation of run", run.activation);
    a("activation", std::span(contacts.activation.data() + run.first, run.blocks));
  }
  int late = balance.sampling().late();
  bool new_lists = balance.sampling().lists_were_new();
  a("samples late", late)("lists were new", new_lists);
  if (a.reads()) balance.sampling().go_on(late, new_lists);
  dem::archive(a, "lost before", balance.lost_before);
  for (BlockSums& b : balance.of_block) {
    dem::archive(a, "lost", b.lost);
    a("stored", b.stored)("pairs", b.pairs)("overlap", b.overlap);
  }
  for (SurfaceChunk& c : surfaces.chunks) dem::archive(a, "lost at surfaces", c.lost);
  // What sleeping spheres bear on flat faces stays as it was summed last.
  if (a.reads() ? a.has("flat faces") : region.on())
    a.group("flat faces", [&] {
      for (PlaneRun& r : surfaces.plane_runs)
        a("force", r.wrench.force)("moment", r.wrench.moment)("in reach", r.in_reach)("stored", r.stored);
    });
  if (a.reads() ? a.has("work of forces") : forces.any()) a.group("work of forces", [&] { forces.archive_lists(a); });
  a("frozen before", balance.frozen_before);
  a.group("sleep", [&] { region.archive_lists(a, balance.of_block); });
  if (a.reads() ? a.has("sleeping clumps") : region.on() && clumps.any())
    a.group("sleeping clumps", [&] { clumps.archive_lists(a); });
}

void Bed::Impl::save_lists(Archive& a) {
  a("rebuilds", now.rebuilds);
  if (contacts.empty() || criterion.is_stale()) return;  // the next step builds new ones
  Listed was{.spheres = particles.size(),
             .blocks = contacts.particle_blocks.size(),
             .runs = contacts.runs.size(),
             .planes = surfaces.plane_runs.size(),
             .chunks = surfaces.chunks.size(),
             .skin = criterion.skin(),
             .places = {},
             .poses = criterion.listed_poses(),
             .active = criterion.listed_active(),
             .contacts = {}};
  for (std::size_t i = 0; i < particles.size(); ++i) was.places.push_back(criterion.listed_place(i));
  for (const Boundary& b : boundaries) was.contacts.push_back(b.contacts);
  a("lists", was);
  a.group("since", [&] { archive_since_listed(a); });
}

void Bed::Impl::restore_lists(Archive& a) {
  a("rebuilds", now.rebuilds);
  if (!a.has("lists")) return;
  Listed was;
  a("lists", was);
  if (was.spheres != particles.size() || was.places.size() != was.spheres || was.poses.size() != boundaries.size() ||
      !(was.skin > 0))
    throw std::invalid_argument(
        "restart: the state of the neighbour lists does not belong to its spheres; the file is damaged, or of another "
        "scenario");
  const long rebuilds = now.rebuilds;

  // As things stood when the lists were built. No sphere may leave now that did not then.
  std::vector<Vec3> place;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    Sphere& s = particles.spheres()[i];
    place.push_back(s.x);
    s.x = was.places[i];
  }
  std::vector<Pose> pose;
  std::vector<char> active;
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    Boundary& of = boundaries[b];
    pose.push_back(of.pose), active.push_back(of.active);
    of.pose = was.poses[b], of.active = was.active[b] != 0, of.contacts = was.contacts[b];
  }
  const BedOptions given = options;
  options.skin = was.skin, options.floor_drop = -1e300;
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
  if (!same || was.blocks != contacts.particle_blocks.size() || was.runs != contacts.runs.size() ||
      was.planes != surfaces.plane_runs.size() || was.chunks != surfaces.chunks.size()) {
    criterion.invalidate();  // laws of another cutoff: nothing of the old lists holds, the next step builds new ones
    a.drop("since");
    return;
  }

  a.group("since", [&] { archive_since_listed(a); });
}

}  // namespace subsoil::dem
