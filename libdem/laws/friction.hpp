#pragma once
#include <algorithm>
#include <limits>

#include "libdem/laws/contact.hpp"

/// Tangential and rolling resistance, shared by every normal law.
///
/// Tangential: spring xi (m) and dashpot, capped together by Coulomb's limit. With xi_0 the spring before the step,
///     xi* = xi_0 + v_t dt,   g = k_t xi* + c_t v_t,   e = g/|g|,   L = mu N_f (sticking) or mu_d N_f (slipping)
///     |g| <= L:  F_t = g,    xi = xi*
///     else:      F_t = L e,  xi = xi* - a e,   a = min((|g| - L)/k_t, max(0, xi_0 . e))
/// The spring slides back by what exceeds the limit: k_t xi = L e - c_t v_t, the limit less the dashpot's part (LAMMPS,
/// MercuryDPM). It slides back no further than its part along e at the start of the step: where c_t v_t alone exceeds
/// L, it would be wound up against the sliding and give that back later as motion. What sliding takes in a step,
///     (k_t/2) a (xi_0 + xi) . e >= (k_t/2) a xi* . e >= 0,
/// is never negative: a > 0 asks xi_0 . e > 0, and then k_t xi* . e is k_t (xi_0 . e + v_t . e dt) for v_t . e >= 0,
/// else |g| - c_t v_t . e. `friction rule` caps the spring alone with the same words, g = k_t xi*: F_t = min(|g|, L) e
/// + c_t v_t (`spring-only`), without c_t v_t at the limit (`spring-only-undamped`, LIGGGHTS). `tangential` takes the
/// spring away: dashpot, F_t = min(c_t |v_t|, mu N_f) against v_t (LAMMPS linear_nohistory,
///     LIGGGHTS no_history), or constant-direction, F_t = mu_d N_f v_t/|v_t|, which jitters in a resting
///     bed.
/// Where k_t changes with the overlap, `changing stiffness` says what is kept:
///     lossy: the force k_t xi while k_t rises, the spring xi while it falls (Thornton, Cummins, Cleary 2013); only
///         loses energy
///     keep-spring: xi, so that F_t = k_t xi (EDEM, LIGGGHTS, LAMMPS mindlin); a rising k_t makes energy
///     keep-force: k_t xi, so that dF_t = k_t dxi (incremental Mindlin without slip); a falling k_t makes energy
///     What is made is accumulated as a negative loss in sliding.
/// Rolling, elastic-plastic (Ai, Chen, Rotter, Ooi 2011, type C): the angle rho (rad) in place of xi, the spring capped
///     alone, k_r = 2.25 k_n (mu_r r_eff)^2, cap mu_r r_eff N_f, dashpot c_r = 2 eta_r sqrt(I_r k_r) below the cap and
///     f c_r at it (f: `rolling damping at limit`), I_r the series sum of both bodies' 7/5 m r^2.
/// Rolling, constant torque: -mu_r r_eff N_f w/|w|; it jitters in a resting bed.
/// Twist (mu_t > 0): the same element with the angle about the normal,
///     k_w = 2.25 k_n (mu_t r_eff)^2, cap mu_t r_eff N_f, dashpot 2 eta_r sqrt(I_w k_w), I_w = (2/7) I_r.
/// Symbols: v_t sliding velocity at the contact point (m/s), w relative rolling velocity (rad/s), N_f N.
/// Energy over a step: spring force (mean of both ends) times sliding -> sliding; dashpot force (mean) times velocity
/// -> damping, at a limit that caps both -> sliding; a spring dropped at separation, or softened by a stiffness that
/// changes, -> sliding.
namespace subsoil::dem {

/// Where the contact point of two spheres lies: in the middle of the overlap (moment arm r - delta/2; r - delta at a
/// boundary, angular momentum is kept), or on each sphere's surface (moment arm r).
enum class MomentArm { mid_overlap, radius };
enum class Tangential { spring, dashpot, constant_direction };
enum class Changing { lossy, keep_spring, keep_force };
enum class Rolling { none, elastic_plastic, constant_torque };

/// What Coulomb's limit caps: spring and dashpot together, or the spring alone, beside which the dashpot stays or goes.
enum class FrictionRule { spring_and_dashpot, spring_only, spring_only_undamped };

/// Spring-and-dashpot element with a limit, after one step.
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
  bool together = true;  ///< spring and dashpot; else the spring alone
  double kept = 0;       ///< share of the dashpot that stays beside a spring at its limit
};

/// @param stiffness_ratio stiffness before over stiffness now; @param soft 1/k, 0 without a spring
template <class T, int D>
[[gnu::always_inline]] inline Slip<T, D> stick_slip(const T (&x)[D], const T (&v)[D], const T (&dashpot_before)[D],
                                                    T slipping_before, T dt, T stiffness_ratio, T k, T soft, T c,
                                                    T limit_static, T limit_kinetic, Mask<T> in_contact, Cap cap,
                                                    Changing changing = Changing::lossy) {
  Slip<T, D> out;
  const T zero(0.0), one(1.0), half(0.5);
  const T kept = changing == Changing::keep_spring  ? one
                 : changing == Changing::keep_force ? stiffness_ratio
                                                    : min(one, stiffness_ratio);
  const T keep = select(in_contact, kept, zero);
  T x0[D], trial[D], viscous[D], g[D], g2 = zero, x2 = zero, along = zero, rate = zero;
  for (int d = 0; d < D; ++d) {
    x0[d] = x[d] * keep;
    trial[d] = select(in_contact, x0[d] + v[d] * dt, zero);
    viscous[d] = c * v[d];
    g[d] = cap.together ? k * trial[d] + viscous[d] : k * trial[d];
    g2 = g2 + g[d] * g[d];
    x2 = x2 + x[d] * x[d];
    along = along + x0[d] * g[d];
    rate = rate + v[d] * g[d];
  }
  const T limit = select(slipping_before > half, limit_kinetic, limit_static);
  const auto slip = g2 > limit * limit;
  const T inverse = rsqrt(max(g2, tiny<T>()));
  const T scale = select(slip, limit_kinetic * inverse, one);
  const T back = max(zero, min((one - scale) * soft, along * inverse * inverse));  // a/|g|; 0 while it sticks
  const T share = cap.together ? zero : select(slip, T(cap.kept), one);
  out.slipping = select(both(in_contact, slip), one, zero);
  T power = zero;
  for (int d = 0; d < D; ++d) {
    const T force = cap.together ? g[d] * scale : g[d] * scale + viscous[d] * share;
    out.force[d] = select(in_contact, force, zero);
    out.x[d] = trial[d] - back * g[d];
    out.dashpot[d] = select(in_contact, select(slip, force - k * out.x[d], viscous[d]), zero);
    power = power + (dashpot_before[d] + out.dashpot[d]) * v[d];
  }
  // (x_0 + x) . g with x = x_0 + v dt - back g; softening besides.
  out.slid = half * k * (x2 * (stiffness_ratio - keep * keep) + back * (along + along + dt * rate - back * g2));
  const T damped = half * dt * power;
  // Without a spring the limited force is a dashpot's.
  const T slides = cap.together ? select(both(both(in_contact, slip), k > zero), max(zero, damped), zero) : zero;
  out.slid = out.slid + slides;
  out.damped = damped - slides;
  return out;
}

struct Friction {
  double mu = std::numeric_limits<double>::quiet_NaN();
  double mu_d = std::numeric_limits<double>::quiet_NaN();  ///< left out: the same as mu
  Tangential tangential = Tangential::spring;
  Changing changing = Changing::lossy;
  FrictionRule rule = FrictionRule::spring_and_dashpot;
  double mu_r = 0, mu_t = 0;
  double rolling_damping = 0.3, rolling_damping_at_limit = 0;
  Rolling rolling = Rolling::elastic_plastic;
  MomentArm moment_arm = MomentArm::mid_overlap;

  template <class V>
  void describe(V& v) {
    v.quantity("mu", mu, "1", "[0, inf)", "static friction coefficient, holds until slip");
    v.derived("mu_d", mu_d, "1", "[0, inf)", "friction coefficient while slipping; left out: mu");
    v.choice(
        "tangential", tangential,
        {{"spring", Tangential::spring},
         {"dashpot", Tangential::dashpot},
         {"constant-direction", Tangential::constant_direction}},
        "friction below its limit: a spring that remembers and a dashpot, the dashpot alone, or nothing: the limit "
        "against the sliding");
    v.choice(
        "changing stiffness", changing,
        {{"lossy", Changing::lossy}, {"keep-spring", Changing::keep_spring}, {"keep-force", Changing::keep_force}},
        "laws whose tangential stiffness changes with the overlap, what is kept then: rising the force and falling "
        "the spring; always the spring (EDEM, LIGGGHTS, LAMMPS mindlin); or always the force");
    v.choice("friction rule", rule,
             {{"spring-and-dashpot", FrictionRule::spring_and_dashpot},
              {"spring-only", FrictionRule::spring_only},
              {"spring-only-undamped", FrictionRule::spring_only_undamped}},
             "what Coulomb's limit caps: the tangential spring and dashpot together (LAMMPS, MercuryDPM), the spring "
             "alone with the dashpot beside it, or the spring alone and no dashpot at the limit (LIGGGHTS)");
    v.quantity("mu_r", mu_r, "1", "[0, inf)", "rolling friction coefficient");
    v.quantity("mu_t", mu_t, "1", "[0, inf)", "twisting friction coefficient: about the contact normal");
    v.choice("rolling", rolling,
             {{"elastic-plastic", Rolling::elastic_plastic},
              {"constant-torque", Rolling::constant_torque},
              {"none", Rolling::none}},
             "rolling resistance: elastic-plastic spring-dashpot (Ai type C), or a constant torque against rolling");
    v.quantity("rolling damping", rolling_damping, "1", "[0, 1]", "damping ratio of the rolling and twisting springs");
    v.quantity(
        "rolling damping at limit", rolling_damping_at_limit, "1", "[0, 1]",
        "share of the rolling and twisting dashpots that stays when their springs are fully mobilised (f of Ai)");
    v.choice("lever", moment_arm, {{"mid-overlap", MomentArm::mid_overlap}, {"radius", MomentArm::radius}},
             "arm of tangential forces about the centre: to the middle of the overlap (a boundary's surface), or the "
             "radius");
  }

  /// What most beds have. Steps that accumulate nothing are compiled for this alone; others take the
  /// longer kernel of those that do in every step.
  bool usual() const {
    return tangential == Tangential::spring && changing == Changing::lossy && rolling != Rolling::constant_torque &&
           rule == FrictionRule::spring_and_dashpot && !(rolling_damping_at_limit > 0);
  }
  /// The same when usual(), in words that the compiler can follow.
  Friction as_usual() const {
    Friction f = *this;
    f.tangential = Tangential::spring, f.changing = Changing::lossy, f.rolling = Rolling::elastic_plastic;
    f.rule = FrictionRule::spring_and_dashpot, f.rolling_damping_at_limit = 0;
    if (rolling == Rolling::none) f.mu_r = 0;
    return f;
  }
  bool resists_rolling() const { return (rolling != Rolling::none && mu_r > 0) || resists_twist(); }
  bool resists_twist() const { return mu_t > 0; }
  bool remembers_slip() const { return !std::isnan(mu_d) && mu_d != mu; }
  double mu_sliding() const { return std::isnan(mu_d) ? mu : mu_d; }

  template <class T>
  [[gnu::always_inline]] Slip<T> slide(const NormalForce<T>& n, const T (&xi)[3], const T (&v_t)[3],
                                       const T (&dashpot_before)[3], T slipping_before, T dt) const {
    const T limit = T(mu) * n.limiting_force, kinetic = T(mu_sliding()) * n.limiting_force;
    if (tangential == Tangential::spring)
      return stick_slip(xi, v_t, dashpot_before, slipping_before, dt, n.stiffness_ratio, n.k_t, n.tangential_compliance,
                        n.c_t, limit, kinetic, n.in_contact, cap(), changing);
    const T zero(0.0), v2 = v_t[0] * v_t[0] + v_t[1] * v_t[1] + v_t[2] * v_t[2];
    const T c = tangential == Tangential::dashpot ? n.c_t : kinetic / max(sqrt(v2), T(1e-12));
    Slip<T> s = stick_slip(xi, v_t, dashpot_before, slipping_before, dt, T(1.0), zero, zero, c, limit, kinetic,
                           n.in_contact, {});
    for (T& x : s.x) x = zero;
    return s;
  }

  /// @param inverse_r 1/r_eff, 1/m; @param root_i square root of the series sum of both bodies' 7/5 m r^2, kg^1/2 m
  template <class T>
  [[gnu::always_inline]] Slip<T> roll(const NormalForce<T>& n, const T (&rho)[3], const T (&w)[3],
                                      const T (&dashpot_before)[3], T r_eff, T inverse_r, T root_i, T dt) const {
    if (rolling == Rolling::none || !(mu_r > 0)) return {};  // twist alone
    const T arm = T(mu_r) * r_eff, cap = arm * n.limiting_force, zero(0.0);
    if (rolling == Rolling::constant_torque) {
      // A dashpot whose coefficient makes the torque cap w/|w|: no spring, no state.
      const T speed = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
      const T c = cap / max(speed, T(1e-12));
      return stick_slip(rho, w, dashpot_before, zero, dt, T(1.0), zero, zero, c, T(2.0) * cap + tiny<T>(),
                        T(2.0) * cap + tiny<T>(), n.in_contact, {});
    }
    return turning(n, rho, w, dashpot_before, mu_r, rolling_damping, r_eff, inverse_r, root_i, dt);
  }

  /// @param angle of the twisting spring, rad; @param w angular velocity about the normal against the other body, rad/s
  template <class T>
  [[gnu::always_inline]] Slip<T, 1> twist(const NormalForce<T>& n, const T& angle, const T& w, const T& dashpot_before,
                                          T r_eff, T inverse_r, T root_i, T dt) const {
    const T x[1] = {angle}, v[1] = {w}, before[1] = {dashpot_before};
    return turning(n, x, v, before, mu_t, std::sqrt(2.0 / 7.0) * rolling_damping, r_eff, inverse_r, root_i, dt);
  }
  /// Stiffness of the rolling or twisting spring over k_n r_eff^2.
  static double turning_share(double mu) { return 2.25 * mu * mu; }

  /// Rolling terms of the bound.
  void bound(StiffnessBound& b, double r_eff, double i_roll) const {
    if (tangential != Tangential::spring) b.k_t = 0;
    if (tangential == Tangential::constant_direction) b.c_t = 0;
    const double largest = std::max(rolling == Rolling::elastic_plastic ? mu_r : 0, mu_t);
    b.k_r = turning_share(largest) * b.k_n * r_eff * r_eff;
    b.c_r = 2 * rolling_damping * std::sqrt(i_roll * b.k_r);
  }

 private:
  Cap cap() const {
    return {.together = rule == FrictionRule::spring_and_dashpot,
            .kept = rule == FrictionRule::spring_only ? 1.0 : 0.0};
  }

  template <class T, int D>
  [[gnu::always_inline]] Slip<T, D> turning(const NormalForce<T>& n, const T (&x)[D], const T (&w)[D],
                                            const T (&dashpot_before)[D], double mu, double damping, T r_eff,
                                            T inverse_r, T root_i, T dt) const {
    // k = 2.25 k_n (mu r_eff)^2 by way of its root, which the dashpot needs: what k_n alone gives is worked out once
    // for laws of constant stiffness.
    const T zero(0.0), cap = T(mu) * r_eff * n.limiting_force;
    const T root_k_n = sqrt(T(turning_share(mu)) * n.k_n);
    const T root_k = root_k_n * r_eff, k = root_k * root_k;
    const T inverse_root = select(root_k_n > zero, T(1.0) / max(root_k_n, tiny<T>()), zero) * inverse_r;
    const T c = T(2.0 * damping) * root_i * root_k;
    return stick_slip(x, w, dashpot_before, zero, dt, n.stiffness_ratio, k, inverse_root * inverse_root, c, cap, cap,
                      n.in_contact, {.together = false, .kept = rolling_damping_at_limit});
  }
};

}  // namespace subsoil::dem
