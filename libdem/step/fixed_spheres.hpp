#pragma once
#include <span>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/contacts/particle_block.hpp"
#include "libdem/neighbours/neighbour_list.hpp"
#include "libdem/particles/fixed.hpp"
#include "libdem/particles/particle_store.hpp"

namespace subsoil::dem {

/// Spheres that keep their linear and angular velocity. The kernels know nothing of them: the sweep takes the sums of
/// forces from the ring before the move and puts back afterwards x_n + v dt, v and w, so that they are moved exactly as
/// asked for, in the step of everybody else. Two of them do not meet: such pairs are left out of the lists. A surface
/// meets them where it asks for it (Boundary::meets_fixed): there is no mass that yields, and damping is that of a free
/// sphere of the same matter.
///
/// Their work is that of a boundary: half the wrenches of two instants times the path between them.
///
/// | data                     | written by                                          | read by                      |
/// |---|---|---|
/// | places, by block         | rebuilds                                            | the sweep                    |
/// | spheres                  | rebuilds; the worker of their block, in the sweep   | users, `add_work`            |
/// | work, what acted before  | `add_work`, one thread after the sweep; restarts    | energy balance, saved state  |
class FixedSpheres {
 public:
  struct Place {
    std::uint32_t sphere;  ///< index in the store
    std::uint32_t entry;   ///< in `spheres`
  };
  bool any() const { return !spheres_.empty(); }
  std::span<const FixedSphere> spheres() const { return spheres_; }  ///< in rising id
  FixedSphere& entry(const Place& p) { return spheres_[p.entry]; }

  /// For new lists, before the blocks are laid out.
  void find(std::span<const Sphere> spheres);
  /// Pairs of two of them, or their images, out of a list of neighbours.
  void drop_pairs(NeighbourList& list, const PeriodicImages& images) const;
  void begin_lists(std::span<const ParticleBlock> blocks);
  /// Those of a particle block; most have none.
  std::span<const Place> of_block(std::size_t block) const {
    if (first_.empty()) return {};
    return std::span(places_).subspan(first_[block], first_[block + 1] - first_[block]);
  }

  /// Over the step that ended at this instant and lasted `elapsed` s; none before the first.
  void add_work(double elapsed);
  double work() const { return work_; }  ///< on the other spheres, J, since the start
  void reset_work() { work_ = 0; }

  void archive(Archive& a);  ///< read before the lists are built

 private:
  struct Before {
    std::uint32_t id = 0;
    Vec3 force, torque;
    void archive(Archive& a) { a("id", id)("force", force)("torque", torque); }
  };
  const Before* before(std::uint32_t id) const;

  std::vector<FixedSphere> spheres_;
  std::vector<Before> before_;  ///< in rising id
  std::vector<Before> now_;     ///< its storage of the step before
  std::vector<Place> places_;   ///< in rising index
  std::vector<std::uint32_t> first_;
  std::vector<bool> is_fixed_;  ///< by index; empty where none is
  double work_ = 0;
};

}  // namespace subsoil::dem
