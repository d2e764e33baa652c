#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "libdem/bed_engine.hpp"
#include "libdem/contacts/bonds.hpp"
#include "libdem/contacts/contact_laws.hpp"
#include "libdem/contacts/contact_store.hpp"
#include "libdem/contacts/surface_contacts.hpp"
#include "libdem/neighbours/rebuild_criterion.hpp"
#include "libdem/particles/particle_store.hpp"
#include "libdem/step/active_region.hpp"
#include "libdem/step/clumps.hpp"
#include "libdem/step/energy_balance.hpp"
#include "libdem/step/fixed_spheres.hpp"
#include "libdem/step/observed_contacts.hpp"
#include "libdem/step/sphere_forces.hpp"
#include "libdem/step/work_partition.hpp"

/// The room of the step, private to libdem: what Bed (libdem/bed.hpp) is made of. Read `Bed::step` (bed.cpp) first,
/// then rebuild.cpp (new lists) and sweep.cpp (forces and motion).
namespace subsoil::dem {

/// Adds the time between its calls to one phase after the other; idle unless asked.
class PhaseClock {
 public:
  explicit PhaseClock(bool on) : on_(on), last_(on ? WorkerTimer::now() : 0) {}
  void end(double& phase) {
    if (!on_) return;
    const double t = WorkerTimer::now();
    phase += t - last_;
    last_ = t;
  }

 private:
  bool on_;
  double last_;
};

/// Where the run stands; written between steps by one thread.
struct StepCount {
  double time = 0, dt_before = 0;  ///< s
  long steps = 0, rebuilds = 0;
  long sweeps = 0;  ///< this object's; never put back, since flags count by it
  std::size_t fallen = 0;
};

/// What steps the spheres in place of the bed; none: the bed itself.
struct ByEngine {
  std::unique_ptr<BedEngine> engine{};
  bool began = false;
  bool ahead = false;  ///< it has stepped since spheres last came back
};

void archive(Archive& a, const char* name, Losses& lost);

/// A bed is its parts; each part's header states who writes and who reads it. What needs several of them at once stands
/// here and is a task of the step.
struct Bed::Impl {
  BedOptions options;
  Kernel kernel;
  int threads = 1;
  ContactLaws laws;
  ParticleStore particles;
  std::vector<Boundary> boundaries;  ///< poses are the user's, answers are written after each step
  RebuildCriterion criterion;
  PathBounds paths;
  ContactStore contacts;
  SurfaceContacts surfaces;
  Bonds bonds;
  WorkPartition work;
  EnergyBalance balance;
  FixedSpheres fixed;
  Clumps clumps;
  SphereForces forces;
  ActiveRegion region;
  ObservedContacts observed;
  StepCount now;
  ByEngine by_engine;
  std::uint64_t number = next_number();  ///< of the bed, unique in the process; a checkpoint has that of its bed

  BodyEnergy energy_of_clumps;             ///< at t_n, of the last step that asked for it
  std::vector<PlaneJob> plane_jobs;        ///< by boundary, of this step
  std::vector<ContactRecord> at_surfaces;  ///< of this step, where something asks for them
  bool measures_phases = false;
  Phases phases;

  Impl(LawTable laws_in, BedOptions options_in);

  // rebuild.cpp
  bool lists_hold();
  bool update_neighbours();  ///< whether there are new lists
  /// Builds all lists; spheres that fell below the floor, or for which `gone` holds, leave.
  void rebuild(const std::function<bool(const Sphere&)>& gone = {});
  void set_histories_aside();  ///< out of the lists, before what they are laid out by changes
  void clear_lists();          ///< and what waits for the next
  void wrap();                 ///< spheres into the periodic cell
  void check_periodic_sides(const ParticleStatistics& statistics, double skin) const;
  double skin_of(const ParticleStatistics& statistics) const;
  void add_images(NeighbourList& list, const Grid& grid, const ParticleStatistics& statistics, double cutoff);

  // sweep.cpp: boundaries, forces, motion
  void place_boundaries(double elapsed);
  void sweep(double dt, const Request& request);
  void evaluate_remote(Worker& w);
  PairJob pair_job(const PairRun& run, std::size_t particle_block, const Sample& sample);

  // contact_records.cpp: single contacts, for results and for the loads of surfaces
  void begin_records(std::vector<ContactRecord>* all);
  void end_records(std::vector<ContactRecord>* all);
  void record_pairs(std::vector<ContactRecord>& out);
  void record_run(const PairRun& run, std::size_t particle_block, std::vector<ContactRecord>& out);
  void record_plane(const PlaneRun& run, std::vector<ContactRecord>& out) const;

  // bed.cpp: between two steps
  template <class Change>
  std::size_t change_spheres(const Change& change);

  // bed.cpp: what a step leaves
  void move_clumps(double dt, const Request& request);
  void form_due_bonds(double until);
  void record_broken_bonds(Snapshot* snapshot);
  void cut_bonds();
  void sum_up(bool energy);
  void sum_phases(double search, double sweep);  ///< wall time, s

  // by_engine.cpp
  void begin_engine(const State& state);
  void step_by_engine(double dt, const Request& request);
  void take_back(bool with_contacts);

  // faults.cpp
  bool within_limits() const;
  void check_faults();
  std::uint32_t deepest_sphere() const;

  // list_state.cpp
  void archive_since_listed(Archive& a);
  void save_lists(Archive& a);
  void restore_lists(Archive& a);

  // checkpoint.cpp
  void copy(const Impl& from);
  static std::uint64_t next_number();

  // state.cpp
  State state();
  const Sphere& checked(const Sphere& s) const;
  void archive(Archive& a);
  void archive_bonding(Archive& a);
  /// Contacts of a state, to wait for the next lists. @param place index of a sphere by its id
  void take_contacts(const State& in, const std::function<std::uint32_t(std::uint32_t)>& place);
};

}  // namespace subsoil::dem
