#pragma once
#include "libdem/contacts/contact_memory.hpp"
#include "libdem/laws/bonded.hpp"
#include "libdem/laws/friction.hpp"
#include "libdem/simd/vec_f.hpp"

/// One contact, a SIMD vector at a time: geometry, slip and rolling velocities, which are common to all laws, around
/// the law. P is the number type, VecD or VecF.
///
/// Positions are those of t_n, velocities those of t_n - dt/2 (leapfrog). A rate is taken in the geometry of the same
/// instant, n_m = n - turn, and then turned with n to the end of the step:
///     v_n = v . n_m,   v_t = Q (v - v_n n_m - arm x n_m),   Q = 1 + turn n^T - n turn^T,   Q n_m = n
/// to the second order in the turn. With n in place of n_m a sphere that spins about n while it rolls slips by half
/// the turn times that spin: a grain sticks between two larger ones (Vyas et al. 2025,
/// doi:10.1016/j.cpc.2025.109524).
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <class T>
[[gnu::always_inline]] inline T dot3(const T (&a)[3], const T (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class T>
[[gnu::always_inline]] inline void cross3(const T (&a)[3], const T (&b)[3], T (&out)[3]) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    out[d] = a[e] * b[f] - a[f] * b[e];
  }
}

/// Turns a spring with the normal into the plane across n: along n_m it is the rotation but for the cube of the angle.
/// Along n it would shrink by half the square of the angle in each step, an error of first order.
template <class T>
[[gnu::always_inline]] inline void turn_with_normal(T (&s)[3], const T (&n)[3], const T (&n_mid)[3]) {
  const T along = dot3(s, n);
  for (int d = 0; d < 3; ++d) s[d] = s[d] - along * n_mid[d];
}

/// sqrt(a b/(a + b)).
inline VecD series_root(VecD a, VecD b) {
  const VecD product = a * b;
  return product * rsqrt(product * (a + b));
}
/// Inertias of fine grains, 1e-17 kg m2, multiplied by each other are no floats any more.
inline VecF series_root(VecF a, VecF b) { return sqrt(a * (b / (a + b))); }

/// Spheres in contact; n from j to i.
template <class P>
struct Touch {
  P n[3], overlap, v[3];  ///< v of the centre (at a surface: of the sphere against the surface's point)
  P w_i[3], w_j[3];       ///< of a surface only its angular velocity
  P r_i, r_j;
  P v_n;        ///< of a pair: v . n
  P w[3], w_n;  ///< of a pair of equal spheres: w_i + w_j, and its part along n
  P turn_rate;  ///< of a pair: turn over the velocity across n, half the step over the distance of the centres, s/m
  P turn[3];    ///< at a surface: n less that of the middle of the step, square to n
};

/// Effective mass and radius, and with rolling resistance the series of both bodies' 7/5 m r^2.
template <class P>
struct Effective {
  P root_m, r_eff, inverse_r, root_i, per_sum;
  P smaller;  ///< radius of the smaller sphere, of pairs only
};

/// Fills what the law needs of `e`.
template <bool Pair, bool Rolls, class L, class P>
[[gnu::always_inline]] inline void effective(P r_i, P m_i, P r_j, P m_j, Effective<P>& e) {
  constexpr bool Radius = L::has.needs_radius || Rolls, Sum = L::has.needs_sum;
  e.root_m = Pair ? series_root(m_i, m_j) : sqrt(m_i);
  if constexpr (Radius && Pair) {
    // r_eff = r1 r2/(r1 + r2) and its inverse from one division.
    const P both = r_i * r_j, sum = r_i + r_j, inverse = P(1.0) / (both * sum);
    e.r_eff = both * both * inverse, e.inverse_r = sum * sum * inverse;
    if constexpr (Sum) e.per_sum = both * inverse;
  } else if constexpr (Radius) {
    e.r_eff = r_i, e.inverse_r = P(1.0) / r_i;
  } else {
    e.r_eff = P(0.0);  // read by nobody
  }
  if constexpr (!(Pair && Sum)) e.per_sum = P(0.0);
  if constexpr (Rolls) {
    const P own = P(1.4) * m_i * r_i * r_i;
    e.root_i = Pair ? series_root(own, P(1.4) * m_j * r_j * r_j) : sqrt(own);
  }
  if constexpr (Pair) e.smaller = min(r_i, r_j);
}

/// What the law needs of them: rates of the middle of the step, turned with the normal to its end.
template <class P>
struct Meeting {
  P n[3], n_mid[3];  ///< at the end, in the middle
  P overlap, v_n, v_t[3];
  P w[3], twist;  ///< with rolling resistance: rolling velocity, angular velocity about the normal
  P l_i, l_j;     ///< moment arms of tangential forces
  Effective<P> effective;
};

/// Of spheres that may be bonded.
template <class P>
struct BondedMeeting : Meeting<P> {
  P w_n;  ///< mean angular velocity of both about the normal
};
template <bool Pair, class L, class P>
using MeetingOf = std::conditional_t<Pair && kBonds<L>, BondedMeeting<P>, Meeting<P>>;

template <class P>
struct Response {
  P f[3], t_i[3], t_j[3];                   ///< on i; t_j of a surface: its rolling torque only
  P damped, slid, rolled, yielded, stored;  ///< J
};

/// `Pair`: two spheres, `Equal` of one radius; else a sphere and a surface. What needs no normal has been worked out
/// before (Touch): the processor has one or two SIMD vectors under way, and waits for the chain that begins with the
/// root of the distance.
template <bool Pair, bool Equal, bool Rolls, class L, class P>
[[gnu::always_inline]] inline void meet(const MomentArmShares& share, P half_dt, const Touch<P>& a,
                                        MeetingOf<Pair, L, P>& out) {
  // Spins move the contact point across n only: what the centres do along it is known before the moment arms are.
  const P v_n = Pair ? a.v_n : dot3(a.v, a.n);
  // turn = rate * across: of a pair without a vector for the turn itself, which costs 1 % of the sweep.
  P across[3];
  const P rate = Pair ? a.turn_rate : P(1.0);
  for (int d = 0; d < 3; ++d) {
    across[d] = Pair ? a.v[d] - v_n * a.n[d] : a.turn[d];
    out.n[d] = a.n[d], out.n_mid[d] = Pair ? a.n[d] - rate * across[d] : a.n[d] - across[d];
  }
  const P force_share(share.force), slip_share(share.slip), share_of_rate = slip_share * half_dt;
  const P slip_i = a.r_i - slip_share * a.overlap - share_of_rate * v_n;
  const P slip_j = Pair ? P(a.r_j - slip_share * a.overlap - share_of_rate * v_n) : P(0.0);
  P arm[3];
  // Q (arm x n_m) = (arm + (arm . n) turn) x n, and Q (v - v_n n_m) = v - (v . n) n_m.
  if constexpr (Equal) {
    const P about_n = rate * a.w_n;
    for (int d = 0; d < 3; ++d) arm[d] = slip_i * (a.w[d] + about_n * across[d]);
  } else {
    for (int d = 0; d < 3; ++d) arm[d] = Pair ? slip_i * a.w_i[d] + slip_j * a.w_j[d] : slip_i * a.w_i[d];
    const P about_n = Pair ? rate * dot3(arm, a.n) : dot3(arm, a.n);
    for (int d = 0; d < 3; ++d) arm[d] = arm[d] + about_n * across[d];
  }
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    out.v_t[d] = a.v[d] - v_n * out.n_mid[d] - arm[e] * a.n[f] + arm[f] * a.n[e];
  }
  if constexpr (Rolls) {
    P w[3];
    for (int d = 0; d < 3; ++d) w[d] = a.w_i[d] - a.w_j[d];
    const P along = dot3(w, a.n);
    for (int d = 0; d < 3; ++d) out.w[d] = w[d] - along * out.n_mid[d];
    out.twist = dot3(w, out.n_mid);
  }
  if constexpr (Pair && kBonds<L>) out.w_n = P(0.5) * (dot3(a.w_i, out.n_mid) + dot3(a.w_j, out.n_mid));
  out.overlap = a.overlap, out.v_n = dot3(a.v, out.n_mid);
  out.l_i = a.r_i - force_share * a.overlap;
  out.l_j = Pair ? P(a.r_j - force_share * a.overlap) : P(0.0);
}

/// Resistance to twist. Its spring is a number of its own: the vector of rolling would turn a part of it into rolling
/// wherever the normal turns.
template <bool Usual, class L, class P>
[[gnu::always_inline]] inline void resist_twist(const L& law, const Meeting<P>& a, const Effective<P>& e,
                                                const NormalForce<P>& normal, P dt, ContactMemory<P>& h,
                                                Response<P>& out) {
  const Slip<P, 1> s =
      law.friction.template twist<Usual>(normal, h.twist, a.twist, h.dash_w, e.r_eff, e.inverse_r, e.root_i, dt);
  for (int d = 0; d < 3; ++d) {
    out.t_i[d] = out.t_i[d] - s.force[0] * a.n[d];
    out.t_j[d] = out.t_j[d] + s.force[0] * a.n[d];
  }
  h.twist = s.x[0], h.dash_w = s.dashpot[0];
  const P k = P(Friction::turning_share(law.friction.mu_t)) * normal.k_n * e.r_eff * e.r_eff;
  out.rolled += s.slid + s.damped;
  out.stored += P(0.5) * k * s.x[0] * s.x[0];
}

/// The law on what meets; h is the contact's memory, in and out. `Usual`: law.friction.usual() holds.
template <bool Pair, bool Rolls, bool Usual, class P, class L>
[[gnu::always_inline]] inline Response<P> respond(const L& law, const Meeting<P>& a, ContactMemory<P>& h,
                                                  double elapsed) {
  const P zero(0.0), half(0.5), dt(elapsed);
  const Effective<P>& e = a.effective;
  NormalForce<P> normal = normal_force(law, Approach<P>{a.overlap, -a.v_n, e.root_m, e.r_eff, dt, e.per_sum}, h.own);
  if constexpr (!Usual) law.friction.adjust(normal, e.root_m);
  turn_with_normal(h.xi, a.n, a.n_mid);
  const Slip<P> slide = law.friction.template slide<Usual>(normal, h.xi, a.v_t, h.dash_t, h.slipping, dt);
  Response<P> out;
  for (int d = 0; d < 3; ++d) {
    const int f = (d + 1) % 3, g = (d + 2) % 3;
    out.f[d] = normal.force * a.n[d] - slide.force[d];
    const P q = a.n[f] * slide.force[g] - a.n[g] * slide.force[f];
    out.t_i[d] = a.l_i * q;
    out.t_j[d] = Pair ? a.l_j * q : zero;
    h.xi[d] = slide.x[d];
  }
  out.damped = half * (h.dash_n + normal.damping) * (-a.v_n) * dt + normal.lost + slide.damped;
  out.slid = slide.slid;
  out.rolled = out.yielded = zero;
  out.stored = normal.stored + half * normal.k_t * dot3(slide.x, slide.x);
  if constexpr (Rolls) {
    turn_with_normal(h.rho, a.n, a.n_mid);
    const Slip<P> roll =
        law.friction.template roll<Usual>(normal, h.rho, a.w, h.dash_r, e.r_eff, e.inverse_r, e.root_i, dt);
    const P k_r = law.friction.rolling_stiffness(normal, e.r_eff);
    for (int d = 0; d < 3; ++d) {
      out.t_i[d] = out.t_i[d] - roll.force[d];
      out.t_j[d] = out.t_j[d] + roll.force[d];
      h.rho[d] = roll.x[d];
      h.dash_r[d] = roll.dashpot[d];
    }
    out.rolled = roll.slid + roll.damped;
    out.stored += half * k_r * dot3(roll.x, roll.x);
    if (law.friction.resists_twist()) resist_twist<Usual>(law, a, e, normal, dt, h, out);
  }
  for (int d = 0; d < 3; ++d) h.dash_t[d] = slide.dashpot[d];
  h.dash_n = normal.damping;
  h.slipping = slide.slipping;
  return out;
}

/// What a contact gives and remembers vanishes where a bond replaces it.
template <class Has, class P>
[[gnu::always_inline]] inline void vanish(Mask<P> where, const Has& has, Response<P>& out, ContactMemory<P>& h) {
  const P zero(0.0);
  const auto clear = [&](P& x) { x = select(where, zero, x); };
  for (int d = 0; d < 3; ++d) clear(out.f[d]), clear(out.t_i[d]), clear(out.t_j[d]);
  clear(out.damped), clear(out.slid), clear(out.rolled), clear(out.stored);
  each_field(
      has, h, [&](P& x, int) { clear(x); }, [&](P& x, int) { clear(x); });
}

/// The bond's part beside that of the contact. Returns whether one broke in any lane.
template <class L, class P>
[[gnu::always_inline]] inline bool respond_bond(const L& law, const BondedMeeting<P>& a, BondMemory<P>& memory,
                                                double elapsed, Response<P>& out) {
  BondMotion<P> m;
  for (int d = 0; d < 3; ++d) m.n[d] = a.n[d], m.n_mid[d] = a.n_mid[d], m.v_t[d] = a.v_t[d], m.w[d] = a.w[d];
  m.overlap = a.overlap, m.v_n = a.v_n, m.twist = a.twist, m.w_n = a.w_n;
  m.smaller = a.effective.smaller, m.sum = a.l_i + a.l_j + a.overlap;  // moment arms to the middle of the overlap
  m.root_m = a.effective.root_m, m.root_i = P(std::sqrt(2.0 / 7.0)) * a.effective.root_i;
  m.dt = P(elapsed);
  const BondForce<P> b = law.bond.act(m, memory);
  for (int d = 0; d < 3; ++d) {
    const int f = (d + 1) % 3, g = (d + 2) % 3;
    const P q = a.n[f] * b.shear[g] - a.n[g] * b.shear[f], moment = b.bending[d] + b.twisting * a.n[d];
    out.f[d] = out.f[d] + b.normal * a.n[d] - b.shear[d];
    out.t_i[d] = out.t_i[d] + a.l_i * q - moment;
    out.t_j[d] = out.t_j[d] + a.l_j * q + moment;
  }
  out.damped = out.damped + b.damped;
  out.yielded = b.yielded;
  out.stored = out.stored + b.stored;
  return any(b.broke);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
