#pragma once
#include "libdem/kernel/pack.hpp"
#include "libdem/laws/law_table.hpp"

/// One contact, kWidth at a time: geometry, slip and rolling velocities, which are common to all laws, around the law.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

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

template <int Own>
struct History {
  Pack xi[3], rho[3], dash_n, dash_t[3], dash_r[3], slipping;
  Pack own[Own > 0 ? Own : 1];  ///< of the law
};

template <class L>
inline constexpr int kOwn = own_memory<L>();

/// Contact partners; n from j to i.
struct Touch {
  Pack n[3], overlap, v[3];  ///< v of the centre (at a surface: of the sphere against the surface's point)
  Pack r_i, m_i, w_i[3];
  Pack r_j, m_j, w_j[3];  ///< of a surface only its spin
};

/// What the law needs of them.
struct Meeting {
  Pack n[3], overlap, v_n, v_t[3];
  Pack l_i, l_j;                  ///< levers of tangential forces
  Pack root_m, r_eff, inverse_r;  ///< sqrt(m_eff); effective radius and 1 over it
  // With rolling resistance: rolling velocity, spin about the normal, sqrt of both bodies' 7/5 m r^2 in series.
  Pack w[3], twist, root_i;
};

struct Response {
  Pack f[3], t_i[3], t_j[3];          ///< on i; t_j of a surface: its rolling torque only
  Pack damped, slid, rolled, stored;  ///< J
};

/// `Pair`: two spheres, contact point in the middle of the overlap; else a sphere and a surface, contact point on the
/// surface. `share` 1 for these levers, 0 for the radius.
template <bool Pair, bool Rolls>
[[gnu::always_inline]] inline Meeting meet(double share, const Touch& a) {
  const Pack zero(0.0);
  Meeting out;
  const Pack sink = Pack(Pair ? 0.5 * share : share) * a.overlap;
  out.overlap = a.overlap;
  out.l_i = a.r_i - sink, out.l_j = Pair ? a.r_j - sink : zero;
  Pack arm[3];
  for (int d = 0; d < 3; ++d) arm[d] = Pair ? out.l_i * a.w_i[d] + out.l_j * a.w_j[d] : out.l_i * a.w_i[d];
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    out.n[d] = a.n[d];
    out.v_t[d] = a.v[d] - (arm[e] * a.n[f] - arm[f] * a.n[e]);
  }
  out.v_n = dot3(out.v_t, a.n);
  for (int d = 0; d < 3; ++d) out.v_t[d] = out.v_t[d] - out.v_n * a.n[d];
  const Pack product = a.m_i * a.m_j;
  out.root_m = Pair ? product * rsqrt(product * (a.m_i + a.m_j)) : sqrt(a.m_i);
  if constexpr (Pair) {
    // r_eff = r1 r2/(r1 + r2) and its inverse from one division.
    const Pack both = a.r_i * a.r_j, sum = a.r_i + a.r_j, inverse = Pack(1.0) / (both * sum);
    out.r_eff = both * both * inverse;
    out.inverse_r = sum * sum * inverse;
  } else {
    out.r_eff = a.r_i;
    out.inverse_r = Pack(1.0) / a.r_i;
  }
  if constexpr (Rolls) {
    for (int d = 0; d < 3; ++d) out.w[d] = a.w_i[d] - a.w_j[d];
    out.twist = dot3(out.w, a.n);
    for (int d = 0; d < 3; ++d) out.w[d] = out.w[d] - out.twist * a.n[d];
    const Pack own = Pack(1.4) * a.m_i * a.r_i * a.r_i, other = Pack(1.4) * a.m_j * a.r_j * a.r_j;
    const Pack inertias = own * other;
    out.root_i = Pair ? inertias * rsqrt(inertias * (own + other)) : sqrt(own);
  }
  return out;
}

/// Resistance to twist. Its spring and dashpot lie in those of rolling, along the normal, where rolling has no part.
template <class L, int Own>
[[gnu::always_inline]] inline void resist_twist(const L& law, const Meeting& a, const NormalForce<Pack>& normal,
                                                Pack angle, Pack dash_before, Pack dt, History<Own>& h, Response& out) {
  const Slip<Pack, 1> s = law.friction.twist(normal, angle, a.twist, dash_before, a.r_eff, a.inverse_r, a.root_i, dt);
  for (int d = 0; d < 3; ++d) {
    out.t_i[d] = out.t_i[d] - s.force[0] * a.n[d];
    out.t_j[d] = out.t_j[d] + s.force[0] * a.n[d];
    h.rho[d] = h.rho[d] + s.x[0] * a.n[d];
    h.dash_r[d] = h.dash_r[d] + s.dashpot[0] * a.n[d];
  }
  const Pack k = Pack(Friction::turning_share(law.friction.mu_t)) * normal.k_n * a.r_eff * a.r_eff;
  out.rolled += s.slid + s.damped;
  out.stored += Pack(0.5) * k * s.x[0] * s.x[0];
}

/// The law on what meets; h is the contact's memory, in and out.
template <bool Pair, bool Rolls, class L>
[[gnu::always_inline]] inline Response respond(const L& law, const Meeting& a, History<kOwn<L>>& h, double elapsed) {
  const Pack zero(0.0), half(0.5), dt(elapsed);
  const NormalForce<Pack> normal = normal_force(law, Approach<Pack>{a.overlap, -a.v_n, a.root_m, a.r_eff, dt}, h.own);
  turn(h.xi, a.n);
  const Slip<Pack> slide = law.friction.slide(normal, h.xi, a.v_t, h.dash_t, h.slipping, dt);
  Response out;
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    out.f[d] = normal.force * a.n[d] - slide.force[d];
    const Pack q = a.n[e] * slide.force[g] - a.n[g] * slide.force[e];
    out.t_i[d] = a.l_i * q;
    out.t_j[d] = Pair ? a.l_j * q : zero;
    h.xi[d] = slide.x[d];
  }
  out.damped = half * (h.dash_n + normal.damping) * (-a.v_n) * dt + normal.lost + slide.damped;
  out.slid = slide.slid;
  out.rolled = zero;
  out.stored = normal.stored + half * normal.k_t * dot3(slide.x, slide.x);
  if constexpr (Rolls) {
    const bool twists = law.friction.resists_twist();
    const Pack angle = twists ? dot3(h.rho, a.n) : zero, dash_before = twists ? dot3(h.dash_r, a.n) : zero;
    turn(h.rho, a.n);
    const Slip<Pack> roll = law.friction.roll(normal, h.rho, a.w, h.dash_r, a.r_eff, a.inverse_r, a.root_i, dt);
    const double share =
        law.friction.rolling == Rolling::elastic_plastic ? Friction::turning_share(law.friction.mu_r) : 0.0;
    const Pack k_r = Pack(share) * normal.k_n * a.r_eff * a.r_eff;
    for (int d = 0; d < 3; ++d) {
      out.t_i[d] = out.t_i[d] - roll.force[d];
      out.t_j[d] = out.t_j[d] + roll.force[d];
      h.rho[d] = roll.x[d];
      h.dash_r[d] = roll.dashpot[d];
    }
    out.rolled = roll.slid + roll.damped;
    out.stored += half * k_r * dot3(roll.x, roll.x);
    if (twists) resist_twist(law, a, normal, angle, dash_before, dt, h, out);
  }
  for (int d = 0; d < 3; ++d) h.dash_t[d] = slide.dashpot[d];
  h.dash_n = normal.damping;
  h.slipping = slide.slipping;
  return out;
}

template <class L>
double lever_share(const L& law) {
  return law.friction.lever == Lever::mid_overlap ? 1.0 : 0.0;
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
