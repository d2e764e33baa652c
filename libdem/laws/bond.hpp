#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "libdem/laws/bond_memory.hpp"
#include "libdem/laws/contact.hpp"

/// Parallel bond: a short elastic beam of cement between two spheres, which acts beside their contact.
///     R = lambda min(r_i, r_j),  A = pi R^2,  I = pi R^4/4,  J = pi R^4/2
///     k_n = E/(r_i + r_j),  k_s = k_n/ratio                               stiffness per area, N/m^3
///     F_n = k_n A (delta - delta_0)     along n, compression positive
///     F_s = k_s A s                     across n, against the slip s of the contact point
///     M_b = k_n I phi,  M_t = k_s J theta     against relative rolling phi and twist theta
/// It breaks, for good, as soon as
///     sigma = -F_n/A + beta |M_b| R/I >= sigma_c                          in tension, or
///     tau = |F_s|/A + beta |M_t| R/J >= tau_c + (F_n/A) tan(phi_c)        in shear
/// Symbols: E Young's modulus Pa; delta_0 overlap when the bond formed m, at which it is free of load; s, phi, theta
/// sums since then of v_t dt (m), w dt and w_n dt (rad); lambda radius multiplier, beta moment contribution; sigma_c,
/// tau_c tensile and shear strength Pa, phi_c friction angle of the bond.
/// Dashpots 2 zeta sqrt(m k) beside each of the four springs; strengths judge the springs alone. s and phi turn with
/// the pair: with n, and about n by the mean angular velocity of both spheres.
/// With a yield stress sigma_y bending is elastic and perfectly plastic:
///     |M_b| <= M_p = (4/3) R^3 sigma_y      the plastic moment of a round section, all of which yields
/// What phi exceeds by is no longer stored: permanent curvature. M_p and not the moment pi R^3/4 sigma_y at which the
/// outer fibre begins to yield, since the plateau decides how far a section folds.
/// Energy: each spring's k x^2/2; what a bond holds when it breaks is lost in breaking, plastic work in yielding.
/// A cutting edge at an angle alpha to the row breaks a bond of kind `fibre` that it presses on with a force across
///     F >= sigma_e A/sin(alpha)      of the section that it would cut, sigma_e the cutting strength Pa
///     (contacts/bonds.hpp)
/// A bond of kind `fibre` comes with its spheres, neighbours in a chain, and replaces their contact while it holds;
/// `parallel` forms between all that touch, and acts beside the contact.
/// A row of equal spheres is a beam of modulus E, section A, I and shear stiffness E A/ratio (docs/theory).
/// Source: Potyondy & Cundall 2004, Int. J. Rock Mech. Min. Sci. 41, 1329; beta: Potyondy 2011; tau_c with a friction
/// angle: PFC. Beside a parallel bond the contact acts with friction and rolling of its own, as there. M_p: any
/// textbook of limit analysis, plastic section modulus (2R)^3/6.
namespace subsoil::dem {

/// A pair as its bond sees it.
template <class T>
struct BondMotion {
  T n[3], n_mid[3];        ///< at the end of the step, in its middle
  T overlap, v_n, v_t[3];  ///< v of i against j at the contact point
  T w[3], twist;           ///< rolling velocity and angular velocity of i against j about n, rad/s
  T w_n;                   ///< mean angular velocity of both about n, rad/s
  T smaller, sum;          ///< radius of the smaller sphere, sum of both, m
  T root_m, root_i;        ///< square roots of the effective mass and of the series of 2/5 m r^2
  T dt;
};

/// What a bond gives. Shear force, bending and twisting moment on i are against these.
template <class T>
struct BondForce {
  T normal;  ///< on i along n, compression positive
  T shear[3], bending[3], twisting;
  T stored, damped, yielded;  ///< J
  Mask<T> broke;              ///< in this step
};

struct Bond {
  enum class Kind { none, parallel, fibre };
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  static constexpr double pi = std::numbers::pi;
  Kind kind = Kind::none;
  double modulus = left_out;
  double ratio = 2.5;
  double radius = 1;
  double tensile = left_out, shear = left_out;
  double yield = left_out;
  double cutting = left_out;
  double friction_angle = 0;
  double moment_share = 1;
  double damping = 0;
  double gap = 0;
  double time = 0;
  // Filled by completed().
  double tan_friction = 0;
  double plastic = 0;  ///< outer-fibre stress of the elastic section at M_p, Pa; infinite without a yield stress

  template <class V>
  void describe(V& v) {
    v.choice("bond", kind, {{"none", Kind::none}, {"parallel", Kind::parallel}, {"fibre", Kind::fibre}},
             "parallel: cement between spheres, beside the contact (Potyondy & Cundall 2004); fibre: the same beam in "
             "place of the contact, between neighbours of one of `soil.bed.fibres`");
    v.derived("bond modulus", modulus, "Pa", "(0, inf)", "Young's modulus of the bond: k_n = E/(r_i + r_j) per area");
    v.quantity("bond stiffness ratio", ratio, "1", "(0, inf)",
               "normal over shear stiffness of the bond, E/G of a beam: 2.5 at Poisson's ratio 1/4");
    v.quantity("bond radius", radius, "1", "(0, inf)", "radius of the bond over that of the smaller sphere");
    v.derived("bond tensile strength", tensile, "Pa", "(0, inf)", "normal stress at which the bond breaks");
    v.derived("bond shear strength", shear, "Pa", "(0, inf)",
              "shear stress at which the bond breaks, without normal stress");
    v.derived("bond yield stress", yield, "Pa", "(0, inf)",
              "at which bending becomes plastic: the moment stays at 4/3 R^3 times it; left out: elastic");
    v.derived("bond cutting strength", cutting, "Pa", "(0, inf)",
              "of bond: fibre: force over the section at which one of the `cutting edges` of a surface cuts it; left "
              "out: none does");
    v.quantity("bond friction angle", friction_angle, "rad", "[0, 1.57)",
               "by which compression raises the shear strength of the bond, and tension lowers it");
    v.quantity("bond moment share", moment_share, "1", "[0, 1]",
               "share of the moments' stresses that counts for breaking");
    v.quantity("bond damping", damping, "1", "[0, 1]", "damping ratio of the bond's springs");
    v.quantity("bond gap", gap, "m", "[0, inf)", "largest gap between spheres that are bonded");
    v.quantity("bond time", time, "s", "[0, inf)",
               "when bonds form, once: 0 at the start of the run, after settling; `subsoil test`: when the specimen is "
               "ready");
  }

  bool acts() const { return kind != Kind::none; }
  /// Bonded spheres do not touch: they are parts of one body.
  bool replaces_contact() const { return kind == Kind::fibre; }

  /// With what the sweep needs filled in. Throws std::invalid_argument when a quantity is missing or of no use.
  Bond completed() const {
    const struct {
      const char* name;
      double value;
    } quantities[] = {{"bond modulus", modulus}, {"bond tensile strength", tensile}, {"bond shear strength", shear}};
    for (const auto& q : quantities) {
      if (acts() && std::isnan(q.value))
        throw std::invalid_argument("bond: " + std::string(word()) + " needs `" + std::string(q.name) + "`");
      if (!acts()) refuse_without_bond(q.name, q.value);
    }
    if (!acts()) refuse_without_bond("bond yield stress", yield), refuse_without_bond("bond cutting strength", cutting);
    if (kind == Kind::parallel && !std::isnan(cutting))
      throw std::invalid_argument(
          "`bond cutting strength` has no effect on bond: parallel, which no edge cuts; leave it out, or take bond: "
          "fibre");
    if (kind == Kind::fibre && gap > 0)
      throw std::invalid_argument(
          "`bond gap` has no effect on bond: fibre, whose spheres come bonded; leave it out, or take bond: parallel");
    if (kind == Kind::fibre && time > 0)
      throw std::invalid_argument(
          "`bond time` has no effect on bond: fibre, whose spheres come bonded; leave it out, or take bond: parallel");
    Bond b = *this;
    b.tan_friction = std::tan(friction_angle);
    b.plastic = std::isnan(yield) ? std::numeric_limits<double>::infinity() : 16 / (3 * pi) * yield;
    return b;
  }

  /// Largest gap of a pair that is still bonded: where it formed and the stretch that breaks it. The margin covers
  /// single precision.
  double cutoff(double largest_radius) const { return gap + 2 * largest_radius * tensile / modulus * (1 + 1e-5); }

  /// Force of an edge across the row that cuts the bond between spheres of which this is the smaller radius, N; NaN:
  /// none does.
  double cutting_force(double smaller) const { return cutting * pi * radius * radius * smaller * smaller; }

  /// One step of a pair; lanes without a bond give nothing and stay so.
  template <class T>
  [[gnu::always_inline]] BondForce<T> act(const BondMotion<T>& a, BondMemory<T>& b) const {
    const T zero(0.0), one(1.0), half(0.5);
    const Section<T> k = section(a.smaller, a.sum);
    const auto intact = b.state > half;
    advance(a, a.v_t, b.shear, intact);
    advance(a, a.w, b.bend, intact);
    b.twist = select(intact, b.twist + a.twist * a.dt, zero);
    const T yielded = plastic < std::numeric_limits<double>::infinity() ? bend_plastically(a, k, b.bend) : zero;
    const T stretch = b.reference - a.overlap;
    const T shear2 = dot(b.shear, b.shear), bend2 = dot(b.bend, b.bend);
    const T arm = T(moment_share) * k.radius;
    const T sigma = k.k_n * (stretch + arm * sqrt(bend2));
    const T tau = k.k_s * (sqrt(shear2) + arm * max(b.twist, -b.twist));
    const T most = T(shear) - T(tan_friction) * k.k_n * stretch;
    b.state = select(intact,
                     select(sigma >= T(tensile), T(kBrokeInTension),
                            select(tau >= most, T(kBrokeInShear), select(b.state > T(1.1), T(kBrokeByEdge), one))),
                     zero);
    const auto broke = b.state > T(1.5);
    const auto holds = both(intact, T(1.5) > b.state);
    BondForce<T> out;
    out.broke = broke;
    out.normal = select(holds, -k.normal * stretch, zero);
    out.twisting = select(holds, k.twisting * b.twist, zero);
    for (int d = 0; d < 3; ++d) {
      out.shear[d] = select(holds, k.shear * b.shear[d], zero);
      out.bending[d] = select(holds, k.bending * b.bend[d], zero);
    }
    out.stored = select(
        holds,
        half * (k.normal * stretch * stretch + k.shear * shear2 + k.bending * bend2 + k.twisting * b.twist * b.twist),
        zero);
    b.reference = select(holds, b.reference, zero);
    if (any(broke)) b.released = select(broke, energy_held(a, b, k, stretch), zero);
    damp(a, k, holds, b, out);
    out.yielded = select(intact, yielded, zero);
    return out;
  }

  /// Stiffness and damping that a bond adds, at its stiffest between two of the smaller spheres; `i_turn` the series of
  /// both spheres' 2/5 m r^2. k_r is what bending about two axes and twist about the third come to in
  /// stability.hpp's count.
  StiffnessBound bound(const WorstContact& w, double i_turn) const {
    const Section<double> k = section(w.r_min, 2 * w.r_min);
    const auto dashpot = [&](double inertia, double stiffness) { return 2 * damping * std::sqrt(inertia * stiffness); };
    const double c_b = dashpot(i_turn, k.bending), c_w = dashpot(i_turn, k.twisting);
    return {.k_n = k.normal,
            .c_n = dashpot(w.m_eff, k.normal),
            .k_t = k.shear,
            .c_t = dashpot(w.m_eff, k.shear),
            .k_r = std::max(k.bending + 0.5 * k.twisting, k.twisting),
            .c_r = std::max(c_b + 0.5 * c_w, c_w)};
  }

 private:
  const char* word() const { return kind == Kind::fibre ? "fibre" : "parallel"; }
  static void refuse_without_bond(const char* name, double value) {
    if (!std::isnan(value))
      throw std::invalid_argument("`" + std::string(name) +
                                  "` belongs to bond: parallel, which here is none; leave it out, or change the word");
  }

  /// Stiffness per area, N/m^3, and of the four springs, N/m and N m.
  template <class T>
  struct Section {
    T radius, k_n, k_s, normal, shear, bending, twisting;
  };
  template <class T>
  [[gnu::always_inline]] Section<T> section(T smaller, T sum) const {
    Section<T> k;
    k.radius = T(radius) * smaller;
    const T r2 = k.radius * k.radius;
    k.k_n = T(modulus) / sum;
    k.k_s = T(1 / ratio) * k.k_n;
    k.normal = T(pi) * r2 * k.k_n, k.shear = T(pi) * r2 * k.k_s;
    k.bending = T(0.25) * r2 * k.normal, k.twisting = T(0.5) * r2 * k.shear;
    return k;
  }

  template <class T>
  [[gnu::always_inline]] static T dot(const T (&a)[3], const T (&b)[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }

  /// What a bond held that breaks in this step, J. Its force acted at the start of the step and no more at the end, so
  /// that by (24) of docs/theory half of what it takes to bring it there from the middle was never done.
  template <class T>
  [[gnu::always_inline]] static T energy_held(const BondMotion<T>& a, const BondMemory<T>& b, const Section<T>& k,
                                              T stretch) {
    const T half_dt = T(0.5) * a.dt, x = stretch, y = b.twist;
    T energy = k.normal * x * (T(0.5) * x - half_dt * a.v_n) + k.twisting * y * (T(0.5) * y - half_dt * a.twist);
    for (int d = 0; d < 3; ++d) {
      const T s = b.shear[d], phi = b.bend[d];
      energy = energy + k.shear * s * (T(0.5) * s - half_dt * a.v_t[d]) +
               k.bending * phi * (T(0.5) * phi - half_dt * a.w[d]);
    }
    return energy;
  }

  /// Turns a spring with the pair and adds what this step slips or rolls. Its length is kept exactly, which that of a
  /// friction spring need not be: a bond lives for the whole run, and a clod may turn over many times.
  template <class T>
  [[gnu::always_inline]] static void advance(const BondMotion<T>& a, const T (&rate)[3], T (&x)[3], Mask<T> intact) {
    const T along = dot(x, a.n), length2 = dot(x, x), angle = a.w_n * a.dt;
    T flat[3], turned[3];
    for (int d = 0; d < 3; ++d) flat[d] = x[d] - along * a.n_mid[d];
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      turned[d] = flat[d] + angle * (a.n[e] * flat[f] - a.n[f] * flat[e]);
    }
    const T now2 = dot(turned, turned);
    const T keep = select(now2 > tiny<T>(), sqrt(length2 / max(now2, tiny<T>())), T(1.0));
    for (int d = 0; d < 3; ++d) x[d] = select(intact, keep * turned[d] + rate[d] * a.dt, T(0.0));
  }

  /// Cuts the angle back to that of the plastic moment, along itself. Returns the plastic work, J: by the trapezoid of
  /// the moments at both ends of the step, as the work of the spheres and the stored energy are summed.
  template <class T>
  [[gnu::always_inline]] T bend_plastically(const BondMotion<T>& a, const Section<T>& k, T (&bend)[3]) const {
    const T one(1.0), limit = T(plastic) / (k.k_n * k.radius), length2 = dot(bend, bend);
    const auto yields = length2 > limit * limit;
    const T keep = select(yields, limit / sqrt(select(yields, length2, one)), one);
    const T work = T(0.5) * k.bending * (one - keep) * ((one + keep) * length2 - a.dt * dot(bend, a.w));
    for (int d = 0; d < 3; ++d) bend[d] = keep * bend[d];
    return work;
  }

  template <class T>
  [[gnu::always_inline]] void damp(const BondMotion<T>& a, const Section<T>& k, Mask<T> holds, BondMemory<T>& b,
                                   BondForce<T>& out) const {
    const T zero(0.0), twice(2 * damping);
    const T root_n = twice * sqrt(k.normal);
    const T c_n = root_n * a.root_m, c_t = T(std::sqrt(1 / ratio)) * c_n;
    const T c_b = T(0.5) * k.radius * root_n * a.root_i, c_w = T(std::sqrt(2 / ratio)) * c_b;
    T power = -(b.dash_n * a.v_n) + b.dash_w * a.twist;
    for (int d = 0; d < 3; ++d) power = power + b.dash_t[d] * a.v_t[d] + b.dash_r[d] * a.w[d];
    b.dash_n = select(holds, -c_n * a.v_n, zero), b.dash_w = select(holds, c_w * a.twist, zero);
    for (int d = 0; d < 3; ++d) {
      b.dash_t[d] = select(holds, c_t * a.v_t[d], zero), b.dash_r[d] = select(holds, c_b * a.w[d], zero);
      power = power + b.dash_t[d] * a.v_t[d] + b.dash_r[d] * a.w[d];
      out.shear[d] = out.shear[d] + b.dash_t[d];
      out.bending[d] = out.bending[d] + b.dash_r[d];
    }
    power = power - b.dash_n * a.v_n + b.dash_w * a.twist;
    out.normal = out.normal + b.dash_n;
    out.twisting = out.twisting + b.dash_w;
    out.damped = T(0.5) * power * a.dt;
  }
};

}  // namespace subsoil::dem
