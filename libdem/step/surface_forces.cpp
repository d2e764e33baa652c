#include "libdem/step/surface_forces.hpp"

#include <algorithm>
#include <cmath>

#include "libdem/base/small_rotation.hpp"
#include "libdem/step/energy_balance.hpp"
#include "libdem/step/surface_velocity.hpp"

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
    for (std::uint32_t k = chunk_.begin; k < chunk_.end; ++k) touch(of_.contacts.entries[k]);
    flush();
  }

 private:
  struct Lane {
    SurfaceEntry* entry;
    int contact;  ///< -1: ended
    std::uint32_t mesh;
    Vec3 point;
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
      if (from[c] >= 0) continued[from[c]] = true;
      e.contact[c].normal = now[c].normal;
      add_lane(s, now[c], from[c] >= 0 ? states[from[c]] : PairState{}, {&e, static_cast<int>(c), now[c].surface, {}});
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

  void add_lane(const Sphere& s, const SurfaceContact& c, const PairState& state, Lane lane) {
    const Vec3 n = boundary_.pose.attitude.rotate(c.normal);
    lane.point = s.x - n * c.distance;
    fill(n, c.distance, surface_velocity(boundary_, lane.point, s.v, job_.elapsed), state, lane);
  }

  void add_ended(const Sphere& s, const Vec3& normal, const PairState& state, SurfaceEntry& e) {
    // Just beyond the law's cutoff, where it drops its springs and accounts for them; with the true velocity, since the
    // dashpots still worked over half of this step.
    const Vec3 n = boundary_.pose.attitude.rotate(normal);
    const double distance = (s.r + job_.cutoff) * (1 + 1e-9);
    fill(n, distance, surface_velocity(boundary_, s.x - n * distance, s.v, job_.elapsed), state, {&e, -1, 0, {}});
  }

  void fill(const Vec3& n, double distance, const Vec3& v, const PairState& state, const Lane& lane) {
    const std::uint32_t k = job_.count++;
    job_.sphere[k] = lane.entry->sphere;
    for (int d = 0; d < 3; ++d) {
      job_.normal[d][k] = n[d];
      job_.velocity[d][k] = v[d];
      job_.angular_velocity[d][k] = boundary_.angular_velocity[d];
    }
    job_.distance[k] = distance;
    write_lane(memory(), shape(), k, state);
    lane_[k] = lane;
    if (job_.count == kBlock) flush();
  }

  const MemoryShape& shape() const { return of_.laws.surface_memory(law_); }
  BlockMemory memory() { return BlockMemory::at(job_.lines, 1, shape(), 0); }

  void flush() {
    if (job_.count == 0) return;
    for (std::uint32_t k = job_.count; k < kBlock; ++k) {  // lanes beyond the last repeat the first
      job_.sphere[k] = job_.sphere[0];
      job_.distance[k] = job_.distance[0];
      for (int d = 0; d < 3; ++d) {
        job_.normal[d][k] = job_.normal[d][0], job_.velocity[d][k] = job_.velocity[d][0];
        job_.angular_velocity[d][k] = job_.angular_velocity[d][0];
      }
      write_lane(memory(), shape(), k, PairState{});
    }
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
    const Vec3 surface{job_.velocity[0][k], job_.velocity[1][k], job_.velocity[2][k]};
    chunk_.recorded.push_back({.i = s.id,
                               .j = chunk_.boundary,
                               .at_surface = true,
                               .point = lane_[k].point,
                               .normal = {job_.normal[0][k], job_.normal[1][k], job_.normal[2][k]},
                               .force = force,
                               .velocity = s.v + cross(s.w, lane_[k].point - s.x) - surface,
                               .stored = job_.sums.stored[k]});
  }

  const SurfaceForces& of_;
  SurfaceChunk& chunk_;
  const Boundary& boundary_;
  SurfaceJob job_;
  Lane lane_[kBlock];
  std::uint32_t law_ = kGone;
};

}  // namespace

void SurfaceForces::evaluate(SurfaceChunk& chunk) const { ChunkRun(*this, chunk).run(); }

PlaneJob plane_job(const Boundary& b, const ParticleStore& particles, double elapsed) {
  PlaneJob job{};
  job.spheres = particles.spheres().data();
  job.mixed = particles.mixed();
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
