// Compiled once per instruction set with SUBSOIL_ISA naming it (libdem/CMakeLists.txt).
#include "libdem/kernel/batch.hpp"
#include "libdem/kernel/pack.hpp"

namespace subsoil::dem {
inline namespace SUBSOIL_ISA {
namespace {

template <class T>
void load3(const Batch::Lane (&from)[3], int k, T (&to)[3]) {
  for (int d = 0; d < 3; ++d) to[d] = T::load(from[d] + k);
}

template <class T>
T dot3(const T (&a)[3], const T (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Turns a spring into the plane across n. Its length shrinks by half the square of the angle that n turned in the step,
/// 1e-7 or less: a second square root and division to keep it exactly cost 5 % of the sweep and change nothing.
template <class T>
void turn(T (&s)[3], const T (&n)[3]) {
  const T along = dot3(s, n);
  for (int d = 0; d < 3; ++d) s[d] = s[d] - along * n[d];
}

void load3(const Batch::FloatLane (&from)[3], int k, Pack (&to)[3]) {
  for (int d = 0; d < 3; ++d) to[d] = Pack::load(from[d] + k);
}

/// Writes the lanes whose law is the one just evaluated; the others keep what they have.
struct Writer {
  PackMask mine;
  int k;
  void operator()(Batch::Lane& lane, Pack value) const { select(mine, value, Pack::load(lane + k)).store(lane + k); }
  void operator()(Batch::FloatLane& lane, Pack value) const {
    select(mine, value, Pack::load(lane + k)).store(lane + k);
  }
  template <class AnyLane>
  void operator()(AnyLane (&lanes)[3], const Pack (&value)[3]) const {
    for (int d = 0; d < 3; ++d) (*this)(lanes[d], value[d]);
  }
};

/// One law on the kWidth contacts that begin at lane k. Geometry, slip and rolling velocities are common to all laws.
template <class L>
[[gnu::flatten]] void evaluate_lanes(const L& law, double share, Batch& b, int k, int law_index, double elapsed) {
  const Pack zero(0.0), one(1.0), half(0.5);
  Pack n[3], v[3], w_i[3], w_j[3];
  load3(b.r, k, n);
  load3(b.v, k, v);
  load3(b.w_i, k, w_i);
  load3(b.w_j, k, w_j);
  const Pack distance = sqrt(dot3(n, n)), inv_distance = one / distance;
  for (int d = 0; d < 3; ++d) n[d] = n[d] * inv_distance;
  const Pack r_i = Pack::load(b.r_i + k), r_j = Pack::load(b.r_j + k);
  const Pack overlap = r_i + r_j - distance;
  // Contact point in the middle of the overlap between spheres (share 1/2), on the surface at a boundary (share 1).
  const auto pair = r_j > zero;
  const Pack sink = Pack(share) * overlap;
  const Pack l_i = r_i - select(pair, half * sink, sink), l_j = select(pair, r_j - half * sink, zero);

  Pack arm[3], v_c[3], w[3];
  for (int d = 0; d < 3; ++d) arm[d] = l_i * w_i[d] + l_j * w_j[d];
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    v_c[d] = v[d] - (arm[e] * n[f] - arm[f] * n[e]);
  }
  const Pack v_n = dot3(v_c, n);
  for (int d = 0; d < 3; ++d) w[d] = w_i[d] - w_j[d];
  const Pack twist = dot3(w, n);
  for (int d = 0; d < 3; ++d) {
    v_c[d] = v_c[d] - v_n * n[d];
    w[d] = w[d] - twist * n[d];
  }

  // Series sums: at a surface the sphere's own value stays.
  const auto series = [&](Pack own, Pack other) { return select(pair, own * other / (own + other), own); };
  const Pack m_i = Pack::load(b.m_i + k), m_j = Pack::load(b.m_j + k);
  const Pack m_eff = series(m_i, m_j), r_eff = series(r_i, r_j);
  const Pack i_roll = series(Pack(1.4) * m_i * r_i * r_i, Pack(1.4) * m_j * r_j * r_j);
  const Pack dt(elapsed);
  const NormalForce<Pack> normal = law.normal(Approach<Pack>{overlap, -v_n, m_eff, r_eff, dt});

  Pack xi[3], rho[3], dash_t[3], dash_r[3];
  load3(b.xi, k, xi);
  load3(b.rho, k, rho);
  load3(b.dash_t, k, dash_t);
  load3(b.dash_r, k, dash_r);
  turn(xi, n);
  turn(rho, n);
  const Slip<Pack> slide = law.friction.slide(normal, xi, v_c, dash_t, Pack::load(b.slipping + k), dt);
  const Slip<Pack> roll = law.friction.roll(normal, rho, w, dash_r, r_eff, i_roll, dt);

  Pack f[3], t_i[3], t_j[3];
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    f[d] = normal.force * n[d] - slide.force[d];
    const Pack q = n[e] * slide.force[g] - n[g] * slide.force[e];
    t_i[d] = l_i * q - roll.force[d];
    t_j[d] = l_j * q + roll.force[d];
  }
  const Writer write{Pack::load(b.law + k) == Pack(static_cast<double>(law_index)), k};
  const Pack damped_n = half * (Pack::load(b.dash_n + k) + normal.damping) * (-v_n) * dt;
  write(b.f, f);
  write(b.t_i, t_i);
  write(b.t_j, t_j);
  write(b.overlap, overlap);
  write(b.damping, damped_n + slide.damped);
  write(b.sliding, slide.slid);
  write(b.rolling, roll.slid + roll.damped);
  const Pack k_r = Pack(law.friction.rolling == Rolling::elastic_plastic ? 2.25 * law.friction.mu_r * law.friction.mu_r : 0.0) *
                   normal.k_n * r_eff * r_eff;
  write(b.stored, normal.stored + half * normal.k_t * dot3(slide.x, slide.x) + half * k_r * dot3(roll.x, roll.x));
  write(b.xi, slide.x);
  write(b.rho, roll.x);
  write(b.dash_n, normal.damping);
  write(b.dash_t, slide.dashpot);
  write(b.dash_r, roll.dashpot);
  write(b.slipping, slide.slipping);
}

void evaluate(const LawTable& table, Batch& b, int count, double elapsed) {
  // Lanes past the count hold what an earlier batch left: they compute something harmless that nobody reads.
  bool used[256] = {};
  for (int k = 0; k < count; ++k) used[static_cast<unsigned char>(b.law[k])] = true;
  for (std::size_t i = 0; i < table.laws.size(); ++i) {
    if (!used[i]) continue;
    std::visit(
        [&](const auto& law) {
          const double share = law.friction.lever == Lever::mid_overlap ? 1.0 : 0.0;
          for (int k = 0; k < count; k += kWidth) evaluate_lanes(law, share, b, k, static_cast<int>(i), elapsed);
        },
        table.laws[i]);
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
