#include "libdem/step/surface_forces.hpp"

#include <algorithm>
#include <cmath>

#include "libdem/base/small_rotation.hpp"
#include "libdem/particles/fixed.hpp"
#include "libdem/step/energy_balance.hpp"
#include "libdem/step/surface_motion.hpp"

namespace subsoil::dem {
namespace {

class ChunkRun {
 public:
  ChunkRun(const SurfaceForces& of, SurfaceChunk& chunk)
      : of_(of), chunk_(chunk), boundary_(of.boundaries[chunk.boundary]) {
    job_.spheres = of.particles.spheres().data();
    job_.mixed = of.particles.mixed();
    job_.elapsed = of.elapsed;
    job_.count = 0;
  }

  void run() {
    chunk_.wrench = {};
    std::fill(chunk_.meshes.begin(), chunk_.meshes.end(), Wrench{});
    chunk_.stored = 0;
    chunk_.contacts = 0;
    chunk_.max_overlap = 0;
    chunk_.recorded.clear();
    chunk_.at_edges.clear();
    for (std::uint32_t k = chunk_.begin; k < chunk_.end; ++k) touch(of_.contacts.entries[k]);
    flush();
  }

 private:
  struct Lane {
    SurfaceEntry* entry;
    int contact;  ///< -1: ended
    std::uint32_t mesh;
    Vec3 point;
    const CuttingEdge* edge = nullptr;  ///< at which it is; of the boundary, shape axes
  };

  void touch(SurfaceEntry& e) {
    const Sphere s = of_.particles.now(e.sphere);
    e.force = e.torque = {};
    e.touching = 0;
    use_law(static_cast<std::uint32_t>(of_.laws.between(s.material, boundary_.material)));
    SurfaceContact now[kMaxSurfaceContacts];
    const std::span<const std::uint32_t> near(of_.contacts.candidates.data() + e.candidates_begin,
                                              e.candidates_end - e.candidates_begin);
    const std::size_t n = contacts(boundary_.shape, boundary_.pose.to_local(s.x), s.r + of_.laws.surface_cutoff(law_),
                                   near, now, kMaxSurfaceContacts);
    if (n == 0 && e.live == 0) return;

    Vec3 normals[kMaxSurfaceContacts];
    PairState states[kMaxSurfaceContacts];
    bool continued[kMaxSurfaceContacts] = {};
    const std::uint32_t were = e.live;
    for (std::uint32_t c = 0; c < were; ++c) normals[c] = e.contact[c].normal, states[c] = e.contact[c].state;
    int from[kMaxSurfaceContacts];
    match_contacts({now, n}, {normals, were}, from);
    e.live = static_cast<std::uint32_t>(n);
    for (std::size_t c = 0; c < n; ++c) {
      const bool continues = from[c] >= 0;
      if (continues) continued[from[c]] = true;
      e.contact[c].normal = now[c].normal;
      add_lane(s, now[c], continues ? &normals[from[c]] : nullptr, continues ? states[from[c]] : PairState{},
               {&e, static_cast<int>(c), now[c].surface, {}, edge_at(boundary_.edges, now[c].point, kAtEdge * s.r)});
    }
    for (std::uint32_t c = 0; c < were; ++c)
      if (!continued[c]) add_ended(s, normals[c], states[c], e);
  }

  /// All lanes of a job have one law.
  void use_law(std::uint32_t law) {
    if (law != law_) flush();
    law_ = law;
    job_.cutoff = of_.laws.surface_cutoff(law);
  }

  void add_lane(const Sphere& s, const SurfaceContact& c, const Vec3* before, const PairState& state, Lane lane) {
    const Vec3 n = boundary_.pose.attitude.rotate(c.normal);
    lane.point = s.x - n * c.distance;
    fill(s, n, c.distance, normal_turn(boundary_, c.normal, before, job_.elapsed), state, lane);
  }

  void add_ended(const Sphere& s, const Vec3& normal, const PairState& state, SurfaceEntry& e) {
    // Just beyond the law's cutoff, where it drops its springs and accounts for them; with the true velocity, since the
    // dashpots still worked over half of this step.
    const Vec3 n = boundary_.pose.attitude.rotate(normal);
    const double distance = (s.r + job_.cutoff) * (1 + 1e-9);
    fill(s, n, distance, normal_turn(boundary_, normal, nullptr, job_.elapsed), state, {&e, -1, 0, {}});
  }

  void fill(const Sphere& s, const Vec3& n, double distance, const Vec3& turn, const PairState& state,
            const Lane& lane) {
    const std::uint32_t k = job_.count++;
    put_contact(job_, k, lane.entry->sphere, s, of_.particles.mass_at_surface(lane.entry->sphere), boundary_, n,
                distance, turn);
    write_lane(memory(), shape(), k, state);
    lane_[k] = lane;
    if (job_.count == kBlock) flush();
  }

  const MemoryShape& shape() const { return of_.laws.surface_memory(law_); }
  BlockMemory memory() { return BlockMemory::at(job_.lines, 1, shape(), 0); }

  void flush() {
    if (job_.count == 0) return;
    repeat_first(job_);
    for (std::uint32_t k = job_.count; k < kBlock; ++k) write_lane(memory(), shape(), k, PairState{});
    of_.kernel.surface(of_.laws[law_], job_);
    for (std::uint32_t k = 0; k < job_.count; ++k) {
      chunk_.lost += Losses{job_.sums.damped[k], job_.sums.slid[k], job_.sums.rolled[k]};
      if (lane_[k].contact < 0) continue;
      SurfaceEntry& e = *lane_[k].entry;
      e.contact[lane_[k].contact].state = read_lane(memory(), shape(), k);
      const Four &t = job_.t_i[k], &roll = job_.t_j[k];
      const Vec3 f{job_.f[k][0], job_.f[k][1], job_.f[k][2]};
      e.force += f;
      e.torque += {t[0], t[1], t[2]};
      const Vec3 moment = Vec3{roll[0], roll[1], roll[2]} - cross(lane_[k].point - boundary_.pose.position, f);
      chunk_.wrench.force -= f;
      chunk_.wrench.moment += moment;
      if (!chunk_.meshes.empty()) chunk_.meshes[lane_[k].mesh] += {-f, moment};
      chunk_.stored += job_.sums.stored[k];
      if (chunk_.records) record(k, f);
      if (lane_[k].edge != nullptr) press(k, f);
      ++chunk_.contacts;
      if (t[3] > 0) ++e.touching;
      if (exceeds(job_.sums.overlap[k], chunk_.max_overlap))
        chunk_.max_overlap = job_.sums.overlap[k], chunk_.worst = e.sphere;
    }
    job_.count = 0;
  }

  void record(std::uint32_t k, const Vec3& force) {
    if (force.x == 0 && force.y == 0 && force.z == 0) return;
    const Sphere s = of_.particles.now(job_.sphere[k]);
    chunk_.recorded.push_back(record_of(job_, k, s, chunk_.boundary, lane_[k].point, force));
  }

  /// Normal force and friction, as a blade's load is measured; only their part in the direction in which the edge
  /// points, so that the flank of the blade pushes a fibre aside.
  void press(std::uint32_t k, const Vec3& force) {
    const auto world = [&](const Vec3& own) { return boundary_.pose.attitude.rotate(own); };
    const Vec3 n{job_.normal[0][k], job_.normal[1][k], job_.normal[2][k]}, outward = world(lane_[k].edge->outward);
    const double pushed = dot(force, outward);
    if (pushed > 0)
      chunk_.at_edges.push_back({job_.sphere[k], chunk_.boundary, pushed, n, world(lane_[k].edge->along()), outward});
  }

  /// Of a radius: how far from the edge a contact with its faces still presses on the fibre by the edge. Between two
  /// spheres a blade touches both with its faces, a sine of half its angle from the edge.
  static constexpr double kAtEdge = 1;

  const SurfaceForces& of_;
  SurfaceChunk& chunk_;
  const Boundary& boundary_;
  SurfaceJob job_;
  Lane lane_[kBlock];
  std::uint32_t law_ = kGone;
};

}  // namespace

void SurfaceForces::evaluate(SurfaceChunk& chunk) const { ChunkRun(*this, chunk).run(); }

void put_contact(SurfaceJob& job, std::uint32_t lane, std::uint32_t sphere, const Sphere& s, double mass,
                 const Boundary& b, const Vec3& n, double distance, const Vec3& turn) {
  const Vec3 v = surface_velocity(b, s.x, s.v, n, distance, turn, job.elapsed);
  job.sphere[lane] = sphere, job.distance[lane] = distance, job.mass[lane] = mass;
  for (int d = 0; d < 3; ++d) {
    job.normal[d][lane] = n[d], job.turn[d][lane] = turn[d];
    job.velocity[d][lane] = v[d], job.angular_velocity[d][lane] = b.angular_velocity[d];
  }
}

void repeat_first(SurfaceJob& job) {
  for (std::uint32_t k = job.count; k < kBlock; ++k) {
    job.sphere[k] = job.sphere[0], job.distance[k] = job.distance[0], job.mass[k] = job.mass[0];
    for (int d = 0; d < 3; ++d)
      for (auto* column : {job.normal[d], job.turn[d], job.velocity[d], job.angular_velocity[d]}) column[k] = column[0];
  }
}

ContactRecord record_of(const SurfaceJob& job, std::uint32_t lane, const Sphere& s, std::uint32_t boundary,
                        const Vec3& point, const Vec3& force) {
  const auto at = [&](const auto& columns) { return Vec3{columns[0][lane], columns[1][lane], columns[2][lane]}; };
  const Vec3 n = at(job.normal);
  return {.i = s.id,
          .j = boundary,
          .at_surface = true,
          .point = point,
          .normal = n,
          .force = force,
          .velocity = contact_velocity(s.v - at(job.velocity), s.w, n, job.distance[lane], at(job.turn), job.elapsed),
          .stored = job.sums.stored[lane]};
}

PlaneJob plane_job(const Boundary& b, const ParticleStore& particles, double elapsed) {
  PlaneJob job{};
  job.spheres = particles.spheres().data();
  job.mixed = particles.mixed();
  if (!particles.is_mixed() && !particles.masses().empty()) job.masses = particles.masses().data();
  job.elapsed = elapsed;
  for (int column = 0; column < 3; ++column) {
    Vec3 axis{};
    axis[column] = 1;
    axis = b.pose.attitude.rotate(axis);
    for (int row = 0; row < 3; ++row) job.rotation[row][column] = axis[row];
    job.position[column] = b.pose.position[column];
    job.velocity[column] = b.velocity[column];
    job.angular_velocity[column] = b.angular_velocity[column];
  }
  return job;
}

void add_boundary_work(std::span<Boundary> boundaries, double elapsed) {
  for (Boundary& b : boundaries) {
    if (elapsed > 0) {
      const Vec3 path = b.pose.position - b.pose_before.position;
      const Vec3 angle = small_rotation(b.pose_before.attitude, b.pose.attitude);
      b.work -= 0.5 * (dot(b.wrench.force + b.wrench_before.force, path) +
                       dot(b.wrench.moment + b.wrench_before.moment, angle));
    }
    b.pose_before = b.pose;
  }
}

void sum_wrenches(std::vector<Boundary>& boundaries, const SurfaceContacts& contacts, double elapsed) {
  for (Boundary& b : boundaries) {
    b.wrench_before = b.wrench, b.wrench = {}, b.contacts = 0;
    std::fill(b.meshes.begin(), b.meshes.end(), Wrench{});
  }
  for (const PlaneRun& r : contacts.plane_runs) {
    Boundary& b = boundaries[r.boundary];
    b.wrench += r.wrench;
    if (!b.meshes.empty()) b.meshes[r.mesh] += r.wrench;
    b.contacts += static_cast<int>(r.in_reach);
  }
  for (const SurfaceChunk& c : contacts.chunks) {
    Boundary& b = boundaries[c.boundary];
    b.wrench += c.wrench;
    for (std::size_t m = 0; m < c.meshes.size(); ++m) b.meshes[m] += c.meshes[m];
    b.contacts += c.contacts;
  }
  add_boundary_work(boundaries, elapsed);
}

}  // namespace subsoil::dem
