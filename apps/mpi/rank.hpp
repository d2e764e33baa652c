#pragma once
#include <mpi.h>

#include <memory>
#include <span>
#include <vector>

#include "apps/mpi/styles.hpp"
#include "libdem/step/subdomain.hpp"

namespace subsoil::mpi {

/// What all processes know of a bed before any of them has spheres.
struct Beginning {
  dem::Vec3 gravity;
  dem::Vec3 low, high;                         ///< box around the centres of all spheres, m
  double smallest = 0, largest = 0, skin = 0;  ///< radii; by which neighbours are listed beyond the cutoff, m
  double floor_drop = 0;                       ///< y below which spheres are removed, m
  std::size_t spheres = 0;
  int sample_every = 0;
  char simd[16] = "auto";
};

/// One process of a bed on many. LIGGGHTS holds its spheres, hands them to other processes, copies ghosts and finds
/// neighbours; contacts, forces and motion are those of dem::Subdomain, called as pair style and fix of LIGGGHTS. All
/// members but those marked `own` are collective.
class Rank final : Tasks {
 public:
  Rank(MPI_Comm all, const Beginning& beginning, dem::LawTable laws, std::vector<dem::Boundary> boundaries);
  ~Rank() override;
  Rank(const Rank&) = delete;
  Rank& operator=(const Rank&) = delete;

  /// Own: of some spheres, and of some contacts, those that are this process's. Spheres first.
  void take_spheres(std::span<const dem::Sphere> spheres);
  void take_pairs(std::span<const dem::PairHistory> pairs);
  void take_surfaces(std::span<const dem::SurfaceHistory> surfaces);
  void begin();  ///< with all that it took

  std::vector<dem::Boundary>& boundaries() { return subdomain_.boundaries(); }  ///< own; poses are the user's
  /// Sums over all processes, on rank 0; a snapshot of own spheres.
  dem::EngineSums step(const dem::EngineStep& step);
  /// Own: as they are now, in the order of snapshots; until the next step.
  std::span<const dem::Sphere> own() const { return subdomain_.own(); }
  /// Own: spheres, and contacts whose sphere of lower id is this process's.
  dem::Bed::State state(bool contacts);

 private:
  void leave_lists() override;
  void forces() override;
  void motion() override;
  double reach() const override;
  double distance_factor() const override;

  int taken(std::int64_t id) const;  ///< index of a sphere by id, before `begin`
  void build();
  dem::Sphere sphere_at(int index) const;
  void copy_motion(int index, dem::Sphere& to) const;
  std::vector<dem::NearPair> near_pairs() const;
  void take_out_fallen();
  dem::EngineSums sum_up();

  MPI_Comm all_;
  Beginning beginning_;
  dem::Subdomain subdomain_;
  std::unique_ptr<LAMMPS_NS::LAMMPS> lmp_;
  PairSubsoil* pair_ = nullptr;  ///< of lmp_, as is the fix
  FixSubsoil* fix_ = nullptr;
  std::vector<std::int64_t> place_;  ///< before `begin`, of spheres that were taken: id x 2^32 + index
  dem::EngineStep now_;
  dem::Sampling sampling_;
  bool stepping_ = false;
  bool left_lists_ = true;  ///< new ones are to be built from LIGGGHTS'
  long steps_ = 0;
  double removed_ = 0;      ///< J, own, in this step
  std::size_t fallen_ = 0;  ///< likewise
};

}  // namespace subsoil::mpi
