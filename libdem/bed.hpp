#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/base/fault.hpp"
#include "libdem/contacts/bond_record.hpp"
#include "libdem/contacts/contact_record.hpp"
#include "libdem/contacts/histories.hpp"
#include "libdem/geometry/boundary.hpp"
#include "libdem/laws/law_table.hpp"
#include "libdem/particles/clump.hpp"
#include "libdem/particles/fixed.hpp"
#include "libdem/particles/particles.hpp"
#include "libdem/particles/periodic.hpp"
#include "libdem/sphere_force.hpp"

namespace subsoil::dem {

/// Which spheres may sleep: those of particle blocks that are farther than `within` from every moving surface and
/// that stay slow, with all blocks around them (docs/theory, section 8.1).
struct ActiveRule {
  double within = 0;  ///< m, from the box around a moving surface (a plane: from itself)
  double below = 0;   ///< m/s, of centres; 0: by gravity and the mean diameter
};

struct BedOptions {
  Vec3 gravity{0, -9.81, 0};  ///< m/s2
  int threads = 0;            ///< 0: one per 1,000 spheres, at most all that OpenMP offers
  std::string simd = "auto";  ///< kernel by name
  Precision precision = Precision::doubles;
  int cache_blocks = 0;        ///< into which a wide bed is cut; 0: by its size
  double skin = 0;             ///< m by which neighbours are listed beyond the cutoff; 0: 0.4 of the mean radius
  double speed_limit = 50;     ///< m/s; a faster sphere stops the run
  double overlap_limit = 0.5;  ///< share of the radius; a deeper contact stops the run
  /// Steps per sample of what contacts between spheres and on flat faces lose; 0: every step up to 5,000 spheres, else
  /// every 32nd, each block of 256 spheres in steps of its own. A sample costs nearly a step more, twice, and stands
  /// for all steps since the last one; edges, corners and curved surfaces are always summed.
  int sample_every = 0;
  double floor_drop = -1e300;  ///< y below which spheres are removed, m
  /// Spheres are put back into it whenever the lists are built; until then they may be outside by the skin. Boundaries
  /// meet spheres where these are and have no images: one that ends at a periodic side must not come near to it, one
  /// that spans the period must reach beyond both sides by more than a radius.
  PeriodicCell periodic{};
};

/// Energy balance of the bed, J (BedOptions::sample_every: losses may be sampled). Closure: kinetic + rotational +
/// gravity + stored + lost + `frozen` = start + boundary work + force work.
struct BedEnergy {
  double kinetic = 0;        ///< of translation, (m/2) v_{n-1/2} . v_{n+1/2}: what leapfrog work sums to
  double rotational = 0;     ///< of rotation, same form
  double gravity = 0;        ///< -m g . x
  double stored = 0;         ///< in contact springs and attraction (negative)
  Losses lost;               ///< since the start
  double boundary_work = 0;  ///< done by the surfaces and fixed spheres on the others since the start
  double force_work = 0;     ///< done by forces of users since the start
  /// Kinetic and potential energy that left with removed spheres and with those that were fixed on the way, less that
  /// of released ones; what `count_removed` received; less what gravity along a periodic direction gave to spheres that
  /// went round, whose potential energy restarts on the other side.
  double removed = 0;
  double frozen = 0;  ///< kinetic energy that spheres had when they fell asleep, since the start

  double total() const { return kinetic + rotational + gravity + stored + lost.total() + removed + frozen; }
  double work() const { return boundary_work + force_work; }  ///< done from outside
};

/// Where the time of the steps went, s, summed over threads.
struct Phases {
  double search = 0;    ///< building the lists
  double pairs = 0;     ///< contacts between spheres: force and its sum
  double surfaces = 0;  ///< contacts with boundaries
  double move = 0;
  double rest = 0;  ///< waiting for other threads, sums of the step
};

class BedEngine;  // libdem/bed_engine.hpp

/// The bed of spheres and everything that touches it.
///
/// One step from t_n to t_{n+1} (leapfrog): forces at t_n from positions x_n and velocities v_{n-1/2};
/// v_{n+1/2} = v_{n-1/2} + a dt, x_{n+1} = x_n + v_{n+1/2} dt. The first step after a start or a change of dt kicks by
/// the mean of both steps, so velocities given at t = 0 are velocities at t = 0.
///
/// A step: neighbours, boundaries, forces, motion, balance (step/bed.cpp). Forces and motion are one fused sweep:
/// spheres sorted by cell and taken in particle blocks, each contact with the block of its lower index, in contact
/// blocks of eight of one law; a particle block's spheres have all their forces, and move, once its own contacts are
/// done. Every sum runs in an order that the lists alone fix, so results are the same bits for any number of threads.
class Bed {
 public:
  Bed(LawTable laws, BedOptions options);
  ~Bed();
  Bed(Bed&&) noexcept;

  void add(std::span<const SphereSpec> spheres);
  int add(Boundary boundary);       ///< index of the boundary
  int add_shape(ClumpShape shape);  ///< of clumps; its index
  /// Clumps of shapes that the bed has; their members become spheres of the bed, numbered like others. Throws
  /// std::invalid_argument for one without sense, for a number that is taken, and where spheres may sleep.
  void add(std::span<const ClumpSpec> clumps);
  /// Joins fixed spheres that lie where a clump has its members, and have their numbers, to clumps, which move from now
  /// on, from rest. Throws std::invalid_argument where such a sphere is not there, or is not fixed.
  void join(std::span<const Clump> clumps);
  /// Removes spheres for which the predicate holds, and clumps of which it holds for any sphere; returns how many
  /// spheres. Their contacts end.
  std::size_t remove_if(const std::function<bool(const Sphere&)>& predicate);

  /// Spheres for which the predicate holds keep their place from now on, as those that were added as fixed(spec) do;
  /// clumps of which it holds for any sphere fall apart into such spheres. Returns how many spheres.
  std::size_t fix_if(const std::function<bool(const Sphere&)>& predicate);
  /// Fixed spheres for which the predicate holds move from now on, from rest; returns how many.
  std::size_t release_if(const std::function<bool(const Sphere&)>& predicate);

  /// From the next step on the force acts on the spheres (libdem/sphere_force.hpp). Throws std::invalid_argument for a
  /// name that is empty or there already, where spheres may sleep, and where an engine steps them.
  void add_force(std::string name, SphereForce force);
  SphereForce& force(std::string_view name);  ///< throws std::invalid_argument where there is none
  std::span<const NamedSphereForce> forces() const;

  Boundary& boundary(int index);
  const Boundary& boundary(int index) const;
  int boundary_count() const;
  std::span<const Sphere> spheres() const;  ///< in the engine's own order
  /// The memory of spheres(), which keeps its values from now on; the bed continues on a copy of it.
  std::shared_ptr<const void> release_spheres();
  /// Spheres that are fixed, with what acted on them at t_n of the last step; in rising id.
  std::span<const FixedSphere> fixed_spheres() const;
  std::span<const Clump> clumps() const;  ///< in the order in which they came
  const std::vector<ClumpShape>& clump_shapes() const;
  /// Place in `clumps` of the clump that a sphere belongs to; -1: it is loose.
  long clump_of(const Sphere& s) const;
  double mass_of_body(const Sphere& s) const;  ///< kg, of the clump that it belongs to, else its own
  /// Solid volume that a sphere stands for, m3: of a clump's member its share in the clump, as of the mass.
  double volume_of(const Sphere& s) const;
  std::size_t removed_count() const;   ///< fallen below the floor since the start
  std::size_t touching_pairs() const;  ///< within the cutoff of their law, of each particle block when last sampled

  struct Request {
    bool energy = false;           ///< fill energy() during this step (valid at t_n)
    Snapshot* snapshot = nullptr;  ///< fill with the state at t_n
    /// Fill with all contacts that carry a force at t_n, in an order that the lists fix: costs some steps' time.
    std::vector<ContactRecord>* contacts = nullptr;
  };
  /// Advances by dt, s. Boundaries must stand at t_n. Throws BedFault; the snapshot, if asked for, is filled before.
  void step(double dt, const Request& request);
  void step(double dt) { step(dt, {}); }

  /// Throws std::invalid_argument where a period is too short for what the bed holds, or a surface comes near a
  /// periodic side without spanning the bed: as the next step would.
  void require_room();
  /// From now on bonds form, of each law once, in the first step that begins within half a step of the law's time or
  /// after it. Not before this is called: a bed that settles is not cemented yet.
  void let_bonds_form();
  /// Bonds of all laws form now, whatever their time.
  void form_bonds();
  bool has_bonding_laws() const;
  BondCount bonds() const;
  std::span<const BrokenBond> broken_bonds() const;  ///< since the start, in the order in which they broke
  std::vector<std::array<std::uint32_t, 2>> bonded_pairs() const;  ///< ids, sorted

  /// Spheres that rest far from all moving surfaces sleep from now on, or none; all are awake when it is called.
  void set_active(const std::optional<ActiveRule>& rule);
  bool freezes() const;  ///< whether there is such a rule
  std::size_t frozen_count() const;

  double time() const;
  const BedEnergy& energy() const;  ///< of the last step that asked for it
  /// Restarts the balance: losses and works are zero from here.
  void reset_energy_balance();

  /// Exchanges the laws, e.g. while settling; histories stay.
  void set_laws(LawTable laws);
  const LawTable& laws() const;
  void set_gravity(const Vec3& gravity);
  /// Moves all spheres by an offset (a settled bed to its datum); boundaries are the caller's.
  void shift(const Vec3& offset);
  /// Sets all linear and angular velocities to zero and forgets the leapfrog phase.
  void freeze();
  void set_time(double time);

  double max_speed() const;    ///< m/s at the last step
  double max_overlap() const;  ///< maximum share of a radius, of each particle block when last sampled
  /// Id of the sphere with the deepest contact as the spheres are now; goes through all contacts. The bed has spheres.
  std::uint32_t deepest_sphere() const;
  double kinetic_energy() const;  ///< of the half-step velocities, J; goes through all spheres
  long rebuilds() const;
  long steps() const;
  const char* kernel_name() const;
  /// Measures phases from now on, or no longer: about 1 % of the time.
  void measure_phases(bool on);
  Phases phases() const;
  int threads() const;
  const BedOptions& options() const;
  void set_limits(double speed, double overlap);
  void set_floor_drop(double y);  ///< height below which spheres are removed
  /// Tells the bed that a boundary's shape, material or `active` was changed; poses need no telling.
  void surfaces_changed();

  /// Full state for a restart. `restore` expects the same boundaries and laws.
  struct State {
    std::vector<Sphere> spheres;
    std::vector<PairHistory> pairs;  ///< by the spheres' ids, as those that follow
    std::vector<BondHistory> bonds;
    std::vector<SurfaceHistory> surfaces;
    Archive parts;  ///< time, sums, boundaries, clumps, bonds that broke, what the neighbour lists had come to
  };
  State save() const;
  void restore(const State& state);

  struct Impl;  ///< step/bed_impl.hpp
  /// The bed as it stands, with its lists, in memory. `restore` builds no lists and costs a copy of what steps write.
  class Checkpoint {
   public:
    Checkpoint();
    Checkpoint(Checkpoint&&) noexcept;
    Checkpoint& operator=(Checkpoint&&) noexcept;
    ~Checkpoint();
    bool is_of(const Bed& bed) const;
    State state() const;  ///< as `save` returned it then

   private:
    friend class Bed;
    std::unique_ptr<Impl> bed_;
  };
  /// Reuses the memory of `out`; of unchanged lists it copies only what steps write. Throws std::invalid_argument where
  /// an engine steps the spheres.
  void save(Checkpoint& out) const;
  /// Continues with the same bits. Throws std::invalid_argument for a checkpoint of another bed.
  void restore(const Checkpoint& to);

  /// Adds spheres with the contacts that they come with: of a state the spheres, whose ids must be new, the pairs, the
  /// bonds, which count as formed, and the contacts at surfaces; these may name spheres that are there. Throws
  /// std::invalid_argument.
  void insert(const State& part);
  /// All contacts that carry a force as the spheres are now: what a step that asks for them would report.
  std::vector<ContactRecord> contacts();
  /// Energy of contacts, J, that ended with what was removed or fixed; below zero: that came with `insert`.
  void count_removed(double energy);

  /// From the next step on the engine steps the spheres. Throws std::invalid_argument for what no engine but the bed
  /// itself can do: bonds, clumps, fixed and sleeping spheres, periodic sides, mixed precision, loads of surfaces.
  void step_by(std::unique_ptr<BedEngine> engine);
  const char* engine_name() const;  ///< null: the bed itself

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace subsoil::dem
