#pragma once
#include "libdem/laws/contact.hpp"

/// A spring and a dashpot in parallel under a limit: the element of sliding, rolling and twisting resistance.
///
/// With x_0 the spring before the step, v its rate, L = the limit while it sticks or while it slips,
///     x* = x_0 + v dt,   g = k x* + c v,   e = g/|g|
///     |g| <= L:  F = g,    x = x*
///     else:      F = L e,  x = x* - a e,   a = max(0, min((|g| - L)/k, x* . e, (x_0 + x*) . e))
/// The spring slides back by what exceeds the limit: k x = L e - c v, the limit less the dashpot's part. It slides back
/// no further than until it is free along e: where c v alone exceeds L, it would be wound up against the sliding and
/// give that back later as motion. What sliding takes in a step,
///     (k/2) a (x_0 + x) . e = (k/2) a ((x_0 + x*) . e - a) >= 0,
/// is never negative by the last bound, which acts where the sliding turns round within the step. A limit of the spring
/// alone takes the same form with g = k x*: F = min(|g|, L) e + c v. `set_back` leaves out the bounds of a, as LAMMPS
/// and MercuryDPM do; that may make energy, which is accumulated as a negative loss. Energy over a step: spring force
/// (mean of both ends) times sliding -> slid; dashpot force (mean) times velocity -> damped, at a limit that caps both
/// -> slid; a spring dropped at separation, or softened by a stiffness that changes, -> slid.
namespace subsoil::dem {

enum class Changing { lossy, keep_spring, keep_force, rescale };

/// Element after one step.
template <class T, int D = 3>
struct Slip {
  T x[D];        ///< spring, m or rad
  T force[D];    ///< resisting force or torque on the first body is -force
  T dashpot[D];  ///< viscous part of `force`
  T slipping;    ///< 1 at the limit, else 0
  T slid;        ///< energy lost in the limit, J
  T damped;      ///< energy lost in the dashpot, J
};

/// What the limit of an element caps.
struct Cap {
  bool together = true;   ///< spring and dashpot; else the spring alone
  double kept = 0;        ///< share of the dashpot that stays beside a spring at its limit
  bool set_back = false;  ///< the spring goes back to L e - c v also where that winds it up
};

/// Share of the spring that is kept where its stiffness changes. @param ratio stiffness before over stiffness now
template <class T>
[[gnu::always_inline]] inline T kept_share(Changing changing, T ratio) {
  const T one(1.0);
  switch (changing) {
    case Changing::keep_spring:
      return one;
    case Changing::keep_force:
      return ratio;
    case Changing::rescale:
      return min(one, one / max(ratio, tiny<T>()));
    default:
      return min(one, ratio);
  }
}

template <class T>
[[gnu::always_inline]] inline T in_unit_of_squares(T a) {
  if constexpr (SquareRange<T>::unit == 1)
    return a;
  else
    return a * T(SquareRange<T>::unit);
}

/// @param stiffness_ratio stiffness before over stiffness now; @param soft 1/k, 0 without a spring
template <class T, int D>
[[gnu::always_inline]] inline Slip<T, D> stick_slip(const T (&x)[D], const T (&v)[D], const T (&dashpot_before)[D],
                                                    T slipping_before, T dt, T stiffness_ratio, T k, T soft, T c,
                                                    T limit_static, T limit_kinetic, Mask<T> in_contact, Cap cap,
                                                    Changing changing = Changing::lossy) {
  Slip<T, D> out;
  const T zero(0.0), one(1.0), half(0.5);
  // Outside contact nothing is kept, moved or damped: g is 0 there, and nothing slips.
  const T keep = select(in_contact, kept_share(changing, stiffness_ratio), zero);
  const T lasts = select(in_contact, dt, zero), c_held = select(in_contact, c, zero);
  T trial[D], viscous[D], g[D], g2 = zero, x2 = zero, along = zero, rate = zero;  // x* . g, v . g
  for (int d = 0; d < D; ++d) {
    trial[d] = x[d] * keep + v[d] * lasts;
    viscous[d] = c_held * v[d];
    g[d] = cap.together ? k * trial[d] + viscous[d] : k * trial[d];
    const T scaled = in_unit_of_squares(g[d]);
    g2 = g2 + scaled * scaled;
    x2 = x2 + x[d] * x[d];
    out.force[d] = cap.together ? g[d] : g[d] + viscous[d];
    out.x[d] = trial[d], out.dashpot[d] = viscous[d];
  }
  const T limit = select(slipping_before > half, limit_kinetic, limit_static);
  const T scaled_limit = in_unit_of_squares(limit);
  const auto slip = g2 > scaled_limit * scaled_limit;
  T inverse = zero, scale = one;
  T back = zero;    // a/|g|; 0 while it sticks
  if (any(slip)) {  // most contacts of a bed stick: a fifth of the step with rolling resistance
    inverse = in_unit_of_squares(rsqrt(max(g2, T(SquareRange<T>::least))));  // 1/|g|
    scale = select(slip, limit_kinetic * inverse, one);
    const T over = (one - scale) * soft;
    for (int d = 0; d < D; ++d) along = along + trial[d] * g[d], rate = rate + v[d] * g[d];
    const T free = min(along, along + along - dt * rate) * inverse * inverse;
    back = cap.set_back ? max(zero, over) : max(zero, min(over, free));
    const T share = cap.together ? zero : select(slip, T(cap.kept), one);
    for (int d = 0; d < D; ++d) {
      out.force[d] = cap.together ? g[d] * scale : g[d] * scale + viscous[d] * share;
      out.x[d] = trial[d] - back * g[d];
      out.dashpot[d] = select(slip, out.force[d] - k * out.x[d], viscous[d]);
    }
  }
  out.slipping = select(slip, one, zero);
  T power = zero;
  for (int d = 0; d < D; ++d) power = power + (dashpot_before[d] + out.dashpot[d]) * v[d];
  // (x_0 + x) . g with x = x* - back g, x_0 = x* - v dt; softening besides.
  T set_back_along = back * g2;  // back |g|^2
  if constexpr (SquareRange<T>::unit != 1) {
    const T size = g2 * inverse * T(1 / (SquareRange<T>::unit * SquareRange<T>::unit));  // |g|
    set_back_along = back * size * size;
  }
  out.slid = half * k * (x2 * (stiffness_ratio - keep * keep) + back * (along + along - dt * rate - set_back_along));
  const T damped = half * dt * power;
  // Without a spring the limited force is a dashpot's.
  const T slides = cap.together ? select(both(slip, k > zero), max(zero, damped), zero) : zero;
  out.slid = out.slid + slides;
  out.damped = damped - slides;
  return out;
}

}  // namespace subsoil::dem
