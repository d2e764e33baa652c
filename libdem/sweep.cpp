#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "libdem/bed_impl.hpp"

/// One step of the bed: surface contacts and contacts across thread borders first, then one fused sweep in which each
/// thread walks its spheres in ascending order, adds each contact to both partners and moves a sphere as soon as its
/// last contact is done. In place: a contact owned by a later sphere never needs an earlier one.
///
/// Why not a force array and a second pass: forces would travel through memory twice (24 against 10 ns per
/// particle-step in a trial). Why not per-thread force sums: the order of additions, and so the last bits, would follow
/// the threads.
namespace subsoil::dem {

void Extremes::take(const Extremes& b) {
  if (exceeds(b.speed2, speed2)) speed2 = b.speed2, fastest = b.fastest;
  if (exceeds(b.overlap, overlap)) overlap = b.overlap, deepest = b.deepest;
  pairs += b.pairs;
}

/// A lane of the batch for a pair of spheres; a pair that was out of reach starts without history.
static void load_pair(Batch& b, int lane, const Sphere& i, const Sphere& j, int law, PairState& state, bool live) {
  if (!live) state = PairState{};
  b.owner[lane] = &i;
  b.other[lane] = &j;
  b.state[lane] = &state;
  b.law[lane] = static_cast<unsigned char>(law);
}

/// Contacts whose partner belongs to a later thread.
void Bed::Impl::border_contacts(Worker& worker, double elapsed) {
  Batch& b = worker.batch;
  BorderContact* lanes[Batch::lanes];
  int count = 0;
  const auto flush = [&] {
    if (count == 0) return;
    kernel.evaluate(laws, b, count, elapsed);
    for (int k = 0; k < count; ++k) lanes[k]->force = b.out[k];
    count = 0;
  };
  for (BorderContact& c : worker.border) {
    const Sphere &i = spheres[c.owner], &j = spheres[c.other];
    const int law = laws.of(i.material, j.material);
    const Vec3 d = i.x - j.x;
    const double limit = i.r + j.r + reach(law);
    c.in_reach = dot(d, d) < limit * limit;
    c.active = c.in_reach || pairs.live[c.pair];
    if (!c.active) continue;
    load_pair(b, count, i, j, law, pairs.state[c.pair], pairs.live[c.pair]);
    pairs.live[c.pair] = c.in_reach;
    lanes[count++] = &c;
    if (count == Batch::lanes) flush();
  }
  flush();
}

namespace {

/// The walk of one thread through its spheres.
class Sweep {
 public:
  Sweep(Bed::Impl& bed, Worker& worker, double dt, const Bed::Request& request)
      : bed_(bed),
        w_(worker),
        dt_(dt),
        kick_(0.5 * (dt + bed.dt_before)),
        request_(request),
        mask_(static_cast<std::uint32_t>(worker.ring.size() - 1)),
        done_(worker.begin) {}

  void run(std::size_t me) {
    w_.extremes = {};
    for (std::uint32_t tile = w_.begin / kTile; tile * kTile < w_.end; ++tile) clear(bed_.tiles[tile]);
    receive_borders(me);
    if (const int law = bed_.single_law; law >= 0)
      walk([law](const Sphere&, const Sphere&) { return law; });
    else
      walk([this](const Sphere& a, const Sphere& b) { return bed_.laws.of(a.material, b.material); });
    flush(w_.end);
  }

 private:
  /// Collects the contacts of each owner in turn. Pointers are locals: the byte stores to `live` may alias anything,
  /// and members would be read again after each of them.
  template <class LawOf>
  void walk(LawOf law_of) {
    const Sphere* const spheres = bed_.spheres.data();
    const std::uint32_t* const start = bed_.pairs.start.data();
    const std::uint32_t* const others = bed_.pairs.other.data();
    PairState* const states = bed_.pairs.state.data();
    std::uint8_t* const live = bed_.pairs.live.data();
    const double* const reach = bed_.law_reach.data();
    const std::uint32_t end = w_.end;
    std::size_t border = 0, in_reach_count = 0;
    for (std::uint32_t i = w_.begin; i < end; ++i) {
      const Sphere& s = spheres[i];
      for (std::uint32_t p = start[i], last = start[i + 1]; p < last; ++p) {
        const std::uint32_t j = others[p];
        if (j >= end) {
          add_border(border++, i);
          continue;
        }
        const Sphere& o = spheres[j];
        const Vec3 d = s.x - o.x;
        const int law = law_of(s, o);
        const double limit = s.r + o.r + reach[law];
        const bool in_reach = dot(d, d) < limit * limit, was = live[p] != 0;
        if (!in_reach && !was) continue;
        load_pair(w_.batch, lanes_, s, o, law, states[p], was);
        live[p] = in_reach;
        in_reach_count += in_reach;
        queue_[queued_++] = {i, j, &w_.batch.out[lanes_++]};
        if (lanes_ == Batch::lanes || queued_ == kQueue) flush(i);
      }
      if (i + 1 - done_ >= kTile) flush(i + 1);
    }
    w_.extremes.pairs += in_reach_count;
  }

  /// A contact in its place in the order of additions; its force comes from the batch or from the border list.
  struct Queued {
    std::uint32_t owner, other;
    const ContactForce* force;
  };
  static constexpr int kQueue = 2 * Batch::lanes;
  static constexpr std::uint32_t kElsewhere = ~std::uint32_t{0};

  static void clear(TileSums& t) {
    t = {.lost = t.lost};
    t.lost[3] = 0;
  }

  void add_border(std::size_t index, std::uint32_t owner) {
    const BorderContact& c = w_.border[index];
    if (!c.active) return;
    w_.extremes.pairs += c.in_reach;
    queue_[queued_++] = {owner, kElsewhere, &c.force};
    if (queued_ == kQueue) flush(owner);
  }

  Accumulator& at(std::uint32_t i) { return w_.ring[i & mask_]; }

  /// What earlier threads owe to spheres of this one, in ascending order of owner: as one thread would have added it.
  void receive_borders(std::size_t me) {
    w_.foreign.clear();
    for (std::size_t t = 0; t < me; ++t)
      for (const BorderContact& c : bed_.workers[t].border)
        if (c.active && c.other >= w_.begin && c.other < w_.end) w_.foreign.push_back({c.other, &c});
    std::stable_sort(w_.foreign.begin(), w_.foreign.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
  }

  void add_foreign(std::uint32_t i, Accumulator& a) {
    for (; next_foreign_ < w_.foreign.size() && w_.foreign[next_foreign_].first == i; ++next_foreign_) {
      const ContactForce& c = w_.foreign[next_foreign_].second->force;
      a.f -= c.f;
      a.t += c.t_j;
    }
  }

  void flush(std::uint32_t complete) {
    if (lanes_ > 0) bed_.kernel.evaluate(bed_.laws, w_.batch, lanes_, bed_.dt_before);
    // The owner's sum stays in registers while its contacts follow each other; no contact of its own is among its
    // others.
    std::uint32_t owner = kElsewhere;
    Four f{}, t{}, e{};
    double deepest = w_.extremes.overlap;
    const auto put_back = [&] {
      if (owner == kElsewhere) return;
      Accumulator& a = at(owner);
      a.f = f;
      a.t = t;
      TileSums& tile = bed_.tiles[owner / kTile];
      tile.lost = e;
    };
    for (int k = 0; k < queued_; ++k) {
      const ContactForce& c = *queue_[k].force;
      if (queue_[k].owner != owner) {
        put_back();
        owner = queue_[k].owner;
        const Accumulator& a = accumulator(owner);
        f = a.f;
        t = a.t;
        e = bed_.tiles[owner / kTile].lost;
      }
      f += c.f;
      t += c.t_i;
      e += c.e;
      if (queue_[k].other != kElsewhere) {
        Accumulator& other = accumulator(queue_[k].other);
        other.f -= c.f;
        other.t += c.t_j;
      }
      if (exceeds(c.f[3], deepest)) deepest = c.f[3], w_.extremes.deepest = owner;
    }
    put_back();
    w_.extremes.overlap = deepest;
    lanes_ = queued_ = 0;
    for (; done_ < complete; ++done_) move(done_);
  }

  /// The place where a sphere's sum grows; what earlier threads owe comes first.
  Accumulator& accumulator(std::uint32_t i) {
    Accumulator& a = at(i);
    while (opened_ <= i) {
      add_foreign(opened_, at(opened_));
      ++opened_;
    }
    return a;
  }

  void move(std::uint32_t i) {
    Sphere& s = bed_.spheres[i];
    Accumulator& a = accumulator(i);
    Vec3 f{a.f[0], a.f[1], a.f[2]}, t{a.t[0], a.t[1], a.t[2]};
    double touching = a.t[3];
    a = Accumulator{};
    for (std::uint32_t k = bed_.entry_start[i]; k < bed_.entry_start[i + 1]; ++k) {
      const SurfaceEntry& e = bed_.entries[bed_.entry_of[k]];
      f += e.force;
      t += e.torque;
      touching += e.touching;
    }
    f += bed_.options.gravity * s.m;
    const double inertia_i = inertia(s);
    const Vec3 dv = f * (kick_ / s.m), dw = t * (kick_ / inertia_i);
    if (request_.energy) {
      // (m/2) v_{n-1/2} . v_{n+1/2}; with an uneven kick the mean velocity at t_n is v + a dt_before/2.
      TileSums& tile = bed_.tiles[i / kTile];
      const Vec3 a_n = f * (1 / s.m), alpha_n = t * (1 / inertia_i);
      const Vec3 v_n = s.v + a_n * (0.5 * bed_.dt_before), w_n = s.w + alpha_n * (0.5 * bed_.dt_before);
      const double q = 0.25 * dt_ * bed_.dt_before;
      tile.kinetic += 0.5 * s.m * (dot(v_n, v_n) - q * dot(a_n, a_n));
      tile.spin += 0.5 * inertia_i * (dot(w_n, w_n) - q * dot(alpha_n, alpha_n));
      tile.gravity -= s.m * dot(bed_.options.gravity, s.x);
    }
    if (request_.snapshot != nullptr) record(*request_.snapshot, s, f, t, touching);
    s.v += dv;
    s.w += dw;
    s.x += s.v * dt_;
    const double speed2 = dot(s.v, s.v);
    bed_.tiles[i / kTile].half_step_kinetic += 0.5 * s.m * speed2 + 0.5 * inertia_i * dot(s.w, s.w);
    if (exceeds(speed2, w_.extremes.speed2)) w_.extremes.speed2 = speed2, w_.extremes.fastest = i;
  }

  void record(Snapshot& out, const Sphere& s, const Vec3& f, const Vec3& t, double touching) const {
    const std::size_t k = bed_.slot_of_id[s.id];
    out.id[k] = s.id;
    out.radius[k] = s.r;
    out.material[k] = s.material;
    out.position[k] = s.x;
    out.velocity[k] = s.v + f * (0.5 * bed_.dt_before / s.m);
    out.spin[k] = s.w + t * (0.5 * bed_.dt_before / inertia(s));
    out.force[k] = f;
    out.torque[k] = t;
    out.contacts[k] = static_cast<int>(touching);
  }

  Bed::Impl& bed_;
  Worker& w_;
  double dt_, kick_;
  const Bed::Request& request_;
  std::uint32_t mask_, done_;
  std::uint32_t opened_ = w_.begin;
  Queued queue_[kQueue];
  int lanes_ = 0, queued_ = 0;
  std::size_t next_foreign_ = 0;
};

void resize(Snapshot& s, std::size_t n) {
  s.id.resize(n), s.radius.resize(n), s.material.resize(n), s.contacts.resize(n);
  for (auto* column : {&s.position, &s.velocity, &s.spin, &s.force, &s.torque}) column->resize(n);
}

}  // namespace

void Bed::Impl::run_sweep(double dt, const Request& request) {
  if (request.snapshot != nullptr) resize(*request.snapshot, spheres.size());
  const double elapsed = dt_before;
  const int chunk_count = static_cast<int>(chunks.size());
#pragma omp parallel num_threads(threads)
  {
    // One pass for each worker that OpenMP did not grant a thread of its own.
    const int team = omp_get_num_threads();
    const int rank = omp_get_thread_num();
    for (int t = rank; t < threads; t += team) {
      Worker& w = workers[static_cast<std::size_t>(t)];
      const int first = chunk_count * t / threads, last = chunk_count * (t + 1) / threads;
      for (int c = first; c < last; ++c) surface_chunk(chunks[static_cast<std::size_t>(c)], w.batch, elapsed);
      border_contacts(w, elapsed);
    }
#pragma omp barrier
    for (int t = rank; t < threads; t += team)
      Sweep(*this, workers[static_cast<std::size_t>(t)], dt, request).run(static_cast<std::size_t>(t));
  }
}

void Bed::Impl::sum_up(double dt, const Request& request) {
  extremes = {};
  for (const Worker& w : workers) extremes.take(w.extremes);
  for (const SurfaceChunk& c : chunks)
    if (exceeds(c.max_overlap, extremes.overlap)) extremes.overlap = c.max_overlap, extremes.deepest = c.worst;
  for (const TileSums& t : tiles) extremes.kinetic += t.half_step_kinetic;
  sum_surfaces(dt_before);
  if (request.energy) {
    energy = {.lost = lost_before, .removed = removed_energy};
    for (const TileSums& t : tiles) {
      energy.kinetic += t.kinetic;
      energy.spin += t.spin;
      energy.gravity += t.gravity;
      energy.stored += t.lost[3];
      energy.lost += losses_of(t.lost);
    }
    for (const SurfaceChunk& c : chunks) energy.stored += c.stored, energy.lost += c.lost;
    for (const Boundary& b : boundaries) energy.boundary_work += b.work;
  }
  moved += std::sqrt(extremes.speed2) * dt;
}

void Bed::Impl::check_faults() const {
  char text[400];
  const double speed = std::sqrt(extremes.speed2);
  if (!(speed <= options.speed_limit)) {
    const Sphere& s = spheres[extremes.fastest];
    std::snprintf(
        text, sizeof text,
        "t = %.9g s: sphere %u at (%.6g, %.6g, %.6g) m moves at %.6g m/s, limit %.6g m/s: the step is too long, a "
        "surface moves too fast, or spheres were placed into each other; raise limits.speed only if this speed "
        "is meant",
        time, s.id, s.x.x, s.x.y, s.x.z, speed, options.speed_limit);
    throw BedFault(text);
  }
  if (!(extremes.overlap <= options.overlap_limit)) {
    const Sphere& s = spheres[extremes.deepest];
    std::snprintf(
        text, sizeof text,
        "t = %.9g s: sphere %u at (%.6g, %.6g, %.6g) m overlaps by %.4g of a radius, limit %.4g: the law is too "
        "soft for this load, or spheres or surfaces were placed into each other",
        time, s.id, s.x.x, s.x.y, s.x.z, extremes.overlap, options.overlap_limit);
    throw BedFault(text);
  }
}

}  // namespace subsoil::dem
