#pragma once
#include "libdem/kernel/lanes.hpp"

/// Kick and drift of the spheres of a tile, whose sums are complete.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

inline void move(MoveJob& job) {
  const Pack kick(job.kick), dt(job.dt), zero(0.0);
  Pack speed2 = zero, kinetic = zero;
  Sphere beyond[kWidth];  // lanes past the end work on copies
  Accumulator nothing[kWidth];
  for (std::uint32_t i = job.begin; i < job.end; i += kWidth) {
    Sphere* sphere[kWidth];
    Accumulator* sum[kWidth];
    const std::uint32_t count = job.end - i < kWidth ? job.end - i : kWidth;
    for (std::uint32_t l = 0; l < kWidth; ++l) {
      if (l >= count) {
        beyond[l] = job.spheres[i];
        beyond[l].v = beyond[l].w = {};
        nothing[l] = Accumulator{};
      }
      sphere[l] = l < count ? job.spheres + i + l : beyond + l;
      sum[l] = l < count ? job.ring + ((i + l) & job.mask) : nothing + l;
    }
    double* row[kWidth];
    Pack x[4], v[4], w[4], f[4], t[4];
    const auto read = [&](int part, Pack* out) {
      for (int l = 0; l < kWidth; ++l) row[l] = &sphere[l]->x.x + 4 * part;
      load4(row, out);
    };
    const auto write = [&](int part, const Pack* in) {
      for (int l = 0; l < kWidth; ++l) row[l] = &sphere[l]->x.x + 4 * part;
      store4(in, row);
    };
    read(0, x), read(1, v), read(2, w);
    for (int l = 0; l < kWidth; ++l) row[l] = reinterpret_cast<double*>(&sum[l]->f);
    load4(row, f);
    for (int l = 0; l < kWidth; ++l) row[l] = reinterpret_cast<double*>(&sum[l]->t);
    load4(row, t);
    for (int l = 0; l < kWidth; ++l) *sum[l] = Accumulator{};
    const Pack inverse_m = Pack(1.0) / v[3], inertia = Pack(0.4) * v[3] * x[3] * x[3], turn = kick / inertia;
    Pack v2 = zero, w2 = zero;
    for (int d = 0; d < 3; ++d) {
      v[d] = v[d] + (f[d] * inverse_m + Pack(job.gravity[d])) * kick;
      w[d] = w[d] + t[d] * turn;
      x[d] = x[d] + v[d] * dt;
      v2 = v2 + v[d] * v[d];
      w2 = w2 + w[d] * w[d];
    }
    write(0, x), write(1, v), write(2, w);
    speed2 = max(speed2, v2);
    const Pack energy = Pack(0.5) * (v[3] * v2 + inertia * w2);
    kinetic += count < kWidth ? select(lanes_below(count, 0), energy, zero) : energy;
  }
  for (int l = 0; l < kWidth; ++l)
    if (speed2.v[l] > job.speed2) job.speed2 = speed2.v[l];
  job.kinetic += sum_of(kinetic);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
