#pragma once
#include <algorithm>

#include "libdem/kernel/rows.hpp"

/// Kick and drift of the spheres of a tile, whose sums are complete, and their energies. Sphere by sphere, in rows of
/// four as records and sums lie in memory: columns, as pairs have them, take twice as long, since nothing here needs
/// one coordinate with another. In mixed precision the new velocity is worked out in double from the stored float and
/// rounded once.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

// As they lie in a record.
using FourInRecord = double __attribute__((vector_size(32), may_alias));
using FourFloatsInRecord = float __attribute__((vector_size(16), may_alias));

/// (x, r), (v, m) and the spin, of whose last number nothing is kept.
struct SphereRows {
  Four x, v, w;
};

[[gnu::always_inline]] inline SphereRows rows_of(const Sphere& s) {
  const auto* row = reinterpret_cast<const FourInRecord*>(&s);
  const Four w = row[2];
  return {row[0], row[1], __builtin_shufflevector(w, Four{}, 0, 1, 2, 7)};  // the name is no number
}
[[gnu::always_inline]] inline void write(const SphereRows& q, Sphere& s) {
  auto* row = reinterpret_cast<FourInRecord*>(&s);
  const Four name = row[2];
  row[0] = q.x, row[1] = q.v, row[2] = __builtin_shufflevector(q.w, name, 0, 1, 2, 7);
}

[[gnu::always_inline]] inline SphereRows rows_of(const MixedSphere& s) {
  return {*reinterpret_cast<const FourInRecord*>(&s), doubles_of(*reinterpret_cast<const FourFloatsInRecord*>(s.v)),
          doubles_of(*reinterpret_cast<const FourFloatsInRecord*>(s.w))};
}
/// The mass went through double and comes back unchanged.
[[gnu::always_inline]] inline void write(const SphereRows& q, MixedSphere& s) {
  *reinterpret_cast<FourInRecord*>(&s) = q.x;
  *reinterpret_cast<FourFloatsInRecord*>(s.v) = floats_of(q.v);
  const FourFloats w = floats_of(q.w), before = *reinterpret_cast<const FourFloatsInRecord*>(s.w);
  *reinterpret_cast<FourFloatsInRecord*>(s.w) = __builtin_shufflevector(w, before, 0, 1, 2, 7);
}

[[gnu::always_inline]] inline Four all(double x) { return Four{x, x, x, x}; }
/// Of the coordinates; what the rows have beside them is left out.
[[gnu::always_inline]] inline double sum_of(const Four& f) { return f[0] + f[1] + f[2]; }

/// Of some spheres: what makes velocities of forces in a time, s, and spins of torques; and for energies.
struct Inertias {
  static constexpr std::uint32_t kRoom = 32;
  double push[kRoom], turn[kRoom], half_mass[kRoom], half_inertia[kRoom];

  template <class Record>
  void fill(const Record* spheres, std::uint32_t count, double time) {
    double mass[kRoom], radius[kRoom];
    for (std::uint32_t k = 0; k < count; ++k) mass[k] = spheres[k].m, radius[k] = spheres[k].r;
    for (std::uint32_t k = count; k < kRoom; ++k) mass[k] = radius[k] = 1;
    for (std::uint32_t k = 0; k < kRoom; ++k) {
      const double inertia = 0.4 * mass[k] * radius[k] * radius[k];
      const double inverse = time / (mass[k] * inertia);  // both from one division
      push[k] = inverse * inertia, turn[k] = inverse * mass[k];
      half_mass[k] = 0.5 * mass[k], half_inertia[k] = 0.5 * inertia;
    }
  }
};

/// Each number four times over.
struct InertiasOfOne {
  Four push, turn, half_mass, half_inertia;
};
[[gnu::always_inline]] inline InertiasOfOne of_one(const Inertias& some, std::uint32_t k) {
  return {all(some.push[k]), all(some.turn[k]), all(some.half_mass[k]), all(some.half_inertia[k])};
}

/// use(sphere, inertias, sum) for the spheres of a job. A tile begins at a multiple of its length: the ring does not
/// end within.
template <bool Alike, class Record, class Job, class Use>
[[gnu::always_inline]] inline void each_sphere(const Job& job, Record* spheres, double time, const Use& use) {
  auto* sum = sums_for(job.ring, spheres) + (job.begin & job.ring.mask);
  Inertias inertias;
  inertias.fill(spheres + job.begin, 1, time);
  InertiasOfOne of = of_one(inertias, 0);
  for (std::uint32_t first = job.begin; first < job.end; first += Inertias::kRoom) {
    const std::uint32_t count = std::min(job.end - first, Inertias::kRoom);
    if constexpr (!Alike) inertias.fill(spheres + first, count, time);
    for (std::uint32_t k = 0; k < count; ++k, ++sum) {
      if constexpr (!Alike) of = of_one(inertias, k);
      use(spheres[first + k], of, *sum);
    }
  }
}

template <bool Alike, class Record>
void move_spheres(MoveJob& job, Record* spheres) {
  // The last number of a row: mass and radius stay, for forces have a zero there, as have these.
  const Four dt{job.dt, job.dt, job.dt, 0},
      fall = all(job.kick) * Four{job.gravity[0], job.gravity[1], job.gravity[2], 0};
  Four fastest{}, kinetic{}, spin{};
  each_sphere<Alike>(job, spheres, job.kick, [&](Record& s, const InertiasOfOne& of, auto& sum) {
    SphereRows q = rows_of(s);
    q.v = q.v + doubles_of(sum.f) * of.push + fall;
    q.w = q.w + doubles_of(sum.t) * of.turn;
    q.x = q.x + q.v * dt;
    sum = std::remove_reference_t<decltype(sum)>{};
    write(q, s);
    const Four v2 = q.v * q.v;
    kinetic += of.half_mass * v2, spin += of.half_inertia * (q.w * q.w);
    const Four speed2 = v2 + __builtin_shufflevector(v2, v2, 1, 2, 0, 3) + __builtin_shufflevector(v2, v2, 2, 0, 1, 3);
    fastest = speed2 > fastest ? speed2 : fastest;
  });
  job.speed2 = fastest[0];
  job.kinetic = sum_of(kinetic) + sum_of(spin);
}

/// With the mean velocity at t_n, v + a dt_before/2, the energy of translation is (m/2) (v_n . v_n - dt dt_before/4 a .
/// a), for even steps (m/2) v_{n-1/2} . v_{n+1/2}; likewise the spin's.
template <bool Alike, class Record>
void observe_spheres(ObserveJob& job, Record* spheres) {
  // Half the step before times accelerations is a gain in velocity; so dt dt_before/4 a . a is its square times this.
  const Four share = all(job.before > 0 ? job.dt / job.before : 0),
             fall = all(0.5 * job.before) * Four{job.gravity[0], job.gravity[1], job.gravity[2], 0},
             g{job.gravity[0], job.gravity[1], job.gravity[2], 0};
  Four kinetic{}, spin{}, fallen{};
  each_sphere<Alike>(job, spheres, 0.5 * job.before,
                     [&](const Record& record, const InertiasOfOne& of, const auto& sum) {
                       const SphereRows s = rows_of(record);
                       const Four gain = doubles_of(sum.f) * of.push + fall, turn = doubles_of(sum.t) * of.turn;
                       const Four v = s.v + gain, w = s.w + turn;
                       kinetic += of.half_mass * (v * v - share * gain * gain);
                       spin += of.half_inertia * (w * w - share * turn * turn);
                       fallen += (of.half_mass + of.half_mass) * (g * s.x);
                     });
  job.kinetic = sum_of(kinetic), job.spin = sum_of(spin), job.potential = -sum_of(fallen);
}

inline void move(MoveJob& job) {
  const auto with = [&](auto* spheres) {
    job.alike ? move_spheres<true>(job, spheres) : move_spheres<false>(job, spheres);
  };
  job.mixed != nullptr ? with(job.mixed) : with(job.spheres);
}
inline void observe(ObserveJob& job) {
  const auto with = [&](auto* spheres) {
    job.alike ? observe_spheres<true>(job, spheres) : observe_spheres<false>(job, spheres);
  };
  job.mixed != nullptr ? with(job.mixed) : with(job.spheres);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
