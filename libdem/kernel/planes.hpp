#pragma once
#include "libdem/kernel/accumulators.hpp"
#include "libdem/kernel/contact_core.hpp"
#include "libdem/kernel/lanes.hpp"

/// Spheres on flat faces of boundaries; in double also in mixed precision, but for what the records hold in float.
/// Without `Accumulate` the law's friction is the usual one (Friction::usual).
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <bool Rolls, bool Accumulate, class L>
void run_planes(const L& by_reference, PlaneJob& job) {
  L law = by_reference;  // nothing can point to it: its constants stay in registers
  if constexpr (!Accumulate) law.friction = law.friction.as_usual();
  const MomentArmShares share = by_reference.friction.shares(false);
  const Remembers<L, Rolls> has(law);
  const MemoryShape shape = has.shape(false, false);
  const VecD zero(0.0), one(1.0);
  ContactSums<VecD> sums{zero, zero, zero, zero, zero, zero, zero};
  VecD force[3] = {zero, zero, zero}, moment[3] = {zero, zero, zero};
  const VecD half_dt(0.5 * job.elapsed);
  for (std::uint32_t b = 0; b < job.count; ++b) {
    const PlaneBlock& block = job.blocks[b];
    const std::uint32_t count = b + 1 < job.count ? kBlock : job.contacts - b * kBlock;
    Four f[kBlock], t[kBlock], unused[kBlock];
    double masses[kBlock];
    if (job.masses != nullptr)
      for (std::uint32_t l = 0; l < kBlock; ++l) masses[l] = job.masses[block.sphere[l]];
    for (int first = 0; first < static_cast<int>(kBlock); first += kLanesD) {
      SphereLanes i = load_spheres(job, block.sphere, first);
      if (job.masses != nullptr) i.m = load<VecD>(masses + first);
      VecD own[3], at[3];
      for (int d = 0; d < 3; ++d) own[d] = load<VecD>(block.normal[d] + first), at[d] = i.x[d] - VecD(job.position[d]);
      Touch<VecD> a;
      for (int d = 0; d < 3; ++d)
        a.n[d] =
            VecD(job.rotation[d][0]) * own[0] + VecD(job.rotation[d][1]) * own[1] + VecD(job.rotation[d][2]) * own[2];
      const VecD distance = dot3(a.n, at) - load<VecD>(block.offset + first);
      a.overlap = i.r - distance;
      VecD point[3], relative[3], w[3], swept[3], v[3], arm[3];
      for (int d = 0; d < 3; ++d) {
        point[d] = at[d] - distance * a.n[d], relative[d] = i.v[d] - VecD(job.velocity[d]);
        a.w_i[d] = i.w[d], a.w_j[d] = w[d] = VecD(job.angular_velocity[d]);
      }
      // As surface_motion.hpp has it for one sphere.
      cross3(w, a.n, a.turn), cross3(w, point, swept);
      for (int d = 0; d < 3; ++d) a.turn[d] = half_dt * a.turn[d], v[d] = relative[d] - swept[d];
      const VecD v_n = dot3(v, a.n);
      for (int d = 0; d < 3; ++d) arm[d] = point[d] - half_dt * (relative[d] - v_n * a.n[d]) + distance * a.turn[d];
      cross3(w, arm, swept);
      for (int d = 0; d < 3; ++d) a.v[d] = relative[d] - swept[d];
      a.r_i = a.r_j = i.r;
      const BlockMemory memory[1] = {BlockMemory::at(job.lines, job.count, shape, b)};
      Meeting<VecD> meeting;
      meet<false, false, Rolls, L>(share, half_dt, a, meeting);
      effective<false, Rolls, L>(i.r, i.m, i.r, i.m, meeting.effective);
      ContactMemory<VecD> h = load_memory<VecD, Accumulate>(has, memory, first);
      Response<VecD> c = respond<false, Rolls, !Accumulate, VecD>(law, meeting, h, job.elapsed);
      store_memory<VecD, Accumulate>(has, h, memory, first);
      store_response(c, select(a.overlap > zero, one, zero), f + first, t + first, unused + first);
      const VecDMask used = lanes_below(count, first);
      sums.within_cutoff += select(used, select(a.overlap >= VecD(-job.cutoff), one, zero), zero);
      if constexpr (Accumulate) {
        sums.damped += select(used, c.damped, zero), sums.slid += select(used, c.slid, zero);
        sums.rolled += select(used, c.rolled, zero), sums.stored += select(used, c.stored, zero);
        sums.overlap = max(sums.overlap, select(used, a.overlap / i.r, zero));
      }
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        force[d] += select(used, -c.f[d], zero);
        moment[d] += select(used, c.t_j[d] - (point[e] * c.f[g] - point[g] * c.f[e]), zero);
      }
    }
    for (std::uint32_t l = 0; l < count; ++l) {
      const std::uint32_t at = block.sphere[l] & job.ring.mask;
      job.mixed != nullptr ? add(job.ring.singles[at], f[l], t[l]) : add(job.ring.doubles[at], f[l], t[l]);
    }
  }
  job.sums.within_cutoff += sum_of(sums.within_cutoff);
  for (int d = 0; d < 3; ++d) job.force[d] += sum_of(force[d]), job.moment[d] += sum_of(moment[d]);
  if constexpr (!Accumulate) return;
  job.sums.damped += sum_of(sums.damped), job.sums.slid += sum_of(sums.slid);
  job.sums.rolled += sum_of(sums.rolled), job.sums.stored += sum_of(sums.stored);
  for (int l = 0; l < kLanesD; ++l) job.sums.overlap = std::max(job.sums.overlap, sums.overlap.v[l]);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
