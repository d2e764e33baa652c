#include <algorithm>
#include <cmath>
#include <numeric>

#include "libdem/step/bed_impl.hpp"
#include "libdem/step/surface_forces.hpp"
#include "libdem/step/surface_motion.hpp"

/// Single contacts. The sweep adds forces up and keeps none, so those of pairs and of flat faces are evaluated once
/// more before it, by the same kernels on copies of the histories: the step itself is the same bit for bit whether
/// anybody asks or not. Contacts at edges and curved surfaces are looked at one by one anyway (surface_forces.cpp).
/// A second set of kernels that keep forces lost: twice the code of every law for what results ask for now and then.
namespace subsoil::dem {
namespace {

bool is_zero(const Vec3& f) { return f.x == 0 && f.y == 0 && f.z == 0; }

/// Contacts of spheres with flat faces of one boundary, eight at a time as if they lay at edges.
class PlaneRecords {
 public:
  PlaneRecords(const Bed::Impl& bed, const PlaneRun& run, std::vector<ContactRecord>& out)
      : bed_(bed),
        run_(run),
        boundary_(bed.boundaries[run.boundary]),
        shape_(bed.laws.surface_memory(run.law)),
        out_(out) {
    job_.spheres = bed.particles.spheres().data();
    job_.mixed = bed.particles.mixed();
    job_.elapsed = bed.now.dt_before;
    job_.cutoff = bed.laws.surface_cutoff(run.law);
    job_.count = 0;
  }

  void take() {
    for (std::uint32_t k = 0; k < run_.contacts; ++k) take(k / kBlock, k % kBlock);
    flush();
  }

 private:
  void take(std::uint32_t block, std::uint32_t lane) {
    const PlaneBlock& p = bed_.surfaces.plane_blocks[run_.first + block];
    const Sphere s = bed_.particles.now(p.sphere[lane]);
    const Vec3 own{p.normal[0][lane], p.normal[1][lane], p.normal[2][lane]};
    const Vec3 n = boundary_.pose.attitude.rotate(own);
    const double distance = dot(n, s.x - boundary_.pose.position) - p.offset[lane];
    if (s.r - distance < -job_.cutoff) return;
    const std::uint32_t at = job_.count++;
    point_[at] = s.x - distance * n;
    put_contact(job_, at, p.sphere[lane], s, bed_.particles.mass_at_surface(p.sphere[lane]), boundary_, n, distance,
                normal_turn(boundary_, own, nullptr, job_.elapsed));
    write_lane(memory(), shape_, at, read_lane(bed_.surfaces.memory(run_, block, shape_), shape_, lane));
    if (job_.count == kBlock) flush();
  }

  BlockMemory memory() { return BlockMemory::at(job_.lines, 1, shape_, 0); }

  void flush() {
    if (job_.count == 0) return;
    repeat_first(job_);
    for (std::uint32_t k = job_.count; k < kBlock; ++k) write_lane(memory(), shape_, k, PairState{});
    bed_.kernel.surface(bed_.laws[run_.law], job_);
    for (std::uint32_t k = 0; k < job_.count; ++k) {
      const Vec3 f{job_.f[k][0], job_.f[k][1], job_.f[k][2]};
      if (is_zero(f)) continue;
      out_.push_back(record_of(job_, k, bed_.particles.now(job_.sphere[k]), run_.boundary, point_[k], f));
    }
    job_.count = 0;
  }

  const Bed::Impl& bed_;
  const PlaneRun& run_;
  const Boundary& boundary_;
  const MemoryShape& shape_;
  std::vector<ContactRecord>& out_;
  SurfaceJob job_;
  Vec3 point_[kBlock];
};

/// @param dt of the step that ended
ContactRecord between(const Sphere& a, const Sphere& b, const Vec3& force, double stored, double dt) {
  const Vec3 apart = a.x - b.x, v = a.v - b.v;
  const double distance = norm(apart), half = 0.5 * dt;
  const Vec3 n = (1 / distance) * apart, point = a.x - (0.5 * (a.r - b.r + distance)) * n;
  const double v_n = dot(v, n), middle = distance - half * v_n;
  const Vec3 turn = (half / distance) * (v - v_n * n), n_mid = n - turn;
  const Vec3 arms = 0.5 * ((a.r - b.r + middle) * a.w + (b.r - a.r + middle) * b.w);
  return {.i = a.id,
          .j = b.id,
          .at_surface = false,
          .point = point,
          .normal = n,
          .force = force,
          .velocity = turned(v - cross(arms, n_mid), n, turn),
          .stored = stored};
}

}  // namespace

void Bed::Impl::record_run(const PairRun& run, std::size_t particle_block, std::vector<ContactRecord>& out) {
  if (run.candidates && paths.of(particle_block) < run.activation) return;
  PairJob job = pair_job(run, particle_block, {.record = true, .accumulate = true});
  const std::size_t lines = laws.pair_memory(run.law).lines(run.blocks);
  Buffer<Line> memory;
  memory.renew(lines);
  std::copy_n(contacts.lines.data() + run.lines, lines, memory.data());
  std::vector<double> activation;
  if (run.candidates) {
    const double* const from = contacts.activation.data() + run.first;
    activation.assign(from, from + run.blocks);
    job.activation = activation.data();
  }
  std::vector<std::uint32_t> block(run.blocks);
  std::iota(block.begin(), block.end(), 0u);
  std::vector<BlockResult> result(run.blocks);
  std::vector<std::uint8_t> active(run.blocks);
  job.lines = memory.data();
  job.interface_rows = nullptr, job.interface_given = nullptr;
  job.halo = true;  // results of blocks are kept and not added
  job.halo_block = block.data(), job.halo_count = run.blocks;
  job.halo_result = result.data(), job.halo_active = active.data();
  kernel.pairs(laws[run.law], job);
  contacts.each_lane(run, [&](std::uint32_t b, std::uint32_t lane) {
    if (active[b] == 0) return;
    Vec3 f;
    for (int d = 0; d < 3; ++d)
      f[d] = particles.is_mixed() ? static_cast<double>(result[b].push_single[d][lane]) : result[b].push[d][lane];
    if (is_zero(f)) return;
    const PairBlock& p = contacts.blocks[run.first + b];
    out.push_back(
        between(particles.now(p.i[lane]), particles.now(p.j[lane]), f, result[b].sums.stored[lane], now.dt_before));
    out.back().point = options.periodic.wrapped(out.back().point);
  });
}

void Bed::Impl::record_pairs(std::vector<ContactRecord>& out) {
  for (std::size_t b = 0; b < contacts.particle_blocks.size(); ++b)
    for (std::uint32_t r = contacts.particle_blocks[b].runs_begin; r < contacts.particle_blocks[b].runs_end; ++r)
      record_run(contacts.runs[r], b, out);
}

void Bed::Impl::record_plane(const PlaneRun& run, std::vector<ContactRecord>& out) const {
  PlaneRecords(*this, run, out).take();
}

void Bed::Impl::begin_records(std::vector<ContactRecord>* all) {
  at_surfaces.clear();
  const auto asked = [&](std::uint32_t b) { return all != nullptr || boundaries[b].loads.has_value(); };
  for (SurfaceChunk& c : surfaces.chunks) c.records = asked(c.boundary);
  bool any = false;
  for (std::uint32_t b = 0; b < boundaries.size(); ++b) any = any || asked(b);
  if (all != nullptr) {
    all->clear();
    record_pairs(*all);
  }
  if (!any) return;
  for (const PlaneRun& run : surfaces.plane_runs)
    if (asked(run.boundary)) record_plane(run, at_surfaces);
}

void Bed::Impl::end_records(std::vector<ContactRecord>* all) {
  for (const SurfaceChunk& c : surfaces.chunks)
    if (c.records) at_surfaces.insert(at_surfaces.end(), c.recorded.begin(), c.recorded.end());
  for (const ContactRecord& c : at_surfaces) {
    Boundary& b = boundaries[c.j];
    if (b.loads && now.dt_before > 0)
      b.loads->add(b.shape, b.pose.to_local(c.point), load_of(-c.force, c.normal, c.velocity, now.dt_before));
  }
  if (all != nullptr) all->insert(all->end(), at_surfaces.begin(), at_surfaces.end());
}

/// At edges and curved surfaces as the last step had them: nothing of their own is kept beside the contact's state.
std::vector<ContactRecord> Bed::contacts() {
  Impl& bed = *impl_;
  if (!bed.lists_hold()) bed.rebuild();
  bed.particles.renew_images(bed.threads);
  std::vector<ContactRecord> out;
  bed.record_pairs(out);
  for (const PlaneRun& run : bed.surfaces.plane_runs) bed.record_plane(run, out);
  return out;
}

}  // namespace subsoil::dem
