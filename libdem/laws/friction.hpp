#pragma once
#include <cmath>
#include <limits>

#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/stick_slip.hpp"

/// Tangential and rolling resistance, shared by every normal law; each an element of stick_slip.hpp.
///
/// Tangential: spring xi (m) with k_t and dashpot c_t of the law, capped by mu N_f (sticking) or mu_d N_f (slipping).
/// `tangential` takes the spring away: dashpot, F_t = min(c_t |v_t|, mu N_f) against v_t (LAMMPS linear_nohistory,
///     LIGGGHTS no_history), or constant-direction, F_t = mu_d N_f v_t/|v_t|, which jitters in a resting bed.
/// `friction rule`, what Coulomb's limit caps: spring and dashpot together; the same with the spring set back however
///     far (LAMMPS, MercuryDPM; may make energy); the spring alone, beside it the dashpot or at the limit none
///     (LIGGGHTS).
/// `changing stiffness`, what is kept where k_t changes with the overlap:
///     lossy: the force k_t xi while k_t rises, the spring xi while it falls (Thornton, Cummins, Cleary 2013; LAMMPS
///         mindlin_rescale/force); only loses energy
///     keep-spring: xi, so that F_t = k_t xi (EDEM, LIGGGHTS, LAMMPS mindlin); a rising k_t makes energy
///     keep-force: k_t xi, so that dF_t = k_t dxi (incremental Mindlin without slip); a falling k_t makes energy
///     rescale: xi while k_t rises; in proportion to k_t while it falls (LAMMPS mindlin_rescale); a rising k_t makes
///         energy
///     What is made is accumulated as a negative loss in sliding.
/// `tangential damping`: c_t of the law (each states which) or its c_n, times `tangential damping factor`, or none; or
///     c_t as a number; or by the restitution e_t of a contact that sticks, c_t = 2 beta(e_t) sqrt((2/7) m_eff k_t),
///     the slip's inertia being (2/7) m_eff for solid spheres.
/// `limiting force`, N_f: what the law states, or of its normal force F with dashpot, F_e without it and attraction A
///     |F|, max(0, F), max(0, F_e), max(0, F + A), |F + A|.
/// Rolling, elastic-plastic (Ai, Chen, Rotter, Ooi 2011, type C): the angle rho (rad) in place of xi, the spring capped
///     alone unless `rolling rule` states otherwise, k_r = 2.25 k_n (mu_r r_eff)^2 or given, cap mu_r r_eff N_f,
///     dashpot c_r = 2 eta_r sqrt(I_r k_r) or given below the cap and f c_r at it (f: `rolling damping at limit`), I_r
///     the series sum of both bodies' 7/5 m r^2.
/// Rolling, constant torque: -mu_r r_eff N_f w/|w|; it jitters in a resting bed.
/// Twist (mu_t > 0): the same element with the angle about the normal,
///     k_w = 2.25 k_n (mu_t r_eff)^2, cap mu_t r_eff N_f, dashpot 2 eta_r sqrt(I_w k_w), I_w = (2/7) I_r.
/// Moment arms of F_t about the centres: MomentArm. Symbols: v_t sliding velocity at the contact point (m/s), w
/// relative rolling velocity (rad/s), N_f N. How other programs set these: docs/reference/conventions.md.
namespace subsoil::dem {

/// Moment arm of tangential forces: to the middle of the overlap, r - delta/2; on the sphere's own surface, r; or on
/// the partner's, r - delta. Between spheres angular momentum is kept with the first alone.
enum class MomentArm { mid_overlap, radius, full_overlap };
/// At boundaries: `by_moment_arm` is the boundary's surface, r - delta, for mid_overlap, else the same.
enum class SurfaceMomentArm { by_moment_arm, mid_overlap, radius, full_overlap };
enum class SlipMomentArm { as_force, radius };
enum class Tangential { spring, dashpot, constant_direction };
enum class TangentialDamping { of_law, of_normal, none };
enum class LimitingForce { of_law, absolute, positive, elastic, plus_attraction, absolute_plus_attraction };
enum class Rolling { none, elastic_plastic, constant_torque };
enum class FrictionRule { spring_and_dashpot, spring_set_back, spring_only, spring_only_undamped };
enum class Conventions { own, lammps, liggghts, mercury, edem };

/// Shares of the overlap by which moment arms are shorter than the radius: of the force, and of the slip velocity.
struct MomentArmShares {
  double force, slip;
};

struct Friction {
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  double mu = left_out;
  double mu_d = left_out;  ///< left out: the same as mu
  Conventions conventions = Conventions::own;
  Tangential tangential = Tangential::spring;
  Changing changing = Changing::lossy;
  FrictionRule rule = FrictionRule::spring_and_dashpot;
  TangentialDamping damping = TangentialDamping::of_law;
  double damping_factor = 1, c_t = left_out, e_t = left_out;
  LimitingForce limiting = LimitingForce::of_law;
  double mu_r = 0, mu_t = 0;
  double rolling_damping = 0.3, rolling_damping_at_limit = 0;
  double k_r = left_out, c_r = left_out;
  Rolling rolling = Rolling::elastic_plastic;
  FrictionRule rolling_rule = FrictionRule::spring_only;
  MomentArm moment_arm = MomentArm::mid_overlap;
  SurfaceMomentArm surface_moment_arm = SurfaceMomentArm::by_moment_arm;
  SlipMomentArm slip_moment_arm = SlipMomentArm::as_force;

  template <class V>
  void describe(V& v);  ///< friction_keys.hpp
  /// Sets what a program does and the scenario does not state otherwise (docs/reference/conventions.md).
  void take(Conventions program);
  /// Throws std::invalid_argument for a dashpot that is given twice.
  void check() const;

  /// What most beds have. Steps that accumulate no losses are compiled for this alone; others take the longer
  /// kernel of the accumulated ones in every step. Twist is not among it: its branch costs rolling 3 to 5 % of the
  /// step.
  bool usual() const;
  /// The same when usual(), in a form that the compiler can follow.
  Friction as_usual() const {
    Friction f;
    f.mu = mu, f.mu_d = mu_sliding(), f.rolling_damping = rolling_damping;
    f.mu_r = rolling == Rolling::none ? 0 : mu_r;
    f.moment_arm = moment_arm, f.surface_moment_arm = surface_moment_arm;
    return f;
  }
  bool resists_rolling() const { return (rolling != Rolling::none && mu_r > 0) || resists_twist(); }
  bool resists_twist() const { return mu_t > 0; }
  bool remembers_slip() const { return !std::isnan(mu_d) && mu_d != mu; }
  double mu_sliding() const { return std::isnan(mu_d) ? mu : mu_d; }
  /// Between two spheres, or of one at a boundary.
  MomentArmShares shares(bool pair) const;

  /// Brings what a normal law answers to `tangential damping` and `limiting force`.
  template <class T>
  [[gnu::always_inline]] void adjust(NormalForce<T>& n, T root_m) const {
    if (!std::isnan(c_t))
      n.c_t = T(c_t);
    else if (!std::isnan(e_t))
      n.c_t = T(2 * damping_ratio(e_t) * std::sqrt(2.0 / 7.0)) * sqrt(max(n.k_t, tiny<T>())) * root_m;
    else if (damping != TangentialDamping::of_law)
      n.c_t = T(damping == TangentialDamping::none ? 0.0 : damping_factor) * n.c_n;
    else if (damping_factor != 1)
      n.c_t = T(damping_factor) * n.c_t;
    if (limiting == LimitingForce::of_law) return;
    T force = n.force;
    if (limiting == LimitingForce::elastic) force = n.force - n.damping;
    if (limiting == LimitingForce::plus_attraction || limiting == LimitingForce::absolute_plus_attraction)
      force = n.force + n.attraction;
    const T positive = max(force, T(0.0));
    n.limiting_force = select(n.in_contact, positive, T(0.0));
    if (limiting == LimitingForce::absolute || limiting == LimitingForce::absolute_plus_attraction)
      n.limiting_force = select(n.in_contact, max(force, -force), T(0.0));
  }

  /// `Usual`: usual() is known to hold, so that what it excludes costs nothing.
  template <bool Usual = false, class T>
  [[gnu::always_inline]] Slip<T> slide(const NormalForce<T>& n, const T (&xi)[3], const T (&v_t)[3],
                                       const T (&dashpot_before)[3], T slipping_before, T dt) const {
    // Without a limit there is nothing to load a spring to: no slip enters. Invariant in the loop over contacts, and
    // without a branch, so that GCC takes it out of there.
    const double mu_kinetic = Usual ? mu_d : mu_sliding();
    const T slip_time = T(static_cast<double>((mu > 0) | (mu_kinetic > 0))) * dt;
    const T limit = T(mu) * n.limiting_force, kinetic = T(mu_kinetic) * n.limiting_force;
    if (Usual || tangential == Tangential::spring)
      return stick_slip(xi, v_t, dashpot_before, slipping_before, slip_time, n.stiffness_ratio, n.k_t,
                        n.tangential_compliance, n.c_t, limit, kinetic, n.in_contact, Usual ? Cap{} : cap(rule, 1),
                        Usual ? Changing::lossy : changing);
    const T zero(0.0), v2 = v_t[0] * v_t[0] + v_t[1] * v_t[1] + v_t[2] * v_t[2];
    const T c = tangential == Tangential::dashpot ? n.c_t : kinetic / max(sqrt(v2), T(1e-12));
    Slip<T> s = stick_slip(xi, v_t, dashpot_before, slipping_before, slip_time, T(1.0), zero, zero, c, limit, kinetic,
                           n.in_contact, {});
    for (T& x : s.x) x = zero;
    return s;
  }

  /// @param inverse_r 1/r_eff, 1/m; @param root_i square root of the series sum of both bodies' 7/5 m r^2, kg^1/2 m
  template <bool Usual = false, class T>
  [[gnu::always_inline]] Slip<T> roll(const NormalForce<T>& n, const T (&rho)[3], const T (&w)[3],
                                      const T (&dashpot_before)[3], T r_eff, T inverse_r, T root_i, T dt) const {
    if (rolling == Rolling::none || !(mu_r > 0)) return {};  // twist alone
    const T arm = T(mu_r) * r_eff, most = arm * n.limiting_force, zero(0.0);
    if (!Usual && rolling == Rolling::constant_torque) {
      // A dashpot whose coefficient makes the torque cap w/|w|: no spring, no state.
      const T speed = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
      const T c = most / max(speed, T(1e-12));
      return stick_slip(rho, w, dashpot_before, zero, dt, T(1.0), zero, zero, c, T(2.0) * most + tiny<T>(),
                        T(2.0) * most + tiny<T>(), n.in_contact, {});
    }
    if (Usual || (std::isnan(k_r) && std::isnan(c_r)))
      return turning(n, rho, w, dashpot_before, mu_r, rolling_damping, r_eff, inverse_r, root_i, dt,
                     Usual ? cap(FrictionRule::spring_only, 0) : cap(rolling_rule, rolling_damping_at_limit));
    const T k = rolling_stiffness(n, r_eff), soft = T(1.0) / max(k, tiny<T>());
    const T c = std::isnan(c_r) ? T(2.0 * rolling_damping) * root_i * sqrt(k) : T(c_r);
    return stick_slip(rho, w, dashpot_before, zero, dt, std::isnan(k_r) ? n.stiffness_ratio : T(1.0), k, soft, c, most,
                      most, n.in_contact, cap(rolling_rule, rolling_damping_at_limit));
  }

  /// @param angle of the twisting spring, rad; @param w angular velocity about the normal against the other body, rad/s
  template <bool Usual = false, class T>
  [[gnu::always_inline]] Slip<T, 1> twist(const NormalForce<T>& n, const T& angle, const T& w, const T& dashpot_before,
                                          T r_eff, T inverse_r, T root_i, T dt) const {
    const T x[1] = {angle}, v[1] = {w}, before[1] = {dashpot_before};
    return turning(n, x, v, before, mu_t, std::sqrt(2.0 / 7.0) * rolling_damping, r_eff, inverse_r, root_i, dt,
                   cap(FrictionRule::spring_only, Usual ? 0 : rolling_damping_at_limit));
  }
  /// Stiffness of the rolling or twisting spring over k_n r_eff^2.
  static double turning_share(double mu) { return 2.25 * mu * mu; }
  /// Of the rolling spring, N m/rad; 0 where there is none.
  template <class T>
  [[gnu::always_inline]] T rolling_stiffness(const NormalForce<T>& n, T r_eff) const {
    if (rolling != Rolling::elastic_plastic) return T(0.0);
    return std::isnan(k_r) ? T(turning_share(mu_r)) * n.k_n * r_eff * r_eff : T(k_r);
  }

  /// What the law's bound becomes; rolling terms beside.
  void bound(StiffnessBound& b, double m_eff, double r_eff, double i_roll) const;

 private:
  /// @param kept of the dashpot beside a spring that is capped alone
  static Cap cap(FrictionRule rule, double kept) {
    return {.together = rule == FrictionRule::spring_and_dashpot || rule == FrictionRule::spring_set_back,
            .kept = rule == FrictionRule::spring_only ? kept : 0,
            .set_back = rule == FrictionRule::spring_set_back};
  }

  template <class T, int D>
  [[gnu::always_inline]] Slip<T, D> turning(const NormalForce<T>& n, const T (&x)[D], const T (&w)[D],
                                            const T (&dashpot_before)[D], double mu, double ratio, T r_eff, T inverse_r,
                                            T root_i, T dt, Cap cap) const {
    // k = 2.25 k_n (mu r_eff)^2 by way of its root, which the dashpot needs: what k_n alone gives is worked out once
    // for laws of constant stiffness.
    const T zero(0.0), most = T(mu) * r_eff * n.limiting_force;
    const T root_k_n = sqrt(T(turning_share(mu)) * n.k_n);
    const T root_k = root_k_n * r_eff, k = root_k * root_k;
    const T inverse_root = select(root_k_n > zero, T(1.0) / max(root_k_n, tiny<T>()), zero) * inverse_r;
    const T c = T(2.0 * ratio) * root_i * root_k, soft = inverse_root * inverse_root;
    return stick_slip(x, w, dashpot_before, zero, dt, n.stiffness_ratio, k, soft, c, most, most, n.in_contact, cap);
  }
};

}  // namespace subsoil::dem

#include "libdem/laws/friction_keys.hpp"
