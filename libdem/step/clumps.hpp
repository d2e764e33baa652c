#pragma once
#include <functional>
#include <span>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/bed.hpp"
#include "libdem/contacts/particle_block.hpp"
#include "libdem/neighbours/neighbour_list.hpp"
#include "libdem/particles/clump.hpp"
#include "libdem/particles/particle_store.hpp"
#include "libdem/step/energy_balance.hpp"

namespace subsoil::dem {

class ActiveRegion;
class SphereForces;

/// Rigid grains of several spheres. Their members are spheres of the bed like others: search, lists, laws and surfaces
/// know nothing of clumps, but for two things: contacts find the clump's mass of a member (ParticleStore), so that
/// damping and restitution are those of the body that is hit, and pairs of one clump are left out of the lists.
///
/// The sweep takes the sums of forces of members from the ring and leaves their records as they are; after it each
/// clump gathers force and moment from its members, in their order, and moves (particles/rigid_rotation.hpp), in
/// leapfrog as spheres do. A member's velocity is the way of its centre in the step divided by dt, V + w x (r_n +
/// r_{n+1})/2: what contacts do work on, as a sphere's.
///
/// | data              | written by                                          | read by           |
/// |---|---|---|
/// | shapes, clumps    | users, rebuilds (removal), restarts; `move`         | users, saved state|
/// | places, by block  | rebuilds                                            | the sweep         |
/// | forces of members | the worker of the member's block, in the sweep;     | `move`, `observe` |
/// |                   | `add_forces`, after it                              |                   |
///
/// At periodic sides members go round one by one, as loose spheres do: each keeps the periods by which it lies beside
/// its place in the clump, from rebuild to rebuild. Force and moment follow from the attitude alone. The centre of mass
/// goes round with the first member.
///
/// Members are moved after the sweep and not within: they lie in several particle blocks, of several workers, and no
/// block may move its part of a clump before all forces on the clump are known. The price is a pass over the members.
class Clumps {
 public:
  static constexpr char kLeaves = 1, kFell = 2;  ///< why a clump leaves
  struct Place {
    std::uint32_t sphere;  ///< index in the store
    std::uint32_t entry;   ///< of its forces
  };
  struct Load {
    Vec3 force, torque;  ///< N, N m about the member's centre
    void archive(Archive& a) { a("force", force)("torque", torque); }
  };

  bool any() const { return !clumps_.empty(); }
  std::span<const Clump> all() const { return clumps_; }
  const std::vector<ClumpShape>& shapes() const { return shapes_; }
  int add_shape(ClumpShape shape);
  /// Adds a clump and its members, as spheres of the store, with the numbers that it asks for or the next ones.
  void add(const ClumpSpec& in, ParticleStore& particles, int materials);
  /// Adds clumps whose members are spheres of the store.
  void join(std::span<const Clump> clumps);
  /// Index of the clump that a sphere belongs to; kGone: none.
  std::uint32_t clump_of(std::uint32_t sphere_id) const {
    return sphere_id < of_id_.size() ? of_id_[sphere_id] : kGone;
  }
  double volume_share(const Sphere& s) const;  ///< m3 of the clump that count for this member
  double mass_at(std::uint32_t clump) const { return shapes_[clumps_[clump].shape].mass; }  ///< kg

  // Rebuilds.
  /// Which clumps leave: of whose members one lies below the floor, or is gone. Before the spheres leave.
  void choose_leaving(std::span<const Sphere> spheres, double floor, const std::function<bool(const Sphere&)>& gone);
  bool leaves(std::uint32_t clump) const { return !leaving_.empty() && leaving_[clump] != 0; }
  bool fell(std::uint32_t clump) const { return !leaving_.empty() && leaving_[clump] == kFell; }
  /// The predicate with all spheres of such clumps.
  std::function<bool(const Sphere&)> with_whole_clumps(const std::function<bool(const Sphere&)>& gone) const;
  /// Takes them out; returns the energy that goes with them, J.
  double take_out(const Vec3& gravity);
  /// A sphere of a clump has gone round by whole periods. Returns the energy that the clump leaves behind, J.
  double go_round(const Sphere& member, const Vec3& periods, const Vec3& gravity);
  double widest_gap() const { return widest_gap_; }  ///< between centres of two members of one clump, at most, m
  /// For new lists, before the blocks are laid out.
  void find(std::span<const Sphere> spheres, const PeriodicCell& cell);
  void drop_pairs(NeighbourList& list, const PeriodicImages& images) const;  ///< of members of one clump
  void begin_lists(std::span<const ParticleBlock> blocks);

  // The sweep.
  std::span<const Place> of_block(std::size_t block) const {
    if (first_.empty()) return {};
    return std::span(places_).subspan(first_[block], first_[block + 1] - first_[block]);
  }
  std::uint32_t clump_at(std::uint32_t sphere) const { return clump_at_[sphere]; }  ///< by index, of the lists
  Load& load(const Place& p) { return loads_[p.entry]; }
  /// Indices of a clump's spheres in the store, in the lists.
  std::span<const std::uint32_t> members(std::size_t clump) const {
    return std::span(sphere_of_).subspan(begin_[clump], begin_[clump + 1] - begin_[clump]);
  }

  // After it.
  /// Adds forces of users to those of the contacts, at the motion of t_n. @param before the step before t_n, s
  void add_forces(SphereForces& forces, const ParticleStore& particles, const Vec3& gravity, double time, double before,
                  int threads);
  /// Of these, by the velocities of the members' records, W.
  double power_of_forces(const ParticleStore& particles) const;
  /// Energies at t_n, in leapfrog's form (BedEnergy). @param before the step before t_n, s @param dt the one after it
  BodyEnergy energy(const ActiveRegion& region, const Vec3& gravity, double before, double dt) const;
  /// Motion of the members at t_n and their share of the weight.
  void complete(Snapshot& snapshot, const ActiveRegion& region, const ParticleStore& particles, const Vec3& gravity,
                double before) const;
  /// Kick and drift of all clumps that are awake, and their members to where they are then. Those that sleep are
  /// checked, those that fall asleep stop. Returns the kinetic energy of the latter, J.
  double move(ActiveRegion& region, ParticleStore& particles, const Vec3& gravity, double before, double dt,
              int threads);
  /// Extremes of velocities of the particle blocks with members, after the move.
  void extremes(const ActiveRegion& region, std::span<const ParticleBlock> blocks, const ParticleStore& particles,
                int threads, const std::function<void(std::size_t block, double speed2, double squares)>& use) const;

  void shift(const Vec3& offset);
  void stop();  ///< neither velocity nor rotation

  void archive(Archive& a);        ///< the shapes stay
  void archive_lists(Archive& a);  ///< what members bear that sleep stays as it was summed last
  /// After that. Throws std::invalid_argument where a clump lacks a member. @param there whether the bed has a sphere
  /// of this id
  void find_members(const std::function<bool(std::uint32_t)>& there);

 private:
  struct Loaded {
    Vec3 force, moment;
  };
  Loaded gathered(std::size_t clump) const;  ///< from the contacts of its members
  BodyEnergy energy_of(std::size_t clump, const Vec3& gravity, double before, double dt) const;
  void check(ActiveRegion& region, std::size_t clump, const Vec3& gravity) const;
  void number_spheres();

  std::vector<ClumpShape> shapes_;
  std::vector<std::vector<double>> shares_;  ///< of each shape's members in its mass
  double widest_gap_ = 0;                    ///< of all shapes, m
  std::vector<Clump> clumps_;                ///< in the order in which they came
  std::uint32_t next_id_ = 0;
  std::vector<std::uint32_t> of_id_;      ///< clump by id of the sphere
  std::vector<std::uint32_t> clump_at_;   ///< clump by index of the sphere
  std::vector<Place> places_;             ///< in rising index
  std::vector<std::uint32_t> first_;      ///< place, by particle block
  std::vector<Load> loads_;               ///< members in their order, clump by clump
  std::vector<Load> own_;                 ///< of users, likewise, in them; empty without such forces
  std::vector<std::uint32_t> begin_;      ///< of each clump in it
  std::vector<std::uint32_t> sphere_of_;  ///< index in the store, by entry
  std::vector<Vec3> periods_;             ///< from the place in its clump to the sphere, by entry, m
  std::vector<char> leaving_;
};

}  // namespace subsoil::dem
