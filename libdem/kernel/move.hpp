#pragma once
#include "libdem/kernel/lanes.hpp"

/// Kick and drift of the spheres of a tile, whose sums are complete. In mixed precision the new velocity is worked out
/// in double from the stored float and rounded once.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

inline void store_spheres(const SphereLanes& s, Sphere* const* sphere) {
  const auto write = [&](int part, const Doubles* in) {
    double* row[kDoubles];
    for (int l = 0; l < kDoubles; ++l) row[l] = reinterpret_cast<double*>(sphere[l]) + 4 * part;
    store4(in, row);
  };
  const Doubles x[4] = {s.x[0], s.x[1], s.x[2], s.r}, v[4] = {s.v[0], s.v[1], s.v[2], s.m};
  write(0, x), write(1, v);
  // The fourth number of the spin is the sphere's name: it stays as it is in memory.
  double w[3][kDoubles];
  for (int d = 0; d < 3; ++d) store(s.w[d], w[d]);
  for (int l = 0; l < kDoubles; ++l) sphere[l]->w = {w[0][l], w[1][l], w[2][l]};
}
inline void store_spheres(const SphereLanes& s, MixedSphere* const* sphere) {
  double* row[kDoubles];
  for (int l = 0; l < kDoubles; ++l) row[l] = &sphere[l]->x.x;
  const Doubles x[4] = {s.x[0], s.x[1], s.x[2], s.r};
  store4(x, row);
  float v[3][kDoubles], w[3][kDoubles];
  for (int d = 0; d < 3; ++d) store_floats(s.v[d], v[d]), store_floats(s.w[d], w[d]);
  for (int l = 0; l < kDoubles; ++l)
    for (int d = 0; d < 3; ++d) sphere[l]->v[d] = v[d][l], sphere[l]->w[d] = w[d][l];
}

template <class Record>
void move_spheres(MoveJob& job, Record* spheres) {
  const Doubles kick(job.kick), dt(job.dt), zero(0.0);
  Doubles speed2 = zero, kinetic = zero;
  Record beyond[kDoubles];  // lanes past the end work on copies
  Accumulator nothing[kDoubles];
  for (std::uint32_t i = job.begin; i < job.end; i += kDoubles) {
    Record* sphere[kDoubles];
    Accumulator* sum[kDoubles];
    const std::uint32_t count = job.end - i < kDoubles ? job.end - i : kDoubles;
    for (std::uint32_t l = 0; l < kDoubles; ++l) {
      if (l >= count) {
        beyond[l] = spheres[i];
        for (int d = 0; d < 3; ++d) beyond[l].v[d] = beyond[l].w[d] = 0;
        nothing[l] = Accumulator{};
      }
      sphere[l] = l < count ? spheres + i + l : beyond + l;
      sum[l] = l < count ? job.ring + ((i + l) & job.mask) : nothing + l;
    }
    SphereLanes s = load_spheres(sphere);
    const double* row[kDoubles];
    Doubles f[4], t[4];
    for (int l = 0; l < kDoubles; ++l) row[l] = reinterpret_cast<double*>(&sum[l]->f);
    load4(row, f);
    for (int l = 0; l < kDoubles; ++l) row[l] = reinterpret_cast<double*>(&sum[l]->t);
    load4(row, t);
    for (int l = 0; l < kDoubles; ++l) *sum[l] = Accumulator{};
    // 1/m and 1/I from one division.
    const Doubles inertia = Doubles(0.4) * s.m * s.r * s.r, inverse = kick / (s.m * inertia);
    const Doubles push = inverse * inertia, turn = inverse * s.m;
    Doubles v2 = zero, w2 = zero;
    for (int d = 0; d < 3; ++d) {
      s.v[d] = s.v[d] + f[d] * push + Doubles(job.gravity[d]) * kick;
      s.w[d] = s.w[d] + t[d] * turn;
      s.x[d] = s.x[d] + s.v[d] * dt;
      v2 = v2 + s.v[d] * s.v[d];
      w2 = w2 + s.w[d] * s.w[d];
    }
    store_spheres(s, sphere);
    speed2 = max(speed2, v2);
    const Doubles energy = Doubles(0.5) * (s.m * v2 + inertia * w2);
    kinetic += count < kDoubles ? select(lanes_below(count, 0), energy, zero) : energy;
  }
  for (int l = 0; l < kDoubles; ++l)
    if (speed2.v[l] > job.speed2) job.speed2 = speed2.v[l];
  job.kinetic += sum_of(kinetic);
}

inline void move(MoveJob& job) {
  if (job.mixed != nullptr)
    move_spheres(job, job.mixed);
  else
    move_spheres(job, job.spheres);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
