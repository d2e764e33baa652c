#include <omp.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "libdem/base/prefetch.hpp"
#include "libdem/laws/friction.hpp"
#include "libdem/step/bed_impl.hpp"
#include "libdem/step/surface_forces.hpp"

/// Boundaries, forces and motion of one step, fused into one pass: contacts with edges of boundaries and halo blocks of
/// pairs first, then a sweep in which each worker walks its particle blocks in ascending order: pairs that touch,
/// candidates that are active, planes; each force is added to both particles, and when a block's contacts are done its
/// spheres have all their forces and move. In place: a contact whose first particle lies in a later block never needs
/// an earlier sphere.
///
/// Blocks of contacts at the end of a worker's range are evaluated by the worker after it, whose sweep needs them at
/// its start. Nobody waits at a barrier, flags keep the order: a worker begins its sweep when what its spheres get from
/// earlier workers is there, and passes a particle block with halo blocks, which moves spheres that the other reads,
/// when these have been evaluated.
///
/// A wide bed is sorted cache block by cache block (neighbours/grid.hpp). What a contact across a block interface gives
/// to its second particle is kept as a remote contribution, since the ring of forces does not reach that far; the
/// particle gets it before all else, when the sweep first comes near.
///
/// Why not a force array and a second pass: forces would travel through memory twice (24 against 10 ns per
/// particle-step in a trial). Why not per-thread force sums: the order of additions, and so the last bits, would follow
/// the threads.
namespace subsoil::dem {

void Bed::Impl::place_boundaries(double elapsed) {
  plane_jobs.clear();
  for (const Boundary& b : boundaries) plane_jobs.push_back(plane_job(b, particles, elapsed));
}

PairJob Bed::Impl::pair_job(const PairRun& run, std::size_t particle_block, const Sample& sample) {
  PairJob job{};
  job.record = sample.record, job.accumulate = sample.accumulate;
  job.spheres = particles.spheres().data();
  job.mixed = particles.mixed();
  if (!run.all_free && !particles.is_mixed()) job.masses = particles.masses().data();
  job.blocks = contacts.blocks.data() + run.first;
  job.shapes = contacts.shapes.data() + run.first;
  job.lines = contacts.lines.data() + run.lines;
  job.count = run.blocks;
  job.uniform = run.uniform;
  if (run.across_interface) {
    job.interface_rows = contacts.interface_rows.data() + run.rows;
    job.interface_given = contacts.interface_given.data() + run.rows;
  }
  job.elapsed = now.dt_before;
  job.path = paths.of(particle_block);
  job.activation = run.candidates ? contacts.activation.data() + run.first : nullptr;
  job.cutoff = laws.cutoff(run.law);
  return job;
}

namespace {

/// Others are evaluated as in recorded steps (plain_kernel_body.hpp).
bool is_usual(const Law& law) { return law->friction().usual(); }

/// The walk of one worker through its particle blocks.
class Sweep {
 public:
  Sweep(Bed::Impl& bed, Worker& worker, double dt, const Bed::Request& request)
      : bed_(bed),
        contacts_(bed.contacts),
        surfaces_(bed.surfaces),
        w_(worker),
        dt_(dt),
        request_(request),
        ring_(worker.forces.ring()),
        forced_(bed.forces.any()),
        reached_(worker.blocks_begin) {}

  void run() {
    PhaseClock clock(bed_.measures_phases);
    await_remote();
    for (std::uint32_t k = w_.blocks_begin; k < w_.blocks_end; ++k) {
      if (!bed_.region.evaluates(k)) {
        pass(k);
        continue;
      }
      begin_block(k);
      pair_forces();
      clock.end(w_.spent.pairs);
      plane_forces();
      surface_forces();
      if (forced_) user_forces();
      clock.end(w_.spent.surfaces);
      if (request_.energy || request_.snapshot != nullptr) observe();
      bed_.region.freezes(k) ? freeze() : bed_.region.moves(k) ? integrate() : rest();
      if (forced_) end_user_forces();
      clock.end(w_.spent.move);
    }
    clear_ring();
  }

 private:
  // What others give.

  void await_remote() {
    for (const std::uint32_t other : w_.waits_for) bed_.work.workers[other].remote_done.await(bed_.now.sweeps);
    receive_across_interfaces(w_.reached);
    for (const RemoteContribution& c : w_.remote) receive(c);
  }
  /// In the order of blocks and lanes, as one thread would have added it.
  void receive(const RemoteContribution& c) {
    if (*c.given == 0) return;
    add(c.sphere, -c.sum->f, c.sum->t);
  }
  /// What spheres up to a particle block get across interfaces, before anything else is added.
  void receive_across_interfaces(std::uint32_t block) {
    constexpr std::uint32_t soon = 64;  // pairs: two or three particle blocks at an interface
    const std::vector<RemoteContribution>& remote = contacts_.remote;
    for (; reached_ <= block && reached_ < w_.blocks_end; ++reached_) {
      if (!bed_.region.evaluates(reached_)) continue;
      for (std::uint32_t k = contacts_.particle_blocks[reached_].remote_begin;
           k < contacts_.particle_blocks[reached_].remote_end; ++k) {
        if (k + soon < remote.size()) prefetch(remote[k + soon].sum);
        receive(remote[k]);
      }
    }
  }

  /// A particle block of which nothing is evaluated in this step.
  void pass(std::uint32_t k) {
    block_ = &contacts_.particle_blocks[k];
    while (halo_ < w_.halo.place.size() && w_.halo.place[halo_].particle_block == k) ++halo_;
    if (bed_.region.receives(k)) drop_forces();
  }

  // Forces of one particle block.

  void begin_block(std::uint32_t k) {
    own_ = k;
    block_ = &contacts_.particle_blocks[k];
    sums_ = &bed_.balance.of_block[k];
    for (std::size_t p = halo_; p < w_.halo.place.size() && w_.halo.place[p].particle_block == k; ++p)
      bed_.work.workers[w_.halo.place[p].evaluator].remote_done.await(bed_.now.sweeps);
    receive_across_interfaces(block_->last);
    sample_ = bed_.balance.sample(k);
    if (sample_.accumulate) sums_->stored = sums_->pairs = sums_->overlap = 0;
    ++bed_.work.cost[k].steps;
    // Into the cache while the pairs are worked on.
    const SurfaceContacts::OfBlock& at = surfaces_.of_block[k];
    for (std::uint32_t r = at.planes_begin; r < at.planes_end; ++r) {
      const PlaneRun& run = surfaces_.plane_runs[r];
      prefetch(surfaces_.plane_blocks.data() + run.first, run.blocks * sizeof(PlaneBlock));
      prefetch(surfaces_.plane_lines.data() + run.lines, run.blocks * bed_.laws.surface_memory(run.law).state_bytes());
    }
  }

  void pair_forces() {
    for (std::uint32_t r = block_->runs_begin; r < block_->runs_end; ++r) {
      const std::size_t first = halo_;
      while (halo_ < w_.halo.place.size() && w_.halo.place[halo_].run == r) ++halo_;
      contacts_.runs[r].across_interface ? pairs_across_interface(r, first) : pairs(r, first);
    }
  }

  /// Halo blocks `first` to `halo_` of the run have been evaluated.
  void pairs(std::uint32_t r, std::size_t first) {
    PairRun& run = contacts_.runs[r];
    if (run.candidates && bed_.paths.of(own_) < run.activation) return;
    PairJob job = bed_.pair_job(run, own_, sample_);
    job.ring = ring_;
    if (!run.candidates) look_ahead(job);
    w_.halo.hand_to(job, first, halo_);
    evaluate(r, job);
    accumulate(run, job);
  }

  /// What the next particle block meets first, for the kernel to fetch. Not what the next worker works on: to write it,
  /// that one would have to wait until it is given back.
  void look_ahead(PairJob& job) const {
    if (block_->end >= w_.end) return;
    const ParticleBlock& next = *(block_ + 1);
    const std::uint32_t from = contacts_.particle_blocks[block_->last].end;
    const std::uint32_t to = std::min(contacts_.particle_blocks[next.last].end, w_.end);
    job.ahead = from;
    job.ahead_count = to > from ? to - from : 0;
    if (block_->interface_runs_begin < block_->runs_end && !contacts_.runs[block_->interface_runs_begin].candidates) {
      const PairRun& across = contacts_.runs[block_->interface_runs_begin];
      job.interface_blocks = contacts_.blocks.data() + across.first, job.interface_count = across.blocks;
      job.interface_pushes = contacts_.interface_rows[across.rows].of,
      job.interface_lines = contacts_.lines.data() + across.lines;
    }
    if (next.runs_begin < next.runs_end && !contacts_.runs[next.runs_begin].candidates) {
      job.next_blocks = contacts_.blocks.data() + contacts_.runs[next.runs_begin].first;
      job.next_lines = contacts_.lines.data() + contacts_.runs[next.runs_begin].lines;
    }
  }

  /// What second particles get is kept for them. The run has been evaluated, or it is now.
  void pairs_across_interface(std::uint32_t r, std::size_t first) {
    PairRun& run = contacts_.runs[r];
    const bool evaluated = first < halo_;
    if (!evaluated) std::fill_n(contacts_.interface_given.begin() + run.rows, run.blocks, 0);
    if (run.candidates && bed_.paths.of(own_) < run.activation) return;
    PairJob job = bed_.pair_job(run, own_, sample_);
    job.ring = ring_;
    if (evaluated) {
      w_.halo.hand_to(job, first, halo_);
      job.record = job.record || !is_usual(bed_.laws[run.law]);
    } else {
      w_.at_interface.hand_to(job, 0, run.blocks);
      job.halo = true;
      evaluate(r, job);
      job.record = job.record || !is_usual(bed_.laws[run.law]);  // as it was evaluated
      bed_.kernel.keep(job);
    }
    bed_.kernel.add_interface(job);
    accumulate(run, job);
  }

  void evaluate(std::uint32_t r, PairJob& job) {
    const PairRun& run = contacts_.runs[r];
    bed_.kernel.pairs(bed_.laws[run.law], job);
    if (job.broke) bed_.bonds.mark_broken(r);
    BlockCost& cost = bed_.work.cost[own_];
    (run.candidates ? cost.candidates : cost.touching) += job.evaluated;
  }
  void accumulate(PairRun& run, const PairJob& job) const {
    if (run.candidates) run.activation = *std::min_element(job.activation, job.activation + run.blocks);
    if (!sample_.accumulate) return;
    take(job.sums);
    sums_->pairs += job.sums.within_cutoff;
  }
  void take(const RunSums& s) const {
    const double weight = sample_.weight;
    sums_->lost += Losses{weight * s.damped, weight * s.slid, weight * s.rolled, weight * s.yielded};
    sums_->stored += s.stored;
    sums_->overlap = std::max(sums_->overlap, s.overlap);
  }

  void plane_forces() {
    const SurfaceContacts::OfBlock& at = surfaces_.of_block[own_];
    for (std::uint32_t r = at.planes_begin; r < at.planes_end; ++r) plane(surfaces_.plane_runs[r]);
  }
  void plane(PlaneRun& run) {
    PlaneJob job = bed_.plane_jobs[run.boundary];
    job.record = sample_.record;
    job.blocks = surfaces_.plane_blocks.data() + run.first;
    job.count = run.blocks, job.contacts = run.contacts;
    job.cutoff = bed_.laws.surface_cutoff(run.law);
    job.lines = surfaces_.plane_lines.data() + run.lines;
    job.ring = ring_;
    bed_.kernel.planes(bed_.laws[run.law], job);
    if (sample_.accumulate) take(job.sums);
    run.wrench = {{job.force[0], job.force[1], job.force[2]}, {job.moment[0], job.moment[1], job.moment[2]}};
    run.in_reach = job.sums.within_cutoff;
  }

  /// At edges, corners and curved surfaces: evaluated before the sweep, added here.
  void surface_forces() {
    const SurfaceContacts::OfBlock& at = surfaces_.of_block[own_];
    for (std::uint32_t k = at.entries_begin; k < at.entries_end; ++k) {
      const SurfaceEntry& e = surfaces_.entries[surfaces_.entry_order[k]];
      add(e.sphere, Four{e.force.x, e.force.y, e.force.z, 0},
          Four{e.torque.x, e.torque.y, e.torque.z, static_cast<double>(e.touching)});
    }
  }

  // Of users (sphere_forces.hpp); on members of clumps they act after the sweep.

  void user_forces() {
    const double half = 0.5 * bed_.now.dt_before;
    SphereForces::Work& work = bed_.forces.of_block(own_);
    work.begin_step();
    given_.clear();
    for (std::uint32_t i = block_->begin; i < block_->end; ++i) {
      const Sphere s = bed_.particles.now(i);
      if (s.kind != SphereKind::free) continue;
      const double push = half / s.m, turn = half / inertia(s);
      SphereAt here{.time = bed_.now.time,
                    .position = bed_.options.periodic.wrapped(s.x),
                    .velocity = s.v + half * bed_.options.gravity,
                    .angular_velocity = s.w,
                    .mass = s.m,
                    .radius = s.r,
                    .id = s.id,
                    .material = s.material};
      at(i, [&](const auto& sum) {
        here.velocity += push * vector_of(sum.f), here.angular_velocity += turn * vector_of(sum.t);
      });
      const Wrench w = bed_.forces.on_free(here, push, turn);
      add(i, Four{w.force.x, w.force.y, w.force.z, 0}, Four{w.moment.x, w.moment.y, w.moment.z, 0});
      work.until += half * (dot(w.force, s.v) + dot(w.moment, s.w));
      given_.push_back({i, w});
    }
  }
  /// Their work behind t_n, after the move.
  void end_user_forces() {
    double power = 0;
    for (const auto& [i, w] : given_) {
      const Sphere s = bed_.particles.now(i);
      power += dot(w.force, s.v) + dot(w.moment, s.w);
    }
    bed_.forces.of_block(own_).ahead = 0.5 * dt_ * power;
  }

  /// use(sum) of the forces on a sphere.
  template <class Use>
  void at(std::uint32_t sphere, const Use& use) {
    const std::uint32_t k = sphere & ring_.mask;
    bed_.particles.is_mixed() ? use(ring_.singles[k]) : use(ring_.doubles[k]);
  }
  void add(std::uint32_t sphere, const Four& f, const Four& t) {
    at(sphere, [&](auto& sum) {
      sum.f += __builtin_convertvector(f, decltype(sum.f));
      sum.t += __builtin_convertvector(t, decltype(sum.t));
    });
  }
  /// Of what was added for spheres of later workers; they add it themselves.
  void clear_ring() {
    const std::uint32_t until =
        std::min<std::uint32_t>(static_cast<std::uint32_t>(bed_.particles.size()), w_.end + ring_.mask);
    for (std::uint32_t i = w_.end; i < until; ++i) at(i, []<class Sum>(Sum& sum) { sum = Sum{}; });
  }

  // Spheres of one particle block, whose forces are complete.

  ParticleBlockJob spheres_job() {
    const Vec3& g = bed_.options.gravity;
    return {.spheres = bed_.particles.spheres().data(),
            .mixed = bed_.particles.mixed(),
            .begin = block_->begin,
            .end = block_->end,
            .ring = ring_,
            .gravity = {g.x, g.y, g.z},
            .uniform = block_->uniform};
  }

  /// Energies and state at t_n, before the move.
  void observe() {
    ObserveJob job{spheres_job()};
    job.before = bed_.now.dt_before, job.dt = dt_;
    bed_.kernel.observe(job);
    if (has_fixed() || has_members()) observe_free(job);
    const double moving = bed_.region.moves(own_) ? 1 : 0;
    sums_->kinetic = moving * job.kinetic, sums_->rotational = moving * job.rotational,
    sums_->potential = job.potential;
    if (request_.snapshot == nullptr) return;
    for (std::uint32_t i = block_->begin; i < block_->end; ++i)
      at(i, [&](const auto& sum) { write(i, sum, *request_.snapshot); });
  }
  template <class Sum>
  void write(std::uint32_t i, const Sum& a, Snapshot& out) const {
    const Sphere s = bed_.particles.now(i);
    // Else contacts alone, and the velocity that a fixed sphere keeps, or that its clump gives it (Clumps::complete).
    const bool free = s.kind == SphereKind::free;
    const Vec3 force = vector_of(a.f) + (free ? s.m : 0) * bed_.options.gravity, torque = vector_of(a.t);
    const double back = free && bed_.region.moves(own_) ? 0.5 * bed_.now.dt_before : 0;
    const std::size_t k = bed_.particles.slot_of(s);
    out.id[k] = s.id;
    out.radius[k] = s.r;
    out.material[k] = s.material;
    out.position[k] = bed_.options.periodic.wrapped(s.x);
    out.velocity[k] = s.v + force * (back / s.m);
    out.angular_velocity[k] = s.w + torque * (back / inertia(s));
    out.force[k] = force;
    out.torque[k] = torque;
    out.contacts[k] = static_cast<int>(a.t[3]);
  }

  /// Leapfrog; also clears the sums for the spheres that get their places in the ring next.
  void integrate() {
    if (all_are_members()) return take_members();
    MoveJob job{spheres_job()};
    job.kick = 0.5 * (dt_ + bed_.now.dt_before), job.dt = dt_;
    if (has_fixed()) take_fixed();
    if (has_members()) take_members();
    bed_.kernel.move(job);
    if (has_members()) put_back_members();
    if (has_fixed()) put_back_fixed(job);
    sums_->speed2 = job.speed2;
    sums_->squares = job.squares;
    bed_.paths.moved(own_, std::sqrt(job.speed2) * dt_);
  }

  // Of particle blocks with members of clumps (clumps.hpp), which stay until the sweep is done.

  bool has_members() const { return !bed_.clumps.of_block(own_).empty(); }
  bool all_are_members() const { return bed_.clumps.of_block(own_).size() == block_->end - block_->begin; }
  /// What acts on them, out of the sums; their records.
  void take_members() {
    take_loads();
    members_.clear();
    for (const Clumps::Place& p : bed_.clumps.of_block(own_)) members_.push_back(bed_.particles.now(p.sphere));
  }
  void take_loads() {
    for (const Clumps::Place& p : bed_.clumps.of_block(own_)) {
      Clumps::Load& load = bed_.clumps.load(p);
      at(p.sphere, [&]<class Sum>(Sum& sum) {
        load.force = vector_of(sum.f), load.torque = vector_of(sum.t);
        sum = Sum{};
      });
    }
  }
  void put_back_members() {
    const Sphere* before = members_.data();
    for (const Clumps::Place& p : bed_.clumps.of_block(own_)) {
      bed_.particles.spheres()[p.sphere] = *before;
      if (bed_.particles.is_mixed())
        bed_.particles.mixed()[p.sphere] = rounded(*before, bed_.particles.mass_in_contact(p.sphere));
      ++before;
    }
  }

  // Of particle blocks with fixed spheres (fixed_spheres.hpp).

  bool has_fixed() const { return !bed_.fixed.of_block(own_).empty(); }

  /// Energies of the others, as the kernel has them (kernel/move.hpp).
  void observe_free(ObserveJob& job) {
    const Vec3& g = bed_.options.gravity;
    const double half = 0.5 * job.before, ratio = job.before > 0 ? job.dt / job.before : 0;
    job.kinetic = job.rotational = job.potential = 0;
    for (std::uint32_t i = block_->begin; i < block_->end; ++i) {
      const Sphere s = bed_.particles.now(i);
      if (s.kind != SphereKind::free) continue;
      at(i, [&](const auto& sum) {
        const Vec3 gain = half * ((1 / s.m) * vector_of(sum.f) + g), turn = (half / inertia(s)) * vector_of(sum.t);
        const Vec3 v = s.v + gain, w = s.w + turn;
        job.kinetic += 0.5 * s.m * (dot(v, v) - ratio * dot(gain, gain));
        job.rotational += 0.5 * inertia(s) * (dot(w, w) - ratio * dot(turn, turn));
        job.potential -= s.m * dot(g, s.x);
      });
    }
  }
  /// What acts on them, before the move clears the sums; where they are.
  void take_fixed() {
    for (const FixedSpheres::Place& p : bed_.fixed.of_block(own_)) {
      FixedSphere& f = bed_.fixed.entry(p);
      const Sphere s = bed_.particles.now(p.sphere);
      f.position = s.x, f.velocity = s.v, f.angular_velocity = s.w;
      at(p.sphere, [&](const auto& sum) { f.force = vector_of(sum.f), f.torque = vector_of(sum.t); });
    }
  }
  /// Their own motion in place of what the move has made of them; the extremes are then of that.
  void put_back_fixed(MoveJob& job) {
    for (const FixedSpheres::Place& p : bed_.fixed.of_block(own_)) {
      const FixedSphere& f = bed_.fixed.entry(p);
      Sphere& s = bed_.particles.spheres()[p.sphere];
      s.x = f.position + dt_ * f.velocity, s.v = f.velocity, s.w = f.angular_velocity;
      if (bed_.particles.is_mixed())
        bed_.particles.mixed()[p.sphere] = rounded(s, bed_.particles.mass_in_contact(p.sphere));
    }
    job.speed2 = job.squares = 0;
    for (std::uint32_t i = block_->begin; i < block_->end; ++i) {
      const Sphere s = bed_.particles.now(i);
      const double v2 = dot(s.v, s.v);
      if (exceeds(v2, job.speed2)) job.speed2 = v2;
      job.squares += v2 + dot(s.w, s.w);
    }
  }

  /// Spheres that were moving stay where they are at t_n; the balance gets what they had then.
  void freeze() {
    ObserveJob job{spheres_job()};
    job.before = bed_.now.dt_before, job.dt = dt_;
    bed_.kernel.observe(job);
    if (has_fixed() || has_members()) observe_free(job);
    sums_->frozen += job.kinetic + job.rotational;
    sums_->kinetic = sums_->rotational = sums_->speed2 = sums_->squares = 0;
    sums_->potential = job.potential;
    bed_.paths.moved(own_, 0);
    for (std::uint32_t i = block_->begin; i < block_->end; ++i) bed_.particles.stop(i);
    if (has_fixed()) take_fixed();
    take_loads();
    drop_forces();
  }
  /// Frozen ones stay: their forces are looked at now and then.
  void rest() {
    if (bed_.region.checks(own_)) {
      bed_.region.found(own_, rests());
      if (has_fixed()) take_fixed();
      take_loads();
    }
    drop_forces();
  }
  void drop_forces() {
    for (std::uint32_t i = block_->begin; i < block_->end; ++i) at(i, []<class Sum>(Sum& sum) { sum = Sum{}; });
  }
  bool rests() {
    bool all = true;
    for (std::uint32_t i = block_->begin; i < block_->end; ++i) {
      const Sphere s = bed_.particles.now(i);
      if (s.kind == SphereKind::member) continue;  // Clumps::move checks them
      at(i, [&](const auto& sum) {
        const double yields = is_fixed(s) ? 0 : 1;
        const Vec3 a = (yields / s.m) * vector_of(sum.f) + bed_.options.gravity,
                   turn = (yields * s.r / inertia(s)) * vector_of(sum.t);
        all = bed_.region.rests(own_, i, a, turn) && all;
      });
    }
    return all;
  }
  template <class Row>
  static Vec3 vector_of(const Row& x) {
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
  }

  Bed::Impl& bed_;
  ContactStore& contacts_;
  SurfaceContacts& surfaces_;
  Worker& w_;
  double dt_;
  const Bed::Request& request_;
  Ring ring_;
  bool forced_;            ///< by users
  std::size_t halo_ = 0;   ///< next halo block
  std::uint32_t reached_;  ///< next particle block that gets what comes across interfaces
  // The particle block at hand:
  std::uint32_t own_ = 0;
  const ParticleBlock* block_ = nullptr;
  BlockSums* sums_ = nullptr;
  Sample sample_;
  std::vector<Sphere> members_;                          ///< of clumps, as they are before the move
  std::vector<std::pair<std::uint32_t, Wrench>> given_;  ///< by users, by sphere
};

void resize(Snapshot& s, std::size_t n) {
  s.id.resize(n), s.radius.resize(n), s.material.resize(n), s.contacts.resize(n);
  for (auto* column : {&s.position, &s.velocity, &s.angular_velocity, &s.force, &s.torque}) column->resize(n);
}

}  // namespace

/// Halo blocks of other workers, run by run.
void Bed::Impl::evaluate_remote(Worker& w) {
  for (const RemoteEvaluation& evaluation : w.remote_evaluations) {
    HaloBlocks& halo = work.workers[evaluation.worker].halo;
    const auto [particle_block, r, evaluator] = halo.place[evaluation.first];
    const PairRun& run = contacts.runs[r];
    if (run.across_interface)
      for (std::uint32_t k = evaluation.first; k < evaluation.end; ++k)
        contacts.interface_given[run.rows + halo.block[k]] = 0;
    if (!region.evaluates(particle_block) || (run.candidates && paths.of(particle_block) < run.activation)) {
      std::fill(halo.active.begin() + evaluation.first, halo.active.begin() + evaluation.end, 0);
      continue;
    }
    PairJob job = pair_job(run, particle_block, balance.sample(particle_block));
    halo.hand_to(job, evaluation.first, evaluation.end);
    job.halo = true;
    kernel.pairs(laws[run.law], job);
    job.record = job.record || !is_usual(laws[run.law]);  // as they were evaluated
    kernel.keep(job);
    if (job.broke) bonds.mark_broken(r);
  }
  w.remote_done.raise(now.sweeps);
}

void Bed::Impl::sweep(double dt, const Request& request) {
  if (request.snapshot != nullptr) resize(*request.snapshot, particles.size());
  particles.begin_step();
  const SurfaceForces at_surfaces{kernel, laws, particles, boundaries, surfaces, now.dt_before};
  const int chunk_count = static_cast<int>(surfaces.chunks.size());
  ++now.sweeps;
#pragma omp parallel num_threads(threads)
  {
    // One pass for each worker that OpenMP did not grant a thread of its own.
    const int team = omp_get_num_threads();
    const int rank = omp_get_thread_num();
    for (int t = rank; t < threads; t += team) {
      Worker& w = work.workers[static_cast<std::size_t>(t)];
      w.spent = {};
      const double from = WorkerTimer::now();
      PhaseClock clock(measures_phases);
      const int first = chunk_count * t / threads, last = chunk_count * (t + 1) / threads;
      for (int c = first; c < last; ++c) at_surfaces.evaluate(surfaces.chunks[static_cast<std::size_t>(c)]);
      w.surfaces_done.raise(now.sweeps);
      clock.end(w.spent.surfaces);
      evaluate_remote(w);
      clock.end(w.spent.pairs);
      w.before_sweep = WorkerTimer::now() - from;
    }
    // These contacts may be of anybody's spheres.
    if (chunk_count > 0)
      for (Worker& w : work.workers) w.surfaces_done.await(now.sweeps);
    for (int t = rank; t < threads; t += team) {
      Worker& w = work.workers[static_cast<std::size_t>(t)];
      const double from = WorkerTimer::now();
      Sweep(*this, w, dt, request).run();
      w.timer.add(w.before_sweep + WorkerTimer::now() - from);
    }
  }
}

}  // namespace subsoil::dem
