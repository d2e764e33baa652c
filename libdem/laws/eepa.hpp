#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "libdem/laws/adhesive_friction.hpp"
#include "libdem/laws/bond.hpp"
#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/elastic_pair.hpp"
#include "libdem/laws/friction.hpp"

/// Edinburgh elasto-plastic adhesion (Thakur et al. 2014, Morrissey 2013), as in EDEM, PFC, Rocky and LIGGGHTS.
///     loading:                                F = -f0 + k1 delta^n
///     unloading and reloading:                F = -f0 + k2 (delta^n - delta_p^n)
///     where that is below the next:           F = -f0 - A (delta/delta_c)^chi
/// and c d delta/dt besides, while delta > 0. k1 N/m^n, left out: 4/3 E* sqrt(R), n = 3/2; k2 = k1/(1 - lambda_p);
/// lambda_p plasticity ratio; delta_p = lambda_p^(1/n) times the maximum overlap; f0 constant pull while in touch, N
/// (LIGGGHTS' pullOffForce is -f0). Loading leaves an adhesive branch of exponent chi that the unloading curve meets at
/// delta_c with the pull A = k2 (delta_p^n - delta_c^n),
///     from the surface energy w:   A = min((3/2) pi w a, k2 delta_p^n/2),  a = sqrt(2 R delta_p) the flattened patch
///     or by k_adh/k1, chi = n:     A = k_adh delta_c^n (LIGGGHTS' coefficientAdhesionStiffness with fixKc)
/// (LIGGGHTS takes for a the circle in which the two spheres cut at delta_p: 1.3 % less at delta_p = R/5.) A contact
/// that has torn to delta and is pressed again follows k2 from there, since delta_c and A have moved along the branch:
/// these two are what it remembers.
/// c = 2 beta(e) sqrt((n + 1)/(2 n)) sqrt(m_eff n k1 delta^(n-1)), for n = 1 the source's and for n = 3/2 Tsuji's: e is
/// the restitution of a contact without plasticity and adhesion; these take their share besides, without dashpot
///     e^2 = 1 - lambda_p (n = 1),   (1 - l^(5/3) - (5/2) l (1 - l^(2/3)))/(1 - l), l = lambda_p (n = 3/2).
/// LIGGGHTS takes the number k1 for a stiffness in N/m there, for any n. Tangential: k_t = ratio n k1 delta^(n-1)
/// (Mindlin's 8 G* sqrt(R delta) for n = 3/2 is ratio 4 G*/E*), on unloading as in hertz_mindlin.hpp. Friction limit
/// (adhesive_friction.hpp) without f0: A (delta/delta_c)^chi is the adhesion, F + f0 the force.
/// Energy: stored is that of the unloading curve from delta_c on, 0 there and when apart, and -f0 delta; what loading
/// and tearing lose is the spring's work over the step less what is stored of it.
/// Cost: n and chi that are whole or half up to 4.5 are products and roots, any other takes the library's pow.
/// Sources: Thakur, Morrissey, Sun, Chen, Ooi 2014, Granular Matter 16, 383; Morrissey 2013, thesis, Edinburgh.
namespace subsoil::dem {

struct Eepa {
  static constexpr bool constant_stiffness = false;
  static constexpr LawMembers has{.memory = 2, .plastic = true, .weaken = true};  ///< memory: delta_c, m; A, N
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  double n = 1.5;
  double k1 = left_out, E_eff = left_out;
  double plasticity = left_out;
  double f0 = 0;
  double w = left_out, adhesive_ratio = left_out;  ///< J/m^2; k_adh/k1
  double chi = left_out;
  double restitution = left_out;
  double stiffness_ratio = 2.0 / 7.0;
  AdhesiveLimit limit = AdhesiveLimit::force_plus_adhesion;
  Bond bond;
  Friction friction;

  template <class V>
  void describe(V& v) {
    v.card("eepa", "Edinburgh elasto-plastic adhesion: hysteretic spring of power n with an adhesive branch");
    v.exponent("n", n, "[1, 4]", "exponent of the overlap: 1 linear, 1.5 Hertz");
    v.derived("k1", k1, "N/m^(n)", "(0, inf)", "loading stiffness; left out: Hertz's 4/3 E_eff sqrt(R), for n = 1.5");
    v.derived("E_eff", E_eff, "Pa", "(0, inf)",
              "effective Young's modulus, when k1 is left out; left out: from both materials' young and poisson");
    v.quantity("plasticity ratio", plasticity, "1", "[0, 0.999]", "lambda_p = 1 - k1/k2; 0: elastic");
    v.quantity("f0", f0, "N", "[0, inf)",
               "constant pull while in touch (LIGGGHTS' pullOffForce with the sign changed)");
    v.derived("surface energy", w, "J/m^2", "[0, inf)",
              "adhesion energy of the flattened patch; left out: by the adhesive ratio");
    v.derived("adhesive ratio", adhesive_ratio, "1", "[0, inf)",
              "adhesive over loading stiffness, k_adh/k1, in place of the surface energy; for chi = n");
    v.derived("chi", chi, "1", "[1, 20]", "exponent of the adhesive branch; left out: n");
    v.quantity("restitution", restitution, "1", "(0, 1]", "of the dashpot with the spring alone",
               "for no damping use 1");
    v.quantity("stiffness ratio", stiffness_ratio, "1", "[0, inf)", "tangential over normal loading stiffness");
    dem::describe(v, limit);
    bond.describe(v);
    friction.describe(v);
  }

  bool needs_materials() const { return std::isnan(k1) && std::isnan(E_eff); }
  static constexpr const char* in_place_of_materials = "k1 or E_eff";
  /// Fills E_eff from the elastic constants of the two materials where neither it nor k1 is given.
  void take_materials(double young_1, double poisson_1, double young_2, double poisson_2) {
    if (needs_materials()) E_eff = effective_modulus(young_1, poisson_1, young_2, poisson_2);
  }

  /// Throws std::invalid_argument when the stiffness is missing or given twice for this n, or the adhesion is.
  Eepa resolved() const {
    if (std::isnan(k1) && n != 1.5)
      throw std::invalid_argument("needs k1: Hertz's stiffness from the bodies holds for n = 1.5 only");
    if (std::isnan(w) == std::isnan(adhesive_ratio))
      throw std::invalid_argument("needs either surface energy or adhesive ratio; for no adhesion adhesive ratio: 0");
    Eepa law = *this;
    law.bond = bond.completed();
    if (std::isnan(law.chi)) law.chi = n;
    if (std::isnan(w) && law.chi != n)
      throw std::invalid_argument("the adhesive ratio holds for chi = n; leave chi out, or give the surface energy");
    return law;
  }
  /// Takes a share of the constant pull, while a bed settles. The adhesion that a contact has stems from how it was
  /// loaded: taken away then, it would not come back.
  void weaken(double share) { f0 *= share; }
  double cutoff() const { return 0; }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static Eepa example() {
    Eepa law;
    law.n = 1.5, law.k1 = 3e5, law.plasticity = 0.6, law.w = 20, law.restitution = 0.7;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a, T (&memory)[2]) const {
    const T zero(0.0), half(0.5), one(1.0);
    const T load = std::isnan(k1) ? T(4.0 / 3.0 * E_eff) * sqrt(a.r_eff) : T(k1);
    const T unload = T(1 / (1 - plasticity)) * load;
    // Never zero, so that k_t stiffness_ratio is the stiffness before even when the contact has just ended.
    const T depth = max(a.overlap, zero), slope = max(power(depth, n - 1), tiny<T>()), raised = slope * depth;
    const Edge<T> old{memory[0], power(memory[0], n), memory[1]};
    const auto touches = a.overlap > zero;
    const auto loads = T(plasticity) * unload * raised >= unload * old.raised + old.pull;

    Edge<T> edge = loaded(depth, raised, unload, a.r_eff);
    edge = {select(loads, edge.overlap, old.overlap), select(loads, edge.raised, old.raised),
            select(loads, edge.pull, old.pull)};
    const T adhesion = select(edge.pull > zero, edge.pull * power(depth / max(edge.overlap, tiny<T>()), chi), zero);
    const auto tears = edge.overlap > depth;
    edge = {select(tears, depth, edge.overlap), select(tears, raised, edge.raised), select(tears, adhesion, edge.pull)};
    edge = {select(touches, edge.overlap, zero), select(touches, edge.raised, zero), select(touches, edge.pull, zero)};
    memory[0] = edge.overlap, memory[1] = edge.pull;

    NormalForce<T> out;
    out.in_contact = touches;
    const T spring = select(touches, select(loads, load * raised, edge.spring(unload, raised)), zero);
    const T stored = select(touches, edge.stored(unload, depth, raised, n), zero);
    const T earlier = max(a.overlap - a.rate * a.elapsed, zero), earlier_slope = power(earlier, n - 1);
    const T spring_then = old.spring(unload, earlier_slope * earlier);
    const T stored_then = old.stored(unload, earlier, earlier_slope * earlier, n);
    const T work = half * (spring + spring_then) * a.rate * a.elapsed;
    const T yields = select(loads, one, select(tears, one, zero)) * select(a.elapsed > zero, one, zero);
    out.lost = yields * (work - (stored - stored_then));
    out.k_n = T(n) * load * slope;
    const T root = sqrt(out.k_n) * a.root_m, damp(2 * damping_ratio(restitution) * std::sqrt((n + 1) / (2 * n)));
    out.c_n = damp * root;
    out.damping = select(touches, out.c_n * a.rate, zero);
    out.force = select(touches, spring + out.damping - T(f0), zero);
    out.stored = stored - select(touches, T(f0) * depth, zero);
    out.attraction = select(touches, T(f0) + adhesion, zero);
    out.limiting_force = limiting_force_of(limit, out.force + T(f0), adhesion);
    out.k_t = T(stiffness_ratio) * out.k_n;
    out.stiffness_ratio = n > 1 ? earlier_slope / slope : one;
    out.tangential_compliance = stiffness_ratio > 0 ? select(touches, one / max(out.k_t, tiny<T>()), zero) : zero;
    out.c_t = T(std::sqrt(stiffness_ratio)) * out.c_n;
    return out;
  }

  /// On the unloading branch, at the overlap that the expected speed reaches under loading without damping.
  StiffnessBound bound(const WorstContact& worst) const {
    const double load = std::isnan(k1) ? 4.0 / 3.0 * E_eff * std::sqrt(worst.r_eff) : k1;
    const double rest = std::pow(f0 / load, 1 / n);  // where f0 is balanced; the work up to there adds to the energy
    const double energy = 0.5 * worst.m_eff * worst.speed * worst.speed + f0 * rest;
    const double overlap = std::max(worst.overlap, rest + std::pow((n + 1) * energy / load, 1 / (n + 1)));
    const double k_n = n * load * std::pow(overlap, n - 1);
    const double damp = 2 * damping_ratio(restitution) * std::sqrt((n + 1) / (2 * n) * worst.m_eff);
    return {.k_n = k_n / (1 - plasticity),
            .c_n = damp * std::sqrt(k_n),
            .k_t = stiffness_ratio * k_n,
            .c_t = damp * std::sqrt(stiffness_ratio * k_n)};
  }

 private:
  /// Where the unloading curve meets the adhesive branch; the curve is k2 (delta^n - delta_c^n) - A.
  template <class T>
  struct Edge {
    T overlap, raised, pull;  ///< delta_c, its n-th power, A

    T spring(T unload, T raised_now) const { return unload * (raised_now - raised) - pull; }
    /// Integral of the curve from delta_c on.
    T stored(T unload, T depth, T raised_now, double n) const {
      return unload * (T(1 / (n + 1)) * (depth * raised_now - overlap * raised) - raised * (depth - overlap)) -
             pull * (depth - overlap);
    }
  };

  /// What loading to an overlap leaves.
  template <class T>
  Edge<T> loaded(T depth, T raised, T unload, T r_eff) const {
    const T residual = T(std::pow(plasticity, 1 / n)) * depth, top = T(plasticity) * unload * raised;
    if (std::isnan(w)) {
      const double left = 1 / (1 + adhesive_ratio * (1 - plasticity));
      return {T(std::pow(left, 1 / n)) * residual, T(plasticity * left) * raised, T(1 - left) * top};
    }
    const T pull = min(T(1.5 * std::numbers::pi * w) * sqrt(T(2.0) * r_eff * residual), T(0.5) * top);
    const T left = T(1.0) - pull / max(top, tiny<T>());
    return {residual * root(left), T(plasticity) * raised * left, pull};
  }

  /// x^(1/n) for x in [1/2, 1]; for n = 3/2 by Newton's steps on the cube root from its series at 1.
  template <class T>
  T root(T x) const {
    if (n == 1) return x;
    if (n == 2) return sqrt(x);
    if (n != 1.5) return pow(x, 1 / n);
    const T third(1.0 / 3.0), q = T(1.0) - x;
    T s = T(1.0) - third * q * (T(1.0) + third * q);
    for (int k = 0; k < 3; ++k) s = s - third * (s - x / (s * s));
    return s * s;
  }
};

}  // namespace subsoil::dem
