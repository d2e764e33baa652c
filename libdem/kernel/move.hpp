#pragma once
#include <algorithm>

#include "libdem/kernel/lanes.hpp"

/// Kick and drift of the spheres of a tile, whose sums are complete. In mixed precision the new velocity is worked out
/// in double from the stored float and rounded once.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// Parts of kDoubles lanes that are read and written together: a record of mixed precision holds floats.
template <class Record>
inline constexpr int kMoved = std::is_same_v<Record, MixedSphere> ? 2 : 1;

inline void load_moved(Sphere* const* sphere, SphereLanes (&out)[1]) { out[0] = load_spheres(sphere); }
inline void load_moved(MixedSphere* const* sphere, SphereLanes (&out)[2]) { load_spheres(sphere, out); }
inline void store_moved(const SphereLanes (&moved)[1], Sphere* const* sphere) {
  const SphereLanes& s = moved[0];
  const auto write = [&](int part, const Doubles* in) {
    double* row[kDoubles];
    for (int l = 0; l < kDoubles; ++l) row[l] = reinterpret_cast<double*>(sphere[l]) + 4 * part;
    store4(in, row);
  };
  const Doubles x[4] = {s.x[0], s.x[1], s.x[2], s.r}, v[4] = {s.v[0], s.v[1], s.v[2], s.m},
                w[4] = {s.w[0], s.w[1], s.w[2], s.name};
  write(0, x), write(1, v), write(2, w);
}
inline void store_moved(const SphereLanes (&s)[2], MixedSphere* const* sphere) {
  for (int half = 0; half < 2; ++half) {
    double* place[kDoubles];
    for (int l = 0; l < kDoubles; ++l) place[l] = &sphere[half * kDoubles + l]->x.x;
    const Doubles x[4] = {s[half].x[0], s[half].x[1], s[half].x[2], s[half].r};
    store4(x, place);
  }
  // Mass and radius go through double and back unchanged.
  Singles v[4], w[4];
  for (int d = 0; d < 3; ++d) v[d] = join(s[0].v[d], s[1].v[d]), w[d] = join(s[0].w[d], s[1].w[d]);
  v[3] = join(s[0].m, s[1].m), w[3] = join(s[0].r, s[1].r);
  float* motion[kSingles];
  for (int l = 0; l < kSingles; ++l) motion[l] = sphere[l]->v;
  store_rows(v, w, motion);
}

/// Largest v.v and kinetic energy of what moved.
struct MovedSums {
  Doubles speed2 = Doubles(0.0), kinetic = Doubles(0.0);
};

/// One step of kDoubles spheres with their sums, which are zero afterwards. Lanes from `used` on are not summed up.
[[gnu::always_inline]] inline void kick_and_drift(const MoveJob& job, Accumulator* const* sum, std::uint32_t used,
                                                  SphereLanes& s, MovedSums& sums) {
  const Doubles kick(job.kick), dt(job.dt), zero(0.0);
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
  const Doubles energy = Doubles(0.5) * (s.m * v2 + inertia * w2);
  if (used >= kDoubles) {
    sums.speed2 = max(sums.speed2, v2), sums.kinetic += energy;
  } else {
    const DoublesMask in = lanes_below(used, 0);
    sums.speed2 = max(sums.speed2, select(in, v2, zero)), sums.kinetic += select(in, energy, zero);
  }
}

template <class Record>
void move_spheres(MoveJob& job, Record* spheres) {
  constexpr std::uint32_t width = kMoved<Record> * kDoubles;
  MovedSums sums;
  // sphere_at(l), sum_at(l): where lane l lies.
  const auto step = [&](std::uint32_t count, const auto& sphere_at, const auto& sum_at) __attribute__((always_inline)) {
    Record* sphere[width];
    Accumulator* sum[width];
    for (std::uint32_t l = 0; l < width; ++l) sphere[l] = sphere_at(l), sum[l] = sum_at(l);
    SphereLanes s[kMoved<Record>];
    load_moved(sphere, s);
#pragma GCC unroll 2
    for (std::uint32_t part = 0; part < kMoved<Record>; ++part) {
      const std::uint32_t before = part * kDoubles;
      kick_and_drift(job, sum + before, count > before ? count - before : 0, s[part], sums);
    }
    store_moved(s, sphere);
  };
  std::uint32_t i = job.begin;
  // A tile begins at a multiple of its length, and so at one of the width: the ring does not end within a pack.
  for (; i + width <= job.end; i += width) {
    Record* const first = spheres + i;
    Accumulator* const first_sum = job.ring + (i & job.mask);
    step(
        width, [&](std::uint32_t l) { return first + l; }, [&](std::uint32_t l) { return first_sum + l; });
  }
  if (i < job.end) {
    Record beyond[width];  // lanes past the end work on copies
    Accumulator nothing[width];
    const std::uint32_t count = job.end - i;
    for (std::uint32_t l = count; l < width; ++l) beyond[l] = spheres[i], nothing[l] = Accumulator{};
    step(
        count, [&](std::uint32_t l) { return l < count ? spheres + i + l : beyond + l; },
        [&](std::uint32_t l) { return l < count ? job.ring + ((i + l) & job.mask) : nothing + l; });
  }
  for (int l = 0; l < kDoubles; ++l)
    if (sums.speed2.v[l] > job.speed2) job.speed2 = sums.speed2.v[l];
  job.kinetic += sum_of(sums.kinetic);
}

inline void move(MoveJob& job) {
  if (job.mixed != nullptr)
    move_spheres(job, job.mixed);
  else
    move_spheres(job, job.spheres);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
