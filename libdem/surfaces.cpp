#include <algorithm>
#include <cmath>

#include "libdem/bed_impl.hpp"

/// Contacts of spheres with boundaries: geometry one sphere at a time (geometry/), the law 32 contacts at a time.
namespace subsoil::dem {
namespace {

struct LaneOfEntry {
  SurfaceEntry* entry;
  int contact;  ///< -1: ended
  Vec3 point;
};

class ChunkRun {
 public:
  ChunkRun(Bed::Impl& bed, SurfaceChunk& chunk, Batch& batch, double elapsed)
      : bed_(bed), chunk_(chunk), batch_(batch), elapsed_(elapsed), boundary_(bed.boundaries[chunk.boundary]) {}

  void run() {
    chunk_.wrench = {};
    chunk_.stored = 0;
    chunk_.contacts = 0;
    chunk_.max_overlap = 0;
    for (std::uint32_t k = chunk_.begin; k < chunk_.end; ++k) touch(bed_.entries[k]);
    flush();
  }

 private:
  void touch(SurfaceEntry& e) {
    const Sphere& s = bed_.spheres[e.sphere];
    e.force = e.torque = {};
    e.touching = 0;
    const int law = bed_.laws.of(s.material, boundary_.material);
    SurfaceContact now[kMaxSurfaceContacts];
    const std::span<const std::uint32_t> near(bed_.candidates.data() + e.candidates_begin,
                                              e.candidates_end - e.candidates_begin);
    const std::size_t n =
        contacts(boundary_.shape, boundary_.pose.to_local(s.x), s.r + bed_.reach(law), near, now, kMaxSurfaceContacts);
    if (n == 0 && e.live == 0) return;
    if (lanes_ + static_cast<int>(n + e.live) > Batch::lanes) flush();

    Vec3 normals[kMaxSurfaceContacts];
    PairState states[kMaxSurfaceContacts];
    bool continued[kMaxSurfaceContacts] = {};
    for (std::uint32_t c = 0; c < e.live; ++c) normals[c] = e.contact[c].normal, states[c] = e.contact[c].state;
    int from[kMaxSurfaceContacts];
    match_contacts({now, n}, {normals, e.live}, from);
    for (std::size_t c = 0; c < n; ++c) {
      if (from[c] >= 0) continued[from[c]] = true;
      add_lane(s, law, now[c], from[c] >= 0 ? states[from[c]] : PairState{}, {&e, static_cast<int>(c), {}});
      e.contact[c].normal = now[c].normal;
    }
    for (std::uint32_t c = 0; c < e.live; ++c)
      if (!continued[c]) add_ended(s, law, normals[c], states[c], e);
    e.live = static_cast<std::uint32_t>(n);
  }

  void add_lane(const Sphere& s, int law, const SurfaceContact& c, const PairState& state, LaneOfEntry lane) {
    const Vec3 n = boundary_.pose.attitude.rotate(c.normal);
    lane.point = s.x - n * c.distance;
    const Vec3 v = boundary_.velocity + cross(boundary_.spin, lane.point - boundary_.pose.position);
    fill(s, law, n, c.distance, v, state);
    lane_[lanes_++] = lane;
  }

  void add_ended(const Sphere& s, int law, const Vec3& normal, const PairState& state, SurfaceEntry& e) {
    // Just out of the law's reach, where it drops its springs and books them; with the true velocity, since the
    // dashpots still worked over half of this step.
    const Vec3 n = boundary_.pose.attitude.rotate(normal);
    const double distance = (s.r + bed_.reach(law)) * (1 + 1e-9);
    const Vec3 v = boundary_.velocity + cross(boundary_.spin, s.x - n * distance - boundary_.pose.position);
    fill(s, law, n, distance, v, state);
    lane_[lanes_++] = {&e, -1, {}};
  }

  /// The surface as a partner record (Batch::other), `distance` from the centre along n; negative: behind the surface.
  void fill(const Sphere& s, int law, const Vec3& n, double distance, const Vec3& v, const PairState& state) {
    const double behind = 2 * s.r;
    points_[lanes_] = {s.x - n * std::max(distance + behind, 1e-9 * s.r), -behind, v, s.m, boundary_.spin, 0, 0, 0};
    states_[lanes_] = state;
    batch_.owner[lanes_] = &s;
    batch_.other[lanes_] = &points_[lanes_];
    batch_.state[lanes_] = &states_[lanes_];
    batch_.law[lanes_] = static_cast<unsigned char>(law);
  }

  void flush() {
    if (lanes_ == 0) return;
    bed_.kernel.evaluate(bed_.laws, batch_, lanes_, elapsed_);
    for (int k = 0; k < lanes_; ++k) {
      const ContactForce& c = batch_.out[k];
      chunk_.lost += losses_of(c.e);
      if (lane_[k].contact < 0) continue;
      SurfaceEntry& e = *lane_[k].entry;
      e.contact[lane_[k].contact].state = states_[k];
      const Vec3 f{c.f[0], c.f[1], c.f[2]};
      e.force += f;
      e.torque += {c.t_i[0], c.t_i[1], c.t_i[2]};
      chunk_.wrench.force -= f;
      chunk_.wrench.moment += Vec3{c.t_j[0], c.t_j[1], c.t_j[2]} - cross(lane_[k].point - boundary_.pose.position, f);
      chunk_.stored += c.e[3];
      ++chunk_.contacts;
      if (c.t_i[3] > 0) ++e.touching;
      if (exceeds(c.f[3], chunk_.max_overlap)) chunk_.max_overlap = c.f[3], chunk_.worst = e.sphere;
    }
    lanes_ = 0;
  }

  Bed::Impl& bed_;
  SurfaceChunk& chunk_;
  Batch& batch_;
  double elapsed_;
  const Boundary& boundary_;
  LaneOfEntry lane_[Batch::lanes];
  Sphere points_[Batch::lanes];
  PairState states_[Batch::lanes];
  int lanes_ = 0;
};

}  // namespace

void Bed::Impl::surface_chunk(SurfaceChunk& chunk, Batch& batch, double elapsed) {
  ChunkRun(*this, chunk, batch, elapsed).run();
}

/// Wrench of each boundary in the order of its chunks, and the work that its motion since the last step did.
void Bed::Impl::sum_surfaces(double elapsed) {
  for (Boundary& b : boundaries) b.wrench_before = b.wrench, b.wrench = {}, b.contacts = 0;
  for (const SurfaceChunk& c : chunks) {
    boundaries[c.boundary].wrench += c.wrench;
    boundaries[c.boundary].contacts += c.contacts;
  }
  for (Boundary& b : boundaries) {
    if (elapsed > 0) {
      const Vec3 path = b.pose.position - b.pose_before.position;
      const Quaternion turn = b.pose.attitude * b.pose_before.attitude.conjugate();
      const Vec3 angle = Vec3{turn.x, turn.y, turn.z} * (turn.w < 0 ? -2.0 : 2.0);  // small: sin is the angle
      b.work -= 0.5 * (dot(b.wrench.force + b.wrench_before.force, path) +
                       dot(b.wrench.moment + b.wrench_before.moment, angle));
    }
    b.pose_before = b.pose;
  }
}

}  // namespace subsoil::dem
