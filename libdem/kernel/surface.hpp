#pragma once
#include "libdem/kernel/contact_core.hpp"
#include "libdem/kernel/lanes.hpp"

/// Spheres at edges, corners and curved surfaces.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <bool Rolls, class L>
void run_surface(const L& law, SurfaceJob& job) {
  const VecD zero(0.0), one(1.0);
  const MomentArmShares share = law.friction.shares(false);
  const Remembers<L, Rolls> has(law);
  const MemoryShape shape = has.shape(false, false);
  const BlockMemory memory[1] = {BlockMemory::at(job.lines, 1, shape, 0)};
  for (int first = 0; first < static_cast<int>(kBlock); first += kLanesD) {
    const SphereLanes i = load_spheres(job, job.sphere, first);
    Touch<VecD> a;
    for (int d = 0; d < 3; ++d) {
      a.n[d] = load<VecD>(job.normal[d] + first);
      a.v[d] = i.v[d] - load<VecD>(job.velocity[d] + first);
      a.w_i[d] = i.w[d], a.w_j[d] = load<VecD>(job.angular_velocity[d] + first);
      a.turn[d] = load<VecD>(job.turn[d] + first);
    }
    a.overlap = i.r - load<VecD>(job.distance + first);
    a.r_i = a.r_j = i.r;
    Meeting<VecD> meeting;
    meet<false, false, Rolls, L>(share, VecD(0.5 * job.elapsed), a, meeting);
    const VecD mass = load<VecD>(job.mass + first);
    effective<false, Rolls, L>(i.r, mass, i.r, mass, meeting.effective);
    ContactMemory<VecD> h = load_memory<VecD, true>(has, memory, first);
    const Response<VecD> c = respond<false, Rolls, false, VecD>(law, meeting, h, job.elapsed);
    store_memory<VecD, true>(has, h, memory, first);
    store_response(c, select(a.overlap > zero, one, zero), job.f + first, job.t_i + first, job.t_j + first);
    const ContactSums<VecD> sums{c.damped,       c.slid,   c.rolled,
                                 c.yielded,      c.stored, select(a.overlap >= VecD(-job.cutoff), one, zero),
                                 a.overlap / i.r};
    const auto put = [&](VecD p, double* column) { store(p, column + first); };
    ContactSums<VecD>::each(sums, job.sums, put, put);
  }
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
