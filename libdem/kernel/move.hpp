#pragma once
#include <algorithm>

#include "libdem/kernel/accumulators.hpp"
#include "libdem/simd/vec.hpp"

/// Kick and drift of the spheres of a particle block, whose sums are complete, and their energies. Sphere by sphere, in
/// rows as records and sums lie in memory: columns, as pairs have them, take twice as long, since nothing here needs
/// one coordinate with another. In mixed precision the new velocity is worked out in double from the stored float and
/// rounded once.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

// As they lie in a record.
using FourInRecord = double __attribute__((vector_size(32), may_alias));
using FourFloatsInRecord = float __attribute__((vector_size(16), may_alias));

/// Two rows of four: (v, m) and the angular velocity, force and torque.
#if defined(__AVX512F__)
using Eight = double __attribute__((vector_size(64)));
[[gnu::always_inline]] inline Eight eight_of(const Four& low, const Four& high) {
  return Eight(_mm512_insertf64x4(_mm512_castpd256_pd512(__m256d(low)), __m256d(high), 1));
}
[[gnu::always_inline]] inline Four low_of(const Eight& e) { return Four(_mm512_castpd512_pd256(__m512d(e))); }
[[gnu::always_inline]] inline Four high_of(const Eight& e) { return Four(_mm512_extractf64x4_pd(__m512d(e), 1)); }
[[gnu::always_inline]] inline Eight eight_at(const float* from) { return Eight(_mm512_cvtps_pd(_mm256_load_ps(from))); }
[[gnu::always_inline]] inline void write(const Eight& e, float* to) {
  _mm256_store_ps(to, _mm512_cvtpd_ps(__m512d(e)));
}
#else
struct Eight {
  Four low, high;
  friend Eight operator+(const Eight& a, const Eight& b) { return {a.low + b.low, a.high + b.high}; }
  friend Eight operator-(const Eight& a, const Eight& b) { return {a.low - b.low, a.high - b.high}; }
  friend Eight operator*(const Eight& a, const Eight& b) { return {a.low * b.low, a.high * b.high}; }
  Eight& operator+=(const Eight& b) { return low += b.low, high += b.high, *this; }
};
[[gnu::always_inline]] inline Eight multiply_add(const Eight& a, const Eight& b, const Eight& c) {
  return {multiply_add(a.low, b.low, c.low), multiply_add(a.high, b.high, c.high)};
}
[[gnu::always_inline]] inline Eight eight_of(const Four& low, const Four& high) { return {low, high}; }
[[gnu::always_inline]] inline Four low_of(const Eight& e) { return e.low; }
[[gnu::always_inline]] inline Four high_of(const Eight& e) { return e.high; }
[[gnu::always_inline]] inline Eight eight_at(const float* from) {
  const auto* row = reinterpret_cast<const FourFloatsInRecord*>(from);
  return {doubles_of(row[0]), doubles_of(row[1])};
}
[[gnu::always_inline]] inline void write(const Eight& e, float* to) {
  auto* row = reinterpret_cast<FourFloatsInRecord*>(to);
  row[0] = floats_of(e.low), row[1] = floats_of(e.high);
}
#endif
[[gnu::always_inline]] inline Eight eight_of(const Accumulator& sum) { return eight_of(sum.f, sum.t); }
[[gnu::always_inline]] inline Eight eight_of(const MixedAccumulator& sum) {
  return eight_at(reinterpret_cast<const float*>(&sum));
}

/// (x, r), and (v, m) with the angular velocity. What the last number beside the angular velocity is does not change.
struct SphereRows {
  Four x;
  Eight motion;
};

[[gnu::always_inline]] inline SphereRows rows_of(const Sphere& s) {
  const auto* row = reinterpret_cast<const FourInRecord*>(&s);
  const Four w = row[2];
  return {row[0], eight_of(row[1], __builtin_shufflevector(w, Four{}, 0, 1, 2, 7))};  // the name is no number
}
[[gnu::always_inline]] inline void write(const SphereRows& q, Sphere& s) {
  auto* row = reinterpret_cast<FourInRecord*>(&s);
  const Four name = row[2];
  row[0] = q.x, row[1] = low_of(q.motion), row[2] = __builtin_shufflevector(high_of(q.motion), name, 0, 1, 2, 7);
}

[[gnu::always_inline]] inline SphereRows rows_of(const MixedSphere& s) {
  return {*reinterpret_cast<const FourInRecord*>(&s), eight_at(s.v)};
}
/// Mass and radius went through double and come back unchanged.
[[gnu::always_inline]] inline void write(const SphereRows& q, MixedSphere& s) {
  *reinterpret_cast<FourInRecord*>(&s) = q.x;
  write(q.motion, s.v);
}

[[gnu::always_inline]] inline Four all(double x) { return Four{x, x, x, x}; }
/// Of the coordinates; what the rows have beside them is left out.
[[gnu::always_inline]] inline double sum_of(const Four& f) { return f[0] + f[1] + f[2]; }

/// Of some spheres: what makes velocities of forces in a time, s, and angular velocities of torques.
struct Gains {
  static constexpr std::uint32_t kRoom = 32;
  double push[kRoom], turn[kRoom];

  template <class Record>
  void fill(const Record* spheres, std::uint32_t count, double time) {
    double mass[kRoom], radius[kRoom];
    for (std::uint32_t k = 0; k < count; ++k) mass[k] = spheres[k].m, radius[k] = spheres[k].r;
    for (std::uint32_t k = count; k < kRoom; ++k) mass[k] = radius[k] = 1;
    for (std::uint32_t k = 0; k < kRoom; ++k) {
      const double inertia = 0.4 * mass[k] * radius[k] * radius[k];
      const double inverse = time / (mass[k] * inertia);  // both from one division
      push[k] = inverse * inertia, turn[k] = inverse * mass[k];
    }
  }
};

/// What makes gains of (v, m) and angular velocity of force and torque: none beside the angular velocity, where the
/// torque has a count.
[[gnu::always_inline]] inline Eight of_one(const Gains& some, std::uint32_t k) {
  return eight_of(all(some.push[k]), all(some.turn[k]) * Four{1, 1, 1, 0});
}

/// use(sphere, gain of a force, sum) for the spheres of a job, and two(a, b) on what it gave for each two of them, the
/// last perhaps twice. A particle block begins at a multiple of its length: the ring does not end within.
template <bool Uniform, class Record, class Job, class Use, class Two>
[[gnu::always_inline]] inline void each_sphere(const Job& job, Record* spheres, double time, const Use& use,
                                               const Two& two) {
  auto* sum = sums_for(job.ring, spheres) + (job.begin & job.ring.mask);
  Gains gains;
  gains.fill(spheres + job.begin, 1, time);
  Eight of = of_one(gains, 0);
  for (std::uint32_t first = job.begin; first < job.end; first += Gains::kRoom) {
    const std::uint32_t count = std::min(job.end - first, Gains::kRoom);
    if constexpr (!Uniform) gains.fill(spheres + first, count, time);
    const auto next = [&](std::uint32_t k) {
      if constexpr (!Uniform) of = of_one(gains, k);
      return use(spheres[first + k], of, *sum++);
    };
    std::uint32_t k = 0;
    for (; k + 1 < count; k += 2) {
      const Four a = next(k), b = next(k + 1);
      two(a, b);
    }
    if (k < count) {
      const Four a = next(k);
      two(a, a);
    }
  }
}

template <bool Uniform, class Record>
void move_spheres(MoveJob& job, Record* spheres) {
  // The last number of a row: mass and radius stay, for forces have a zero there, as have these.
  const Four dt{job.dt, job.dt, job.dt, 0};
  const Eight fall = eight_of(all(job.kick) * Four{job.gravity[0], job.gravity[1], job.gravity[2], 0}, Four{});
  Four fastest{};
  Eight sum_of_squares = eight_of(Four{}, Four{});
  const auto step = [&](Record& s, const Eight& of, auto& sum) {
    SphereRows q = rows_of(s);
    q.motion = multiply_add(eight_of(sum), of, q.motion) + fall;
    q.x = multiply_add(low_of(q.motion), dt, q.x);
    sum = std::remove_reference_t<decltype(sum)>{};
    write(q, s);
    const Eight squares = q.motion * q.motion;
    sum_of_squares += squares;
    return low_of(squares);
  };
  each_sphere<Uniform>(job, spheres, job.kick, step, [&](const Four& a, const Four& b) {
    const Four even = __builtin_shufflevector(a, b, 0, 4, 2, 6), odd = __builtin_shufflevector(a, b, 1, 5, 3, 7),
               third = __builtin_shufflevector(even, even, 2, 3, 0, 1);
    const Four speed2 = even + odd + third;  // of both, in the first two
    fastest = speed2 > fastest ? speed2 : fastest;
  });
  job.speed2 = std::max(fastest[0], fastest[1]);
  job.squares = sum_of(low_of(sum_of_squares)) + sum_of(high_of(sum_of_squares));
}

/// With the mean velocity at t_n, v + a dt_before/2, the energy of translation is (m/2) (v_n . v_n - dt dt_before/4 a .
/// a), for even steps (m/2) v_{n-1/2} . v_{n+1/2}; likewise the angular velocity's.
template <bool Uniform, class Record>
void observe_spheres(ObserveJob& job, Record* spheres) {
  // Half the step before times accelerations is a gain in velocity; so dt dt_before/4 a . a is its square times this.
  const Four ratio = all(job.before > 0 ? job.dt / job.before : 0),
             g{job.gravity[0], job.gravity[1], job.gravity[2], 0};
  const Eight share = eight_of(ratio, ratio), fall = eight_of(all(0.5 * job.before) * g, Four{});
  Eight kinetic = eight_of(Four{}, Four{});
  Four fallen{};
  const auto observe = [&](const Record& record, const Eight& of, const auto& sum) {
    const SphereRows s = rows_of(record);
    const Eight gain = multiply_add(eight_of(sum), of, fall), motion = s.motion + gain;
    const double mass = record.m, inertia = 0.4 * mass * record.r * record.r;
    kinetic += eight_of(all(0.5 * mass), all(0.5 * inertia)) * (motion * motion - share * gain * gain);
    fallen += all(mass) * (g * s.x);
    return Four{};
  };
  each_sphere<Uniform>(job, spheres, 0.5 * job.before, observe, [](const Four&, const Four&) {});
  job.kinetic = sum_of(low_of(kinetic)), job.rotational = sum_of(high_of(kinetic)), job.potential = -sum_of(fallen);
}

inline void move(MoveJob& job) {
  const auto with = [&](auto* spheres) {
    job.uniform ? move_spheres<true>(job, spheres) : move_spheres<false>(job, spheres);
  };
  job.mixed != nullptr ? with(job.mixed) : with(job.spheres);
}
inline void observe(ObserveJob& job) {
  const auto with = [&](auto* spheres) {
    job.uniform ? observe_spheres<true>(job, spheres) : observe_spheres<false>(job, spheres);
  };
  job.mixed != nullptr ? with(job.mixed) : with(job.spheres);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
