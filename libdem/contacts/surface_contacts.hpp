#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "libdem/contacts/blocks.hpp"
#include "libdem/contacts/contact_laws.hpp"
#include "libdem/contacts/contact_record.hpp"
#include "libdem/contacts/histories.hpp"
#include "libdem/geometry/boundary.hpp"
#include "libdem/particles/particle_store.hpp"

namespace subsoil::dem {

inline constexpr std::size_t kMaxSurfaceContacts = 6;  ///< of one sphere with one boundary

/// One sphere near an edge, a corner or a curved surface of one boundary.
struct SurfaceEntry {
  struct Contact {
    PairState state;
    Vec3 normal;  ///< shape axes
  };
  std::uint32_t sphere = 0, boundary = 0;
  std::uint32_t candidates_begin = 0, candidates_end = 0;
  std::uint32_t live = 0;  ///< contacts in use
  std::uint32_t touching = 0;
  Vec3 force, torque;  ///< on the sphere
  Contact contact[kMaxSurfaceContacts];
};

/// A sphere at a cutting edge, or at one of its faces so near to it that the edge is in the fibre; world axes.
struct EdgeContact {
  std::uint32_t sphere, boundary;
  double force;         ///< of the edge along `outward`, N
  Vec3 normal;          ///< of the contact, to the sphere
  Vec3 along, outward;  ///< of the edge
};

/// Consecutive entries of one boundary, summed together: the unit of work and of fixed-order sums.
struct SurfaceChunk {
  std::uint32_t boundary, begin, end;
  Wrench wrench;
  std::vector<Wrench> meshes;  ///< as Boundary::meshes
  Losses lost;                 ///< running
  double stored = 0;
  int contacts = 0;
  double max_overlap = 0;
  std::uint32_t worst = 0;  ///< sphere of max_overlap
  bool records = false;     ///< whether the step asks for single contacts
  std::vector<ContactRecord> recorded{};
  std::vector<EdgeContact> at_edges{};
};

/// Spheres of one particle block on flat faces of one mesh of a boundary, of one law.
struct PlaneRun {
  std::uint32_t boundary, mesh, law, first, blocks, contacts;  ///< `first` counts in PlaneBlock
  std::size_t lines;
  Wrench wrench;
  double in_reach = 0, stored = 0;
};

/// Contacts of spheres with boundaries. A sphere that can touch nothing but one flat face of a boundary while the lists
/// hold (walls, floors, plates, the sides of a tool) goes to the blocks of a plane; the rest, at edges, corners and
/// curved surfaces, is an entry that is looked at alone.
///
/// | data                       | written by                                                  | read by          |
/// |---|---|---|
/// | plane_blocks, of_block     | rebuilds                                                    | every worker     |
/// | plane_runs: wrench, ...    | the worker of the run's particle block                      | sums of the step |
/// | plane_lines (histories)    | kernels, by the same worker                                 | the same         |
/// | candidates, entry_order    | rebuilds                                                    | every worker     |
/// | entries: contacts, force   | the worker whose share of chunks they are in, before the    | the worker of    |
/// |                            | sweep                                                       | the sphere       |
/// | chunks                     | likewise; `records` before the step                         | sums of the step |
/// | waiting                    | restarts and exchanges of laws                              | the next rebuild |
///
/// Layout: planes lie by particle block, so that the sweep meets them with the spheres; eight to a block, whose
/// geometry is four numbers, without a look at the shape. Entries lie by boundary, since the search for contacts
/// touches triangles (hundreds of bytes each) that neighbours on a surface share; their forces go to the spheres by
/// `entry_order`. One list for both would look at the triangles of a wall for each of its spheres in every step.
class SurfaceContacts {
 public:
  /// Contacts of the spheres of one particle block.
  struct OfBlock {
    std::uint32_t planes_begin = 0, planes_end = 0;
    std::uint32_t entries_begin = 0, entries_end = 0;  ///< in entry_order
  };
  std::vector<OfBlock> of_block;
  std::vector<PlaneRun> plane_runs;
  std::vector<PlaneBlock> plane_blocks;
  std::vector<Line> plane_lines;
  std::vector<SurfaceEntry> entries;
  std::vector<std::uint32_t> candidates;   ///< parts of a shape, of all entries
  std::vector<std::uint32_t> entry_order;  ///< entries by sphere, then boundary
  std::vector<SurfaceChunk> chunks;
  std::vector<SurfaceHistory> waiting;  ///< between two lists, by index of the spheres

  /// Makes room for the answers of each boundary by mesh, and finds all contacts that may come within the cutoff of
  /// their law while spheres and surfaces approach by the skin, m.
  void build(const ParticleStore& particles, std::vector<Boundary>& boundaries, const ContactLaws& laws, double skin,
             int threads);
  /// What waits, into the new lists. @param new_index of the spheres
  void restore_histories(const std::vector<std::uint32_t>& new_index, const ContactLaws& laws);
  std::vector<SurfaceHistory> histories(const ContactLaws& laws) const;  ///< all that are not empty
  /// As ContactStore::copy.
  void copy(const SurfaceContacts& from, bool same_lists);
  void clear();                             ///< lists and what waits
  void set_aside(const ContactLaws& laws);  ///< takes all histories out of the lists and ends these

  /// Histories of one block of a plane, for reading and writing.
  BlockMemory memory(const PlaneRun& run, std::size_t block, const MemoryShape& shape) const {
    return BlockMemory::at(const_cast<Line*>(plane_lines.data()) + run.lines, run.blocks, shape, block);
  }

 private:
  struct OnFace;
  struct Found;
  struct Group;
  void search(std::uint32_t boundary, const Boundary& b, const ParticleStore& particles,
              const std::vector<Group>& groups, const ContactLaws& laws, double skin, std::vector<Found>& found,
              std::vector<OnFace>& faces);
  void order_entries();
  void lay_out_planes(std::vector<OnFace>& faces, const ContactLaws& laws);
  void write_plane(const OnFace& face, std::uint32_t lane);
};

}  // namespace subsoil::dem
