#pragma once
#include "libdem/kernel/lanes.hpp"

/// Spheres on flat faces of boundaries.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <bool Rolls, class L>
void run_planes(const L& by_reference, PlaneJob& job) {
  const L law = by_reference;  // nothing can point to it: its constants stay in registers
  const double share = lever_share(law);
  const Pack zero(0.0), one(1.0);
  Pack sums[6] = {zero, zero, zero, zero, zero, zero}, force[3] = {zero, zero, zero}, moment[3] = {zero, zero, zero};
  for (std::uint32_t b = 0; b < job.count; ++b) {
    const PlaneBlock& block = job.blocks[b];
    const std::uint32_t count = b + 1 < job.count ? kBlock : job.contacts - b * kBlock;
    Four f[kBlock], t[kBlock], unused[kBlock];
    for (int first = 0; first < static_cast<int>(kBlock); first += kWidth) {
      const SphereLanes i = load_spheres(job.spheres, block.sphere, first);
      Pack own[3], at[3];
      for (int d = 0; d < 3; ++d) own[d] = load(block.normal[d] + first), at[d] = i.x[d] - Pack(job.position[d]);
      Touch a;
      for (int d = 0; d < 3; ++d)
        a.n[d] = Pack(job.turn[d][0]) * own[0] + Pack(job.turn[d][1]) * own[1] + Pack(job.turn[d][2]) * own[2];
      const Pack distance = dot3(a.n, at) - load(block.offset + first);
      a.overlap = i.r - distance;
      Pack point[3];
      for (int d = 0; d < 3; ++d) point[d] = at[d] - distance * a.n[d];
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        a.v[d] = i.v[d] - (Pack(job.velocity[d]) + Pack(job.spin[e]) * point[g] - Pack(job.spin[g]) * point[e]);
        a.w_i[d] = i.w[d], a.w_j[d] = Pack(job.spin[d]);
      }
      a.r_i = a.r_j = i.r, a.m_i = a.m_j = i.m;
      const BlockMemory memory = BlockMemory::at(job.lines, job.count, {.rolls = Rolls, .own = kOwn<L>}, b);
      History<kOwn<L>> h = load_history<kOwn<L>, Rolls, true>(memory, first, law.friction.remembers_slip());
      Response c = respond<false, Rolls>(law, meet<false, Rolls>(share, a), h, job.elapsed);
      store_history<kOwn<L>, Rolls, true>(h, memory, first, law.friction.remembers_slip());
      store_response(c, select(a.overlap > zero, one, zero), f + first, t + first, unused + first);
      const PackMask used = lanes_below(count, first);
      const Pack add[6] = {c.damped,       c.slid, c.rolled, c.stored, select(a.overlap >= Pack(-job.reach), one, zero),
                           a.overlap / i.r};
      for (int k = 0; k < 5; ++k) sums[k] += select(used, add[k], zero);
      sums[5] = max(sums[5], select(used, add[5], zero));
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        force[d] += select(used, -c.f[d], zero);
        moment[d] += select(used, c.t_j[d] - (point[e] * c.f[g] - point[g] * c.f[e]), zero);
      }
    }
    for (std::uint32_t l = 0; l < count; ++l) {
      Accumulator& a = job.ring[block.sphere[l] & job.mask];
      a.f += f[l];
      a.t += t[l];
    }
  }
  for (int k = 0; k < 3; ++k) job.sums.lost[k] += sum_of(sums[k]);
  job.sums.stored += sum_of(sums[3]);
  job.sums.in_reach += sum_of(sums[4]);
  for (int l = 0; l < kWidth; ++l)
    if (sums[5].v[l] > job.sums.overlap) job.sums.overlap = sums[5].v[l];
  for (int d = 0; d < 3; ++d) job.force[d] += sum_of(force[d]), job.moment[d] += sum_of(moment[d]);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
