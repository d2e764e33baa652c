#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>

#include "libdem/laws/friction.hpp"
#include "libdem/step/bed_impl.hpp"

/// One step of the bed: contacts with edges of boundaries and blocks of pairs across thread borders first, then one
/// fused sweep in which each thread walks its tiles in ascending order: pairs that touch, near pairs that are awake,
/// planes; each force is added to both partners, and when a tile's pairs are done its spheres are complete and move. In
/// place: a contact owned by a later tile never needs an earlier sphere.
///
/// Blocks at the end of a thread's range are evaluated by the thread after it, whose sweep needs them at its start.
/// Nobody waits at a barrier, flags keep the order: a thread begins its sweep when what its spheres get from earlier
/// threads is there, and passes a tile with such blocks, which moves spheres that the other reads, when they have been
/// evaluated.
///
/// A wide bed is sorted strip by strip (grid.hpp). What a contact across a seam, between strips, gives to its partner
/// is kept, since the ring does not reach that far; the partner gets it before all else, when the sweep first comes
/// near.
///
/// Why not a force array and a second pass: forces would travel through memory twice (24 against 10 ns per
/// particle-step in a trial). Why not per-thread force sums: the order of additions, and so the last bits, would follow
/// the threads.
namespace subsoil::dem {

PairJob Bed::Impl::pair_job(const PairRun& run, const Tile& tile, const Booking& booking, double elapsed) {
  PairJob job{};
  job.record = booking.book, job.accumulate = booking.sum;
  job.spheres = spheres.data();
  job.mixed = is_mixed() ? mixed.data() : nullptr;
  job.blocks = blocks.data() + run.first;
  job.shapes = shapes.data() + run.first;
  job.lines = lines.data() + run.lines;
  job.count = run.blocks;
  job.uniform = run.uniform;
  if (run.seam) job.interface_rows = interface_rows.data() + run.rows, job.interface_given = interface_given.data() + run.rows;
  job.elapsed = elapsed;
  job.path = tile.path;
  job.activation = run.near ? wake.data() + run.first : nullptr;
  job.cutoff = reach(run.law);
  return job;
}

namespace {

/// Others are evaluated as in booked steps (plain_kernel_body.hpp).
bool is_usual(const Law& law) { return law->friction().usual(); }

/// The walk of one thread through its tiles.
class Sweep {
 public:
  Sweep(Bed::Impl& bed, Worker& worker, double dt, const Bed::Request& request)
      : bed_(bed), w_(worker), dt_(dt), request_(request), ring_(worker.waiting.ring()), reached_(worker.tiles_begin) {}

  void run() {
    PhaseClock clock(bed_.measures_phases);
    Phases& spent = w_.spent;
    for (const std::uint32_t other : w_.waits) bed_.workers[other].errands_done.await(bed_.sweeps);
    receive_seams(w_.reached);
    for (const ForeignLane& lane : w_.foreign) receive(lane);
    for (std::uint32_t k = w_.tiles_begin; k < w_.tiles_end; ++k) {
      Tile& t = bed_.tiles[k];
      for (std::size_t p = border_; p < w_.border.place.size() && w_.border.place[p].tile == k; ++p)
        bed_.workers[w_.border.place[p].evaluator].errands_done.await(bed_.sweeps);
      receive_seams(t.last);
      booking_ = bed_.booking(k);
      t.stored = 0;
      if (booking_.sum) t.pairs = t.overlap = 0;
      for (std::uint32_t r = t.planes_begin; r < t.planes_end; ++r) fetch(bed_.plane_runs[r]);
      for (std::uint32_t r = t.runs_begin; r < t.runs_end; ++r) pairs(t, r);
      clock.end(spent.pairs);
      for (std::uint32_t r = t.planes_begin; r < t.planes_end; ++r) planes(t, bed_.plane_runs[r]);
      for (std::uint32_t e = t.entries_begin; e < t.entries_end; ++e) add(bed_.entries[bed_.entry_order[e]]);
      clock.end(spent.surfaces);
      if (request_.energy || request_.snapshot != nullptr) observe(t);
      move(t);
      clock.end(spent.move);
    }
    // What was added for spheres of later threads; they add it themselves.
    const std::uint32_t until =
        std::min<std::uint32_t>(static_cast<std::uint32_t>(bed_.spheres.size()), w_.end + ring_.mask);
    for (std::uint32_t i = w_.end; i < until; ++i) at(i, []<class Sum>(Sum& sum) { sum = Sum{}; });
  }

 private:
  /// use(sum) of what waits for a sphere.
  template <class Use>
  void at(std::uint32_t sphere, const Use& use) {
    const std::uint32_t k = sphere & ring_.mask;
    bed_.is_mixed() ? use(ring_.singles[k]) : use(ring_.doubles[k]);
  }
  void add(std::uint32_t sphere, const Four& f, const Four& t) {
    at(sphere, [&](auto& sum) {
      sum.f += __builtin_convertvector(f, decltype(sum.f));
      sum.t += __builtin_convertvector(t, decltype(sum.t));
    });
  }
  /// What a sphere of this thread gets from a block evaluated before the sweep; in the order of blocks and lanes, as
  /// one thread would have added it.
  void receive(const ForeignLane& lane) {
    if (*lane.given == 0) return;
    add(lane.sphere, -lane.push->f, lane.push->t);
  }
  /// What those up to a tile get across seams, before anything else is added.
  void receive_seams(std::uint32_t tile) {
    constexpr std::uint32_t soon = 64;  // pairs: two or three tiles at a seam
    for (; reached_ <= tile && reached_ < w_.tiles_end; ++reached_)
      for (std::uint32_t k = bed_.tiles[reached_].seams_begin; k < bed_.tiles[reached_].seams_end; ++k) {
        if (k + soon < bed_.seams.size()) __builtin_prefetch(bed_.seams[k + soon].push);
        receive(bed_.seams[k]);
      }
  }
  void pairs(Tile& t, std::uint32_t r) {
    PairRun& run = bed_.runs[r];
    Border& border = w_.border;
    const std::size_t first = border_;
    while (border_ < border.place.size() && border.place[border_].run == r) ++border_;
    if (run.seam) return seam_pairs(t, r, first);
    if (run.near && t.path < run.wakes) return;
    PairJob job = bed_.pair_job(run, t, booking_, bed_.dt_before);
    job.ring = ring_;
    // Not what the next thread works on: to write it, it would have to wait until it is given back.
    if (!run.near && t.end < w_.end) {
      const std::uint32_t from = bed_.tiles[t.last].end, to = std::min(bed_.tiles[(&t + 1)->last].end, w_.end);
      job.ahead = from;
      job.ahead_count = to > from ? to - from : 0;
      if (t.seam_runs_begin < t.runs_end && !bed_.runs[t.seam_runs_begin].near) {
        const PairRun& seam = bed_.runs[t.seam_runs_begin];
        job.interface_blocks = bed_.blocks.data() + seam.first, job.interface_count = seam.blocks;
        job.interface_pushes = bed_.interface_rows[seam.rows].of, job.interface_lines = bed_.lines.data() + seam.lines;
      }
      const std::uint32_t next = (&t + 1)->runs_begin;
      if (next < (&t + 1)->runs_end && !bed_.runs[next].near) {
        job.next_blocks = bed_.blocks.data() + bed_.runs[next].first;
        job.next_lines = bed_.lines.data() + bed_.runs[next].lines;
      }
    }
    border.offer(job, first, border_);
    evaluate(t, r, job);
    book(t, run, job);
  }

  /// Across a seam; what partners get is kept. The run has been evaluated, or it is now.
  void seam_pairs(Tile& t, std::uint32_t r, std::size_t first) {
    PairRun& run = bed_.runs[r];
    const bool evaluated = first < border_;
    if (!evaluated) std::fill_n(bed_.interface_given.begin() + run.rows, run.blocks, 0);
    if (run.near && t.path < run.wakes) return;
    PairJob job = bed_.pair_job(run, t, booking_, bed_.dt_before);
    job.ring = ring_;
    if (evaluated) {
      w_.border.offer(job, first, border_);
      job.record = job.record || !is_usual(bed_.law(run.law));
    } else {
      w_.at_seam.offer(job, 0, run.blocks);
      job.halo = true;
      evaluate(t, r, job);
      job.record = job.record || !is_usual(bed_.law(run.law));  // as it was evaluated
      bed_.kernel.keep(job);
    }
    bed_.kernel.add_interface(job);
    book(t, run, job);
  }

  void evaluate(Tile& t, std::uint32_t r, PairJob& job) {
    const PairRun& run = bed_.runs[r];
    bed_.kernel.pairs(bed_.law(run.law), job);
    if (job.broke) bed_.note_break(r);
    (run.near ? t.near_blocks : t.touching_blocks) += job.evaluated;
  }
  void book(Tile& t, PairRun& run, const PairJob& job) const {
    if (run.near) run.wakes = *std::min_element(job.activation, job.activation + run.blocks);
    if (!booking_.sum) return;
    take(t, job.sums);
    t.pairs += job.sums.within_cutoff;
  }

  /// Into the cache while the pairs are worked on: runs are too short for the processor to see them coming.
  void fetch(const PlaneRun& run) const {
    const auto all = [](const auto* from, std::size_t bytes) {
      for (std::size_t at = 0; at < bytes; at += sizeof(Line))
        __builtin_prefetch(reinterpret_cast<const char*>(from) + at, 0, 2);
    };
    all(bed_.plane_blocks.data() + run.first, run.blocks * sizeof(PlaneBlock));
    all(bed_.plane_lines.data() + run.lines, run.blocks * bed_.surface_memory[run.law].state_bytes());
  }

  void planes(Tile& t, PlaneRun& run) {
    PlaneJob job = bed_.plane_jobs[run.boundary];
    job.record = booking_.book;
    job.blocks = bed_.plane_blocks.data() + run.first;
    job.count = run.blocks, job.contacts = run.contacts;
    job.cutoff = bed_.surface_reach[run.law];
    job.lines = bed_.plane_lines.data() + run.lines;
    job.ring = ring_;
    bed_.kernel.planes(bed_.law(run.law), job);
    if (booking_.sum) take(t, job.sums);
    run.wrench = {{job.force[0], job.force[1], job.force[2]}, {job.moment[0], job.moment[1], job.moment[2]}};
    run.in_reach = job.sums.within_cutoff;
  }

  void take(Tile& t, const RunSums& s) const {
    const double weight = booking_.weight;
    t.lost += Losses{weight * s.damped, weight * s.slid, weight * s.rolled};
    t.stored += s.stored;
    t.overlap = std::max(t.overlap, s.overlap);
  }

  void add(const SurfaceEntry& e) {
    add(e.sphere, Four{e.force.x, e.force.y, e.force.z, 0},
        Four{e.torque.x, e.torque.y, e.torque.z, static_cast<double>(e.touching)});
  }

  ParticleBlockJob tile_job(const Tile& t) {
    const Vec3& g = bed_.options.gravity;
    return {.spheres = bed_.spheres.data(),
            .mixed = bed_.is_mixed() ? bed_.mixed.data() : nullptr,
            .begin = t.begin,
            .end = t.end,
            .ring = ring_,
            .gravity = {g.x, g.y, g.z},
            .uniform = t.uniform};
  }

  /// Energies and state at t_n, from complete sums and before the move.
  void observe(Tile& t) {
    ObserveJob job{tile_job(t)};
    job.before = bed_.dt_before, job.dt = dt_;
    bed_.kernel.observe(job);
    t.kinetic = job.kinetic, t.spin = job.spin, t.gravity = job.potential;
    if (request_.snapshot == nullptr) return;
    for (std::uint32_t i = t.begin; i < t.end; ++i)
      at(i, [&](const auto& sum) { write(bed_.sphere(i), sum, *request_.snapshot); });
  }
  template <class Sum>
  void write(const Sphere& s, const Sum& a, Snapshot& out) const {
    const auto vector = [](const auto& x) {
      return Vec3{static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
    };
    const Vec3 force = vector(a.f) + s.m * bed_.options.gravity, torque = vector(a.t);
    const std::size_t k = bed_.slot_of_id[s.id];
    out.id[k] = s.id;
    out.radius[k] = s.r;
    out.material[k] = s.material;
    out.position[k] = s.x;
    out.velocity[k] = s.v + force * (0.5 * bed_.dt_before / s.m);
    out.spin[k] = s.w + torque * (0.5 * bed_.dt_before / inertia(s));
    out.force[k] = force;
    out.torque[k] = torque;
    out.contacts[k] = static_cast<int>(a.t[3]);
  }

  void move(Tile& t) {
    MoveJob job{tile_job(t)};
    job.kick = 0.5 * (dt_ + bed_.dt_before), job.dt = dt_;
    bed_.kernel.move(job);
    t.speed2 = job.speed2;
    t.squares = job.squares;
    t.step = std::sqrt(job.speed2) * dt_;
  }

  Bed::Impl& bed_;
  Worker& w_;
  double dt_;
  const Bed::Request& request_;
  Ring ring_;
  std::size_t border_ = 0;  ///< next block at the border
  std::uint32_t reached_;   ///< next tile that gets what comes across seams
  Booking booking_;         ///< of the tile
};

void resize(Snapshot& s, std::size_t n) {
  s.id.resize(n), s.radius.resize(n), s.material.resize(n), s.contacts.resize(n);
  for (auto* column : {&s.position, &s.velocity, &s.spin, &s.force, &s.torque}) column->resize(n);
}

}  // namespace

/// Blocks of a run may be of several threads.
void Bed::Impl::note_break(std::uint32_t run) { std::atomic_ref(run_broke[run]).store(1, std::memory_order_relaxed); }

/// Blocks that are evaluated before the sweep, run by run.
void Bed::Impl::run_errands(Worker& w) {
  for (const Errand& errand : w.errands) {
    Border& border = workers[errand.owner].border;
    const auto [tile, r, evaluator] = border.place[errand.first];
    const PairRun& run = runs[r];
    if (run.seam)
      for (std::uint32_t k = errand.first; k < errand.end; ++k) interface_given[run.rows + border.block[k]] = 0;
    if (run.near && tiles[tile].path < run.wakes) {
      std::fill(border.awake.begin() + errand.first, border.awake.begin() + errand.end, 0);
      continue;
    }
    PairJob job = pair_job(run, tiles[tile], booking(tile), dt_before);
    border.offer(job, errand.first, errand.end);
    job.halo = true;
    kernel.pairs(law(run.law), job);
    job.record = job.record || !is_usual(law(run.law));  // as they were evaluated
    kernel.keep(job);
    if (job.broke) note_break(r);
  }
  w.errands_done.raise(sweeps);
}

void Bed::Impl::run_sweep(double dt, const Request& request) {
  if (request.snapshot != nullptr) resize(*request.snapshot, spheres.size());
  const double elapsed = dt_before;
  spheres_behind = is_mixed();
  plane_jobs.clear();
  for (const Boundary& b : boundaries) plane_jobs.push_back(plane_job(b, elapsed));
  const int chunk_count = static_cast<int>(chunks.size());
  ++sweeps;
#pragma omp parallel num_threads(threads)
  {
    // One pass for each worker that OpenMP did not grant a thread of its own.
    const int team = omp_get_num_threads();
    const int rank = omp_get_thread_num();
    for (int t = rank; t < threads; t += team) {
      Worker& w = workers[static_cast<std::size_t>(t)];
      w.spent = {};
      const double from = WorkerTimer::now();
      PhaseClock clock(measures_phases);
      const int first = chunk_count * t / threads, last = chunk_count * (t + 1) / threads;
      for (int c = first; c < last; ++c) surface_chunk(chunks[static_cast<std::size_t>(c)], elapsed);
      w.chunks_done.raise(sweeps);
      clock.end(w.spent.surfaces);
      run_errands(w);
      clock.end(w.spent.pairs);
      w.before_sweep = WorkerTimer::now() - from;
    }
    // These contacts may be of anybody's spheres.
    if (chunk_count > 0)
      for (Worker& w : workers) w.chunks_done.await(sweeps);
    for (int t = rank; t < threads; t += team) {
      Worker& w = workers[static_cast<std::size_t>(t)];
      const double from = WorkerTimer::now();
      Sweep(*this, w, dt, request).run();
      w.pace.add(w.before_sweep + WorkerTimer::now() - from);
    }
  }
}

void Bed::Impl::plan_book(const Request& request, bool new_lists) {
  constexpr std::size_t few = 5000;
  constexpr int sampled = 32;
  const int every = options.book_every > 0 ? options.book_every : spheres.size() <= few ? 1 : sampled;
  sampling.begin(every, steps, new_lists);
  // Spheres placed into each other are found at once.
  book_all = request.energy || request.snapshot != nullptr || steps == 0;
}

Booking Bed::Impl::booking(std::size_t tile) const {
  Booking of = sampling.of(tile);
  if (book_all) of.book = of.sum = true;
  return of;
}

void Bed::Impl::sum_up(const Request& request) {
  extremes = {};
  double pairs = 0, farthest_step = 0;
  for (const Tile& t : tiles) {
    extremes.speed2 = std::max(extremes.speed2, t.speed2);
    extremes.overlap = std::max(extremes.overlap, t.overlap);
    extremes.squares += t.squares;
    farthest_step = std::max(farthest_step, t.step);
    pairs += t.pairs;
  }
  extremes.pairs = static_cast<std::size_t>(pairs);
  path += farthest_step;
  for (const SurfaceChunk& c : chunks)
    if (exceeds(c.max_overlap, extremes.overlap)) extremes.overlap = c.max_overlap;
  for (Tile& t : tiles) {
    double longest = 0;
    for (std::size_t k = static_cast<std::size_t>(&t - tiles.data()); k <= t.last; ++k)
      longest = std::max(longest, tiles[k].step);
    for (std::size_t k = t.seam_first; k <= t.seam_last; ++k) longest = std::max(longest, tiles[k].step);
    t.path += longest;
  }
  sum_surfaces(dt_before);
  if (!request.energy) return;
  energy = {.lost = lost_before, .removed = removed_energy};
  for (const Tile& t : tiles) {
    energy.kinetic += t.kinetic;
    energy.spin += t.spin;
    energy.gravity += t.gravity;
    energy.stored += t.stored;
    energy.lost += t.lost;
  }
  for (const SurfaceChunk& c : chunks) energy.stored += c.stored, energy.lost += c.lost;
  for (const Boundary& b : boundaries) energy.boundary_work += b.work;
}

/// What the threads spent, and what of their time by the clock is left over.
void Bed::Impl::sum_phases(double search, double sweep) {
  phases.search += search * threads;
  double spent = 0;
  for (const Worker& w : workers) {
    phases.pairs += w.spent.pairs, phases.surfaces += w.spent.surfaces, phases.move += w.spent.move;
    spent += w.spent.pairs + w.spent.surfaces + w.spent.move;
  }
  phases.rest += sweep * threads - spent;
}

/// Sphere of the deepest contact, for a message; after the move, which changes overlaps by a step's path.
std::uint32_t Bed::Impl::deepest_sphere() const {
  std::uint32_t deepest = 0;
  double largest = 0;
  const auto offer = [&](double share, std::uint32_t sphere) {
    if (exceeds(share, largest)) largest = share, deepest = sphere;
  };
  for (const SurfaceChunk& c : chunks) offer(c.max_overlap, c.worst);
  for (const PairBlock& block : blocks.all())
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const Sphere &a = spheres[block.i[l]], &b = spheres[block.j[l]];
      offer((a.r + b.r - norm(a.x - b.x)) / std::min(a.r, b.r), block.i[l]);
    }
  for (const PlaneRun& run : plane_runs)
    for (std::uint32_t k = 0; k < run.contacts; ++k) {
      const PlaneBlock& p = plane_blocks[run.first + k / kBlock];
      const std::uint32_t l = k % kBlock;
      const Sphere& s = spheres[p.sphere[l]];
      const Vec3 n{p.normal[0][l], p.normal[1][l], p.normal[2][l]};
      offer((s.r - dot(n, boundaries[run.boundary].pose.to_local(s.x)) + p.offset[l]) / s.r, p.sphere[l]);
    }
  return deepest;
}

void Bed::Impl::check_faults() {
  char text[400];
  // A maximum passes over what is no number, a sum does not.
  if (!(extremes.speed2 <= options.speed_limit * options.speed_limit) || !std::isfinite(extremes.squares)) {
    sync_from_mixed();
    std::size_t fastest = 0;
    double speed2 = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i)
      if (const double v2 = dot(spheres[i].v, spheres[i].v); exceeds(v2, speed2)) speed2 = v2, fastest = i;
    const Sphere& s = spheres[fastest];
    const double speed = std::sqrt(speed2);
    std::snprintf(
        text, sizeof text,
        "t = %.9g s: sphere %u at (%.6g, %.6g, %.6g) m moves at %.6g m/s, limit %.6g m/s: the step is too long, a "
        "surface moves too fast, or spheres were placed into each other; raise limits.speed only if this speed "
        "is meant",
        time, s.id, s.x.x, s.x.y, s.x.z, speed, options.speed_limit);
    throw BedFault(text);
  }
  if (!(extremes.overlap <= options.overlap_limit)) {
    sync_from_mixed();
    const Sphere& s = spheres[deepest_sphere()];
    std::snprintf(
        text, sizeof text,
        "t = %.9g s: sphere %u at (%.6g, %.6g, %.6g) m overlaps by %.4g of a radius, limit %.4g: the law is too "
        "soft for this load, or spheres or surfaces were placed into each other",
        time, s.id, s.x.x, s.x.y, s.x.z, extremes.overlap, options.overlap_limit);
    throw BedFault(text);
  }
}

}  // namespace subsoil::dem
