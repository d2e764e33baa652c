#pragma once
#include "libdem/kernel/lanes.hpp"

/// Spheres at edges, corners and curved surfaces.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <bool Rolls, class L>
void run_surface(const L& law, SurfaceJob& job) {
  const Pack zero(0.0), one(1.0);
  const BlockMemory memory = BlockMemory::at(job.lines, 1, {.rolls = Rolls, .own = kOwn<L>}, 0);
  for (int first = 0; first < static_cast<int>(kBlock); first += kWidth) {
    const SphereLanes i = load_spheres(job.spheres, job.sphere, first);
    Touch a;
    for (int d = 0; d < 3; ++d) {
      a.n[d] = load(job.normal[d] + first);
      a.v[d] = i.v[d] - load(job.velocity[d] + first);
      a.w_i[d] = i.w[d], a.w_j[d] = load(job.spin[d] + first);
    }
    a.overlap = i.r - load(job.distance + first);
    a.r_i = a.r_j = i.r, a.m_i = a.m_j = i.m;
    History<kOwn<L>> h = load_history<kOwn<L>, Rolls, true>(memory, first, law.friction.remembers_slip());
    const Response c = respond<false, Rolls>(law, meet<false, Rolls>(lever_share(law), a), h, job.elapsed);
    store_history<kOwn<L>, Rolls, true>(h, memory, first, law.friction.remembers_slip());
    store_response(c, select(a.overlap > zero, one, zero), job.f + first, job.t_i + first, job.t_j + first);
    const Pack sums[6] = {c.damped,       c.slid, c.rolled, c.stored, select(a.overlap >= Pack(-job.reach), one, zero),
                          a.overlap / i.r};
    for (int k = 0; k < 6; ++k) store(sums[k], job.sums[k] + first);
  }
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
