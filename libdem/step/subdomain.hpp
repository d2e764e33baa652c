#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/bed_engine.hpp"
#include "libdem/contacts/contact_laws.hpp"
#include "libdem/contacts/surface_contacts.hpp"
#include "libdem/particles/particle_store.hpp"
#include "libdem/step/energy_balance.hpp"

namespace subsoil::dem {

/// Two spheres of a subdomain near each other, by index, `i` the one with the lower id; what they remember comes with
/// them. Either may be a ghost.
struct NearPair {
  std::uint32_t i, j;
  double gap;            ///< m, negative where they overlap
  const PairState* was;  ///< null: nothing
};

struct SubdomainOptions {
  Vec3 gravity;               ///< m/s2
  const char* simd = "auto";  ///< kernel by name
  double skin = 0;            ///< m
  double largest_radius = 0;  ///< of all subdomains, m
};

/// The part of a bed that one process steps: contacts, forces and motion of its own spheres. Ghosts, records behind
/// them, are spheres of other processes near by, as these have them at t_n. Which spheres these are, and which pairs
/// lie within radii, cutoff and skin, is given from outside (apps/mpi: by LIGGGHTS).
///
/// Both processes evaluate a pair across their border, in the same order of its spheres and so to the same bits, and
/// each counts half of its energies. Forces, laws and the move are the kernels of the bed (kernel/); what differs from
/// the bed is the order of sums. Blocks of contacts hold eight pairs in the order in which they come; one thread works.
class Subdomain {
 public:
  Subdomain(LawTable laws, std::vector<Boundary> boundaries, const SubdomainOptions& options);

  std::vector<Boundary>& boundaries() { return boundaries_; }
  const ContactLaws& laws() const { return laws_; }
  std::size_t size() const { return particles_.size(); }  ///< own spheres
  std::span<const Sphere> own() const { return {particles_.spheres().data(), size()}; }
  Sphere* spheres() { return particles_.spheres().data(); }
  Sphere& ghost(std::size_t k) { return spheres()[size() + k]; }

  /// Makes room for the records; the user writes them, then builds.
  void begin_lists(std::span<const Sphere> own, std::size_t ghosts);
  void build(std::span<const NearPair> pairs, std::vector<SurfaceHistory> at_surfaces);
  /// Whether spheres and boundaries, as they are now, cannot have come to touch unlisted.
  bool lists_hold();
  /// use(i, j, state) for every pair that remembers something, by index; i has the lower id.
  template <class Use>
  void each_pair(const Use& use) const;
  std::vector<SurfaceHistory> at_surfaces() const { return surfaces_.histories(laws_); }

  /// Forces at t_n. Runs of contacts are sampled alternately, as particle blocks of the bed are.
  /// @param elapsed s since the last step @param all every run is sampled besides: energies or a snapshot are asked for
  void evaluate(double elapsed, const Sampling& sampling, bool all);
  /// Energies at t_n, and the state of own spheres appended to a snapshot in the order of their records.
  void observe(const EngineStep& step);
  void observe(const EngineStep& step, Snapshot& out) const;
  void move(const EngineStep& step);
  void add_path(double longest) { path_ += longest; }  ///< m, in this step, of any sphere of all subdomains
  const EngineSums& sums() const { return sums_; }     ///< of own spheres, in this step

 private:
  struct Run {
    std::uint32_t law, blocks = 0, first = 0;  ///< `first` in blocks
    std::size_t lines = 0;
    bool candidates, across;  ///< across: with ghosts, so that half of the energies count here
    double activation = 0;
    RunSums last{};  ///< of its last sample
  };
  void append_runs(std::uint32_t law, bool candidates, bool across, std::vector<NearPair>& pairs);
  void append_run(std::uint32_t law, bool candidates, bool across, std::span<const NearPair> pairs);
  void append_block(std::span<const NearPair> pairs);
  BlockMemory memory(const Run& run, std::uint32_t block) const;
  Ring ring() { return {sums_of_.data(), nullptr, mask_}; }
  void pair_forces(Run& run, double elapsed, const Sample& sample);
  void plane_forces(PlaneRun& run, double elapsed, const Sample& sample);
  void edge_forces(double elapsed);
  void take(const RunSums& s, double share, double weight);
  void sum_last();
  double farthest_from_lists() const;
  double moved(std::size_t boundary) const;
  template <class Job>
  Job job_of_all();

  SubdomainOptions options_;
  Kernel kernel_;
  ContactLaws laws_;
  std::vector<Boundary> boundaries_;
  ParticleStore particles_{Precision::doubles};
  std::size_t ghosts_ = 0;
  bool uniform_ = false;
  std::vector<Run> runs_;
  std::vector<PairBlock, LargePages<PairBlock>> blocks_;
  std::vector<BlockShape> shapes_;
  std::vector<double> activation_;
  std::vector<Line, LargePages<Line>> lines_;
  SurfaceContacts surfaces_;
  std::vector<RunSums> plane_last_;                            ///< as Run::last, of the runs on planes
  std::vector<Accumulator, LargePages<Accumulator>> sums_of_;  ///< of own spheres and ghosts
  std::uint32_t mask_ = 0;
  std::vector<Vec3> listed_;  ///< where own spheres were when the lists were built
  std::vector<Pose> listed_pose_;
  std::vector<char> listed_active_;
  double path_ = 0;                            ///< bound of the way of any sphere since then, m
  double measured_ = 0, path_at_measure_ = 0;  ///< maximum way when last measured
  EngineSums sums_;
};

template <class Use>
void Subdomain::each_pair(const Use& use) const {
  for (const Run& run : runs_) {
    const MemoryShape& shape = laws_.pair_memory(run.law);
    for (std::uint32_t b = 0; b < run.blocks; ++b)
      for (std::uint32_t l = 0; l < shapes_[run.first + b].lanes; ++l) {
        const PairState state = read_lane(memory(run, b), shape, l);
        const PairBlock& pair = blocks_[run.first + b];
        if (!state.empty()) use(pair.i[l], pair.j[l], state);
      }
  }
}

}  // namespace subsoil::dem
