#include "libdem/contacts/surface_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <variant>

#include "libdem/geometry/world_box.hpp"
#include "libdem/particles/fixed.hpp"

/// Which spheres are near which boundaries, and where their contacts lie.
namespace subsoil::dem {

struct SurfaceContacts::OnFace {
  std::uint32_t sphere, boundary, law;
  FlatFace face;
};

namespace {

/// A plane in world axes. Most spheres are far from it, which a dot product shows in place of a rotation.
struct WorldPlane {
  Vec3 point, normal;

  static std::optional<WorldPlane> of(const Boundary& b) {
    const auto* plane = std::get_if<Plane>(&b.shape);
    if (plane == nullptr) return std::nullopt;
    return WorldPlane{b.pose.to_world(plane->point()), b.pose.attitude.rotate(plane->normal())};
  }
  /// By more than what roundings may change: what the plane in its own axes would take is never lost.
  bool is_beyond(const Vec3& x, double near) const {
    const Vec3 d = x - point;
    const double size = std::abs(x.x) + std::abs(x.y) + std::abs(x.z) + std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    return dot(d, normal) > near + 1e-12 * size;
  }
  /// Of a box: then it is of all points in there.
  bool is_beyond(const Bounds& box, double near) const {
    double nearest = 0, size = 0;
    for (int k = 0; k < 3; ++k) {
      const double low = box.low[k] - point[k], high = box.high[k] - point[k];
      nearest += std::min(normal[k] * low, normal[k] * high);
      size += std::max(std::abs(box.low[k]), std::abs(box.high[k])) + std::max(std::abs(low), std::abs(high));
    }
    return nearest > near + 4e-12 * size;
  }
};

/// Square of the distance of two boxes. From a point of one to the other it is no less, to the last bit.
double distance_squared(const Bounds& a, const Bounds& b) {
  Vec3 out;
  for (int k = 0; k < 3; ++k) out[k] = std::max({a.low[k] - b.high[k], 0.0, b.low[k] - a.high[k]});
  return dot(out, out);
}

}  // namespace

/// Some spheres that follow each other, which the sort has put side by side: few of them are near any boundary.
struct SurfaceContacts::Group {
  static constexpr std::uint32_t kSpheres = 64;
  Bounds box;         ///< of the centres
  double radius = 0;  ///< maximum

  static std::vector<Group> all(const ParticleStore& particles, int threads) {
    std::vector<Group> out((particles.size() + kSpheres - 1) / kSpheres);
    const auto count = static_cast<long>(out.size());
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long k = 0; k < count; ++k) {
      Group& g = out[static_cast<std::size_t>(k)];
      const std::size_t first = static_cast<std::size_t>(k) * kSpheres;
      for (std::size_t i = first; i < std::min<std::size_t>(first + kSpheres, particles.size()); ++i) {
        const Sphere& s = particles[static_cast<std::uint32_t>(i)];
        g.box.include(s.x), g.radius = std::max(g.radius, s.r);
      }
    }
    return out;
  }
};

/// What one thread found near one boundary.
struct SurfaceContacts::Found {
  std::vector<OnFace> faces;
  std::vector<SurfaceEntry> entries;
  std::vector<std::uint32_t> candidates;
};

void SurfaceContacts::build(const ParticleStore& particles, std::vector<Boundary>& boundaries, const ContactLaws& laws,
                            double skin, int threads) {
  entries.clear(), candidates.clear(), chunks.clear();
  of_block.assign((particles.size() + kParticleBlock - 1) / kParticleBlock, {});
  std::vector<Found> found(static_cast<std::size_t>(threads));
  std::vector<OnFace> faces;
  const std::vector<Group> groups = Group::all(particles, threads);
  for (std::uint32_t b = 0; b < boundaries.size(); ++b) {
    if (!boundaries[b].active) continue;
    const auto* mesh = std::get_if<MeshSurface>(&boundaries[b].shape);
    const std::size_t meshes = mesh != nullptr ? mesh->surfaces().size() : 1;
    boundaries[b].meshes.assign(meshes > 1 ? meshes : 0, {});
    search(b, boundaries[b], particles, groups, laws, skin, found, faces);
  }
  order_entries();
  lay_out_planes(faces, laws);
}

void SurfaceContacts::search(std::uint32_t b, const Boundary& boundary, const ParticleStore& particles,
                             const std::vector<Group>& groups, const ContactLaws& laws, double skin,
                             std::vector<Found>& found, std::vector<OnFace>& faces) {
  const Bounds box = bounds(boundary.shape), in_world = world_box(box, boundary.pose);
  const std::optional<WorldPlane> plane = WorldPlane::of(boundary);
  const std::size_t count = particles.size(), first = entries.size(), parts = found.size();
  const int threads = static_cast<int>(parts);
  double reach = skin;  // beyond the radius
  for (std::uint32_t law = 0; law < laws.count(); ++law) reach = std::max(reach, laws.surface_cutoff(law) + skin);
  const auto is_far = [&](const Group& g) {
    const double near = g.radius + reach;
    return plane ? plane->is_beyond(g.box, near) : distance_squared(in_world, g.box) > near * near;
  };
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    Found& mine = found[static_cast<std::size_t>(t)];
    mine = {};
    const std::size_t begin = count * static_cast<std::size_t>(t) / parts;
    const std::size_t end = count * static_cast<std::size_t>(t + 1) / parts;
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      if ((i % Group::kSpheres == 0 || i == begin) && is_far(groups[i / Group::kSpheres])) {
        i |= Group::kSpheres - 1;
        continue;
      }
      const Sphere& s = particles[i];
      const int law = laws.between(s.material, boundary.material);
      const bool held = is_fixed(s);
      if (law < 0 || (held && !boundary.meets_fixed)) continue;
      const double near = s.r + laws.surface_cutoff(static_cast<std::uint32_t>(law)) + skin;
      if (plane ? plane->is_beyond(s.x, near) : in_world.distance_squared(s.x) > near * near) continue;
      const Vec3 c = boundary.pose.to_local(s.x);
      if (box.distance_squared(c) > near * near) continue;
      const std::size_t before = mine.candidates.size();
      dem::candidates(boundary.shape, c, near, mine.candidates);
      if (mine.candidates.size() == before) continue;
      const std::span<const std::uint32_t> close(mine.candidates.data() + before, mine.candidates.size() - before);
      // Planes take the masses that pairs find, which of fixed spheres are not their own.
      // At a blade every contact may be one at its edge, and is looked at alone.
      if (const auto face =
              held || !boundary.edges.empty() ? std::nullopt : flat_face(boundary.shape, c, skin, close)) {
        mine.faces.push_back({i, b, static_cast<std::uint32_t>(law), *face});
        mine.candidates.resize(before);
        continue;
      }
      SurfaceEntry& e = mine.entries.emplace_back();
      e.sphere = i, e.boundary = b;
      e.candidates_begin = static_cast<std::uint32_t>(before);
      e.candidates_end = static_cast<std::uint32_t>(mine.candidates.size());
    }
  }
  for (const Found& mine : found) {
    const auto shift = static_cast<std::uint32_t>(candidates.size());
    candidates.insert(candidates.end(), mine.candidates.begin(), mine.candidates.end());
    for (SurfaceEntry e : mine.entries) {
      e.candidates_begin += shift, e.candidates_end += shift;
      entries.push_back(e);
    }
    faces.insert(faces.end(), mine.faces.begin(), mine.faces.end());
  }
  for (std::size_t begin = first; begin < entries.size(); begin += kParticleBlock)
    chunks.push_back({.boundary = b,
                      .begin = static_cast<std::uint32_t>(begin),
                      .end = static_cast<std::uint32_t>(std::min<std::size_t>(begin + kParticleBlock, entries.size())),
                      .wrench = {},
                      .meshes = std::vector<Wrench>(boundary.meshes.size()),
                      .lost = {}});
}

void SurfaceContacts::order_entries() {
  entry_order.resize(entries.size());
  std::iota(entry_order.begin(), entry_order.end(), 0u);
  std::stable_sort(entry_order.begin(), entry_order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return entries[a].sphere < entries[b].sphere; });
  std::uint32_t at = 0;
  for (std::size_t k = 0; k < of_block.size(); ++k) {
    of_block[k].entries_begin = at;
    while (at < entries.size() && entries[entry_order[at]].sphere < (k + 1) * kParticleBlock) ++at;
    of_block[k].entries_end = at;
  }
}

/// By particle block, then boundary and its mesh, then law, then sphere.
void SurfaceContacts::lay_out_planes(std::vector<OnFace>& faces, const ContactLaws& laws) {
  const auto key = [](const OnFace& f) {
    return std::array{f.sphere / kParticleBlock, f.boundary, f.face.surface, f.law};
  };
  std::stable_sort(faces.begin(), faces.end(), [&](const OnFace& a, const OnFace& b) { return key(a) < key(b); });
  plane_runs.clear(), plane_blocks.clear();
  std::size_t line = 0, k = 0;
  for (std::size_t block = 0; block < of_block.size(); ++block) {
    of_block[block].planes_begin = static_cast<std::uint32_t>(plane_runs.size());
    while (k < faces.size() && faces[k].sphere < (block + 1) * kParticleBlock) {
      const std::size_t head = k;
      PlaneRun run{.boundary = faces[k].boundary,
                   .mesh = faces[k].face.surface,
                   .law = faces[k].law,
                   .first = static_cast<std::uint32_t>(plane_blocks.size()),
                   .blocks = 0,
                   .contacts = 0,
                   .lines = line,
                   .wrench = {}};
      for (; k < faces.size() && key(faces[k]) == key(faces[head]); ++k) write_plane(faces[k], run.contacts++ % kBlock);
      run.blocks = static_cast<std::uint32_t>(plane_blocks.size()) - run.first;
      line += laws.surface_memory(run.law).lines(run.blocks);
      plane_runs.push_back(run);
    }
    of_block[block].planes_end = static_cast<std::uint32_t>(plane_runs.size());
  }
  plane_lines.assign(line, Line{});
}

void SurfaceContacts::write_plane(const OnFace& on, std::uint32_t lane) {
  if (lane == 0) plane_blocks.emplace_back();
  PlaneBlock& p = plane_blocks.back();
  for (std::uint32_t l = lane; l < kBlock; ++l) {  // lanes beyond the last repeat it
    for (int d = 0; d < 3; ++d) p.normal[d][l] = on.face.normal[d];
    p.offset[l] = on.face.offset;
    p.sphere[l] = on.sphere;
  }
}

namespace {

/// Where the history of a sphere on a boundary goes: a lane of a plane, or an entry.
struct Place {
  std::uint64_t key;
  bool plane;
  std::uint32_t run, lane;  ///< of the plane; `lane` is the entry's index otherwise
  static std::uint64_t key_of(std::uint32_t sphere, std::uint32_t boundary) {
    return (static_cast<std::uint64_t>(sphere) << 32) | boundary;
  }
};

Vec3 normal_of(const PlaneBlock& b, std::uint32_t lane) {
  return {b.normal[0][lane], b.normal[1][lane], b.normal[2][lane]};
}

}  // namespace

void SurfaceContacts::restore_histories(const std::vector<std::uint32_t>& new_index, const ContactLaws& laws) {
  if (waiting.empty()) return;
  std::vector<Place> places;
  for (std::uint32_t r = 0; r < plane_runs.size(); ++r)
    for (std::uint32_t k = 0; k < plane_runs[r].contacts; ++k)
      places.push_back(
          {Place::key_of(plane_blocks[plane_runs[r].first + k / kBlock].sphere[k % kBlock], plane_runs[r].boundary),
           true, r, k});
  for (std::uint32_t k = 0; k < entries.size(); ++k)
    places.push_back({Place::key_of(entries[k].sphere, entries[k].boundary), false, 0, k});
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.key < b.key; });

  std::uint64_t filled = ~std::uint64_t{0};  // plane lane that got its history, and how well its normal fits
  double fit = 0;
  for (const SurfaceHistory& was : waiting) {
    if (new_index[was.sphere] == kGone) continue;
    const std::uint64_t key = Place::key_of(new_index[was.sphere], was.boundary);
    const auto at = std::lower_bound(places.begin(), places.end(), key,
                                     [](const Place& p, std::uint64_t wanted) { return p.key < wanted; });
    if (at == places.end() || at->key != key) continue;
    if (!at->plane) {
      SurfaceEntry& e = entries[at->lane];
      if (e.live < kMaxSurfaceContacts) e.contact[e.live++] = {was.state, was.normal};
      continue;
    }
    // The same contact as before if its normal is: 60 degrees, as for contacts that move over an edge.
    const PlaneRun& run = plane_runs[at->run];
    const std::uint32_t block = at->lane / kBlock, lane = at->lane % kBlock;
    const double same = dot(was.normal, normal_of(plane_blocks[run.first + block], lane));
    if (same < 0.5 || (filled == key && same <= fit)) continue;
    filled = key, fit = same;
    const MemoryShape& shape = laws.surface_memory(run.law);
    write_lane(memory(run, block, shape), shape, lane, was.state);
  }
  waiting = {};
}

std::vector<SurfaceHistory> SurfaceContacts::histories(const ContactLaws& laws) const {
  std::vector<SurfaceHistory> out;
  std::size_t contacts = 0;
  for (const PlaneRun& run : plane_runs) contacts += run.contacts;
  for (const SurfaceEntry& e : entries) contacts += e.live;
  out.reserve(contacts);
  for (const PlaneRun& run : plane_runs) {
    const MemoryShape& shape = laws.surface_memory(run.law);
    for (std::uint32_t k = 0; k < run.contacts; ++k) {
      const PlaneBlock& b = plane_blocks[run.first + k / kBlock];
      const PairState s = read_lane(memory(run, k / kBlock, shape), shape, k % kBlock);
      if (!s.empty()) out.push_back({b.sphere[k % kBlock], run.boundary, normal_of(b, k % kBlock), s});
    }
  }
  for (const SurfaceEntry& e : entries)
    for (std::uint32_t c = 0; c < e.live; ++c)
      out.push_back({e.sphere, e.boundary, e.contact[c].normal, e.contact[c].state});
  return out;
}

void SurfaceContacts::copy(const SurfaceContacts& from, bool same_lists) {
  plane_runs = from.plane_runs, plane_lines = from.plane_lines;
  entries = from.entries, chunks = from.chunks;
  waiting = from.waiting;
  if (same_lists) return;
  of_block = from.of_block, plane_blocks = from.plane_blocks;
  candidates = from.candidates, entry_order = from.entry_order;
}

void SurfaceContacts::clear() {
  of_block.clear();
  plane_runs.clear(), plane_blocks.clear(), plane_lines.clear();
  entries.clear(), candidates.clear(), entry_order.clear(), chunks.clear();
  waiting.clear();
}

void SurfaceContacts::set_aside(const ContactLaws& laws) {
  std::vector<SurfaceHistory> kept = histories(laws);
  clear();
  waiting = std::move(kept);
}

}  // namespace subsoil::dem
