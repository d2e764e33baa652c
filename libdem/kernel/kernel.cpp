// Compiled once per instruction set with SUBSOIL_ISA naming it (libdem/CMakeLists.txt).
#include "libdem/kernel/batch.hpp"
#include "libdem/kernel/pack.hpp"

namespace subsoil::dem {
inline namespace SUBSOIL_ISA {
namespace {

template <class T>
T dot3(const T (&a)[3], const T (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Turns a spring into the plane across n. Its length shrinks by half the square of the angle that n turned in the
/// step, 1e-7 or less: a second square root and division to keep it exactly cost 5 % of the sweep and change nothing.
template <class T>
void turn(T (&s)[3], const T (&n)[3]) {
  const T along = dot3(s, n);
  for (int d = 0; d < 3; ++d) s[d] = s[d] - along * n[d];
}

struct Records {
  Pack x[3], r, v[3], m, w[3];
};

/// Whole sphere records of one pack of lanes: (x, r), (v, m), (w, id).
Records load_spheres(const Sphere* const* from) {
  const double* row[kWidth];
  Pack group[4];
  Records s;
  for (int part = 0; part < 3; ++part) {
    for (int l = 0; l < kWidth; ++l) row[l] = &from[l]->x.x + 4 * part;
    load4(row, group);
    Pack(&vector)[3] = part == 0 ? s.x : part == 1 ? s.v : s.w;
    for (int d = 0; d < 3; ++d) vector[d] = group[d];
    if (part == 0) s.r = group[3];
    if (part == 1) s.m = group[3];
  }
  return s;
}

struct History {
  Pack xi[3], rho[3], dash_n, dash_t[3], dash_r[3], slipping;
};

double* numbers_of(PairState* s) { return s->xi; }

History load_history(PairState* const* from) {
  const double* row[kWidth];
  Pack a[4], b[4], c[4];
  for (int l = 0; l < kWidth; ++l) row[l] = numbers_of(from[l]);
  load4(row, a);
  for (int l = 0; l < kWidth; ++l) row[l] = numbers_of(from[l]) + 4;
  load4(row, b);
  for (int l = 0; l < kWidth; ++l) row[l] = numbers_of(from[l]) + 6;  // the last four; two of them again
  load4(row, c);
  History h;
  h.xi[0] = a[0], h.xi[1] = a[1], h.xi[2] = a[2];
  h.rho[0] = a[3], h.rho[1] = b[0], h.rho[2] = b[1];
  split(c[0], h.dash_n, h.dash_t[0]);
  split(c[1], h.dash_t[1], h.dash_t[2]);
  split(c[2], h.dash_r[0], h.dash_r[1]);
  split(c[3], h.dash_r[2], h.slipping);
  return h;
}

void store_history(const History& h, PairState* const* to) {
  double* row[kWidth];
  const Pack floats[4] = {join(h.dash_n, h.dash_t[0]), join(h.dash_t[1], h.dash_t[2]), join(h.dash_r[0], h.dash_r[1]),
                          join(h.dash_r[2], h.slipping)};
  const Pack a[4] = {h.xi[0], h.xi[1], h.xi[2], h.rho[0]};
  const Pack b[4] = {h.rho[1], h.rho[2], floats[0], floats[1]};
  for (int l = 0; l < kWidth; ++l) row[l] = numbers_of(to[l]);
  store4(a, row);
  for (int l = 0; l < kWidth; ++l) row[l] = numbers_of(to[l]) + 4;
  store4(b, row);
  for (int l = 0; l < kWidth; ++l) row[l] = numbers_of(to[l]) + 6;
  store4(floats, row);
}

/// One pack of lanes of one law. Lanes of other laws, and those past the count, point to scratch.
struct Lanes {
  const Sphere* owner[kWidth];
  const Sphere* other[kWidth];
  PairState* state[kWidth];
  ContactForce* out[kWidth];
};

/// One law on kWidth contacts. Geometry, slip and rolling velocities are common to all laws.
template <class L>
[[gnu::flatten]] void evaluate_lanes(const L& law, double share, const Lanes& lanes, double elapsed) {
  const Pack zero(0.0), one(1.0), half(0.5);
  const Records i = load_spheres(lanes.owner), j = load_spheres(lanes.other);
  Pack n[3], v[3];
  for (int d = 0; d < 3; ++d) n[d] = i.x[d] - j.x[d], v[d] = i.v[d] - j.v[d];
  const Pack distance = sqrt(dot3(n, n)), inv_distance = one / distance;
  for (int d = 0; d < 3; ++d) n[d] = n[d] * inv_distance;
  // A surface comes with its radius negative: see Batch::other.
  const Pack overlap = i.r + max(j.r, -j.r) - distance;
  // Contact point in the middle of the overlap between spheres (share 1/2), on the surface at a boundary (share 1).
  const auto pair = j.r > zero;
  const Pack sink = Pack(share) * overlap;
  const Pack l_i = i.r - select(pair, half * sink, sink), l_j = select(pair, j.r - half * sink, zero);

  Pack arm[3], v_c[3], w[3];
  for (int d = 0; d < 3; ++d) arm[d] = l_i * i.w[d] + l_j * j.w[d];
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    v_c[d] = v[d] - (arm[e] * n[f] - arm[f] * n[e]);
  }
  const Pack v_n = dot3(v_c, n);
  for (int d = 0; d < 3; ++d) w[d] = i.w[d] - j.w[d];
  const Pack twist = dot3(w, n);
  for (int d = 0; d < 3; ++d) {
    v_c[d] = v_c[d] - v_n * n[d];
    w[d] = w[d] - twist * n[d];
  }

  // Series sums: at a surface the sphere's own value stays.
  const auto series = [&](Pack own, Pack other) { return select(pair, own * other / (own + other), own); };
  const Pack m_eff = series(i.m, j.m), r_eff = series(i.r, j.r);
  const Pack i_roll = series(Pack(1.4) * i.m * i.r * i.r, Pack(1.4) * j.m * j.r * j.r);
  const Pack dt(elapsed);
  const NormalForce<Pack> normal = law.normal(Approach<Pack>{overlap, -v_n, m_eff, r_eff, dt});

  History h = load_history(lanes.state);
  turn(h.xi, n);
  turn(h.rho, n);
  const Slip<Pack> slide = law.friction.slide(normal, h.xi, v_c, h.dash_t, h.slipping, dt);
  const Slip<Pack> roll = law.friction.roll(normal, h.rho, w, h.dash_r, r_eff, i_roll, dt);

  Pack f[4], t_i[4], t_j[4];
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    f[d] = normal.force * n[d] - slide.force[d];
    const Pack q = n[e] * slide.force[g] - n[g] * slide.force[e];
    t_i[d] = l_i * q - roll.force[d];
    t_j[d] = l_j * q + roll.force[d];
  }
  f[3] = overlap / select(pair, min(i.r, j.r), i.r);
  t_i[3] = t_j[3] = select(overlap > zero, one, zero);
  const double k_roll =
      law.friction.rolling == Rolling::elastic_plastic ? 2.25 * law.friction.mu_r * law.friction.mu_r : 0.0;
  const Pack k_r = Pack(k_roll) * normal.k_n * r_eff * r_eff;
  const Pack e[4] = {half * (h.dash_n + normal.damping) * (-v_n) * dt + slide.damped, slide.slid,
                     roll.slid + roll.damped,
                     normal.stored + half * normal.k_t * dot3(slide.x, slide.x) + half * k_r * dot3(roll.x, roll.x)};
  double* row[kWidth];
  const Pack* const groups[4] = {f, t_i, t_j, e};
  for (int part = 0; part < 4; ++part) {
    for (int l = 0; l < kWidth; ++l) row[l] = reinterpret_cast<double*>(lanes.out[l]) + 4 * part;
    store4(groups[part], row);
  }
  for (int d = 0; d < 3; ++d) {
    h.xi[d] = slide.x[d];
    h.rho[d] = roll.x[d];
    h.dash_t[d] = slide.dashpot[d];
    h.dash_r[d] = roll.dashpot[d];
  }
  h.dash_n = normal.damping;
  h.slipping = slide.slipping;
  store_history(h, lanes.state);
}

/// Two spheres that touch nothing, and places for results that nobody reads; one set per thread.
struct Scratch {
  Sphere a{{0, 0, 0}, 1, {}, 1, {}, 0, 0, 0}, b{{3, 0, 0}, 1, {}, 1, {}, 0, 0, 0};
  PairState state;
  ContactForce out;
};

void evaluate(const LawTable& table, Batch& b, int count, double elapsed) {
  thread_local Scratch scratch;
  bool used[256] = {};
  int laws = 0;
  for (int k = 0; k < count; ++k) {
    laws += used[b.law[k]] ? 0 : 1;
    used[b.law[k]] = true;
  }
  for (std::size_t which = 0; which < table.laws.size(); ++which) {
    if (!used[which]) continue;
    const bool alone = laws == 1;
    std::visit(
        [&](const auto& law) {
          const double share = law.friction.lever == Lever::mid_overlap ? 1.0 : 0.0;
          for (int k = 0; k < count; k += kWidth) {
            Lanes lanes;
            bool any = false;
            for (int l = 0; l < kWidth; ++l) {
              const bool mine = k + l < count && (alone || b.law[k + l] == which);
              any |= mine;
              lanes.owner[l] = mine ? b.owner[k + l] : &scratch.a;
              lanes.other[l] = mine ? b.other[k + l] : &scratch.b;
              lanes.state[l] = mine ? b.state[k + l] : &scratch.state;
              lanes.out[l] = mine ? &b.out[k + l] : &scratch.out;
            }
            if (any) evaluate_lanes(law, share, lanes, elapsed);
          }
        },
        table.laws[which]);
    if (alone) break;
  }
}

}  // namespace

Kernel kernel() {
#define SUBSOIL_NAME_(x) #x
#define SUBSOIL_NAME(x) SUBSOIL_NAME_(x)
  return {SUBSOIL_NAME(SUBSOIL_ISA), evaluate};
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
