#include <algorithm>
#include <cmath>
#include <numeric>

#include "libdem/step/bed_impl.hpp"

/// Which spheres are near which boundaries. A sphere that can touch nothing but one flat face of a boundary while the
/// lists hold (walls, floors, plates, the sides of a tool) goes to the blocks of a plane; the rest, at edges, corners
/// and curved surfaces, is looked at one by one.
namespace subsoil::dem {
namespace {

struct OnFace {
  std::uint32_t sphere, boundary, law;
  FlatFace face;
};

/// Box in world axes around a box in those of a boundary; infinite if the box is.
Bounds world_box(const Bounds& box, const Pose& pose) {
  if (!std::isfinite(norm(box.low)) || !std::isfinite(norm(box.high))) return box;
  Bounds out;
  for (int corner = 0; corner < 8; ++corner)
    out.include(pose.to_world({(corner & 1) != 0 ? box.high.x : box.low.x, (corner & 2) != 0 ? box.high.y : box.low.y,
                               (corner & 4) != 0 ? box.high.z : box.low.z}));
  // A few roundings wider, so that what the box proper would take is never lost.
  const double more = 1e-12 * (norm(out.low) + norm(out.high));
  out.low -= Vec3{more, more, more}, out.high += Vec3{more, more, more};
  return out;
}

/// What one thread found near one boundary.
struct Found {
  std::vector<OnFace> faces;
  std::vector<SurfaceEntry> entries;
  std::vector<std::uint32_t> candidates;
};

}  // namespace

void Bed::Impl::build_surfaces() {
  const std::size_t count = spheres.size();
  entries.clear(), candidates.clear(), chunks.clear();
  listed_pose.resize(boundaries.size()), listed_active.resize(boundaries.size());
  std::vector<Found> found(static_cast<std::size_t>(threads));
  std::vector<OnFace> faces;
  for (std::uint32_t b = 0; b < boundaries.size(); ++b) {
    const Boundary& boundary = boundaries[b];
    listed_pose[b] = boundary.pose;
    listed_active[b] = boundary.active;
    if (!boundary.active) continue;
    const Bounds box = bounds(boundary.shape), in_world = world_box(box, boundary.pose);
    const std::size_t first = entries.size();
#pragma omp parallel for num_threads(threads) schedule(static, 1)
    for (int t = 0; t < threads; ++t) {
      Found& mine = found[static_cast<std::size_t>(t)];
      mine = {};
      const std::size_t begin = count * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads);
      const std::size_t end = count * static_cast<std::size_t>(t + 1) / static_cast<std::size_t>(threads);
      for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
        const Sphere& s = spheres[i];
        const int law = laws.of(s.material, boundary.material);
        if (law < 0) continue;
        const double near = s.r + surface_reach[static_cast<std::size_t>(law)] + skin;
        if (in_world.distance_squared(s.x) > near * near) continue;
        const Vec3 c = boundary.pose.to_local(s.x);
        if (box.distance_squared(c) > near * near) continue;
        const std::size_t before = mine.candidates.size();
        dem::candidates(boundary.shape, c, near, mine.candidates);
        if (mine.candidates.size() == before) continue;
        const std::span<const std::uint32_t> close(mine.candidates.data() + before, mine.candidates.size() - before);
        if (const auto face = flat_face(boundary.shape, c, skin, close)) {
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
                        .lost = {}});
  }
  entry_order.resize(entries.size());
  std::iota(entry_order.begin(), entry_order.end(), 0u);
  std::stable_sort(entry_order.begin(), entry_order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return entries[a].sphere < entries[b].sphere; });
  std::uint32_t at = 0;
  for (Tile& t : tiles) {
    t.entries_begin = at;
    while (at < entries.size() && entries[entry_order[at]].sphere < t.end) ++at;
    t.entries_end = at;
  }

  // Planes: by tile, then boundary, then law, then sphere.
  std::stable_sort(faces.begin(), faces.end(), [](const OnFace& a, const OnFace& b) {
    const std::uint32_t x[3] = {a.sphere / kParticleBlock, a.boundary, a.law}, y[3] = {b.sphere / kParticleBlock, b.boundary, b.law};
    return std::lexicographical_compare(x, x + 3, y, y + 3);
  });
  plane_runs.clear(), plane_blocks.clear();
  std::size_t line = 0, k = 0;
  for (Tile& t : tiles) {
    t.planes_begin = static_cast<std::uint32_t>(plane_runs.size());
    while (k < faces.size() && faces[k].sphere < t.end) {
      const OnFace& head = faces[k];
      PlaneRun run{.boundary = head.boundary,
                   .law = head.law,
                   .first = static_cast<std::uint32_t>(plane_blocks.size()),
                   .blocks = 0,
                   .contacts = 0,
                   .lines = line,
                   .wrench = {}};
      for (;
           k < faces.size() && faces[k].sphere < t.end && faces[k].boundary == run.boundary && faces[k].law == run.law;
           ++k) {
        const std::uint32_t lane = run.contacts++ % kBlock;
        if (lane == 0) plane_blocks.emplace_back(), ++run.blocks;
        for (std::uint32_t l = lane; l < kBlock; ++l) {  // lanes beyond the last repeat it
          PlaneBlock& p = plane_blocks.back();
          for (int d = 0; d < 3; ++d) p.normal[d][l] = faces[k].face.normal[d];
          p.offset[l] = faces[k].face.offset;
          p.sphere[l] = faces[k].sphere;
        }
      }
      line += surface_memory[run.law].lines(run.blocks);
      plane_runs.push_back(run);
    }
    t.planes_end = static_cast<std::uint32_t>(plane_runs.size());
  }
  plane_lines.assign(line, Line{});
}

namespace {

/// Where the memory of a sphere on a boundary goes: a lane of a plane, or an entry.
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

void Bed::Impl::put_surfaces(std::vector<SurfaceHistory>& histories, const std::vector<std::uint32_t>& new_index) {
  if (histories.empty()) return;
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
  for (const SurfaceHistory& was : histories) {
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
    write_lane(plane_memory(run, block), surface_memory[run.law], lane, was.state);
  }
}

std::vector<SurfaceHistory> Bed::Impl::surface_histories() const {
  std::vector<SurfaceHistory> out;
  std::size_t contacts = 0;
  for (const PlaneRun& run : plane_runs) contacts += run.contacts;
  for (const SurfaceEntry& e : entries) contacts += e.live;
  out.reserve(contacts);
  for (const PlaneRun& run : plane_runs) {
    for (std::uint32_t k = 0; k < run.contacts; ++k) {
      const PlaneBlock& b = plane_blocks[run.first + k / kBlock];
      const PairState s = read_lane(plane_memory(run, k / kBlock), surface_memory[run.law], k % kBlock);
      if (!s.empty()) out.push_back({b.sphere[k % kBlock], run.boundary, normal_of(b, k % kBlock), s});
    }
  }
  for (const SurfaceEntry& e : entries)
    for (std::uint32_t c = 0; c < e.live; ++c)
      out.push_back({e.sphere, e.boundary, e.contact[c].normal, e.contact[c].state});
  return out;
}

}  // namespace subsoil::dem
