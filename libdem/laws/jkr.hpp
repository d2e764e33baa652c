#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/elastic_pair.hpp"
#include "libdem/laws/friction.hpp"

/// Adhesive elastic spheres after Johnson, Kendall and Roberts; Mindlin's tangential stiffness, Tsuji's damping.
///     F = 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3),   delta = a^2/R - sqrt(2 pi w a/E*)
///     U = 8 E* a^5/(15 R^2) - (4 E*/(3 R)) sqrt(2 pi w/E*) a^(7/2) + pi w a^2          (dU = F d delta)
///     c_n = 2 sqrt(5/6) beta(e) sqrt(2 E* a m_eff),   k_t = 8 G* a,   c_t = 2 sqrt(5/6) beta(e) sqrt(k_t m_eff)
/// Symbols: a contact radius m; R effective radius m; w work of adhesion J/m^2 (LAMMPS' and EDEM's surface energy is
/// w/2); E*, G* as in elastic_pair.hpp; e restitution without adhesion, beta as in damping_ratio.hpp.
/// Attraction begins when the surfaces touch (delta = 0: a_0^3 = 2 pi w R^2/E*, F = -(4/3) pi w R) and holds across a
/// gap. Maximum pull (3/2) pi w R, at a^3 = (9/8) pi w R^2/E*. The neck breaks, by `separation`,
///     rupture   at a_f^3 = pi w R^2/(8 E*), the end of the branch at a given distance (F = -(5/6) pi w R)
///     pull-off  at the maximum pull, as under a given load (LAMMPS)
/// Friction and rolling act while the neck holds, limited by F_e + 3 pi w R, F_e the force without damping: Thornton's
/// twice the pull-off (LAMMPS). Stiffness that changes: as in hertz_mindlin.hpp, with a in place of sqrt(R delta).
/// Energy: stored U; lost -U(a_0) when the surfaces snap together and U(a_f) when they part, in sum
/// 7.09 (w^5 R^4/E*^2)^(1/3) by rupture: restitution is 0 below the speed of that energy (impact/jkr.hpp).
/// Valid for a << R and a large Tabor number R w^2/(E*^2 z0^3).
/// Sources: Johnson, Kendall & Roberts 1971, Proc. R. Soc. A 324, 301; Thornton 1991, J. Phys. D 24, 1942; Marshall
/// 2009, J. Comput. Phys. 228, 1541.
namespace subsoil::dem {

struct Jkr : ElasticPair {
  static constexpr bool constant_stiffness = false;
  /// Memory: cube root of R while the neck holds, else 0; a at the last evaluation, m.
  static constexpr LawMembers has{
      .memory = 2, .cutoff_by_radius = true, .weaken = true, .may_gain = true, .refuse_collapse = true};
  enum class Separation { rupture, pull_off };
  double work = std::numeric_limits<double>::quiet_NaN();
  double restitution = std::numeric_limits<double>::quiet_NaN();
  Separation separation = Separation::rupture;
  Bond bond;
  Friction friction;
  // Filled by resolved(): the end of the branch, x and u of below; a_0 over R^(2/3); factor of the dashpot.
  double end_x = 0, end_u = 0, scale = 0, damping = 0;

  template <class V>
  void describe(V& v) {
    v.card("jkr",
           "Johnson-Kendall-Roberts: elastic spheres with adhesion, Mindlin tangential stiffness, Tsuji damping");
    describe_elasticity(v);
    v.quantity("work of adhesion", work, "J/m^2", "(0, inf)",
               "to part a unit of surface: twice the surface energy of LAMMPS and EDEM");
    v.quantity("restitution", restitution, "1", "(0, 1]", "coefficient of restitution without adhesion",
               "for no damping use 1");
    v.choice("separation", separation, {{"rupture", Separation::rupture}, {"pull-off", Separation::pull_off}},
             "the neck breaks at the end of its branch, or at the maximum pull");
    bond.describe(v);
    friction.describe(v);
  }

  Jkr resolved() const {
    Jkr law = *this;
    law.bond = bond.completed();
    const double y = separation == Separation::rupture ? y_rupture : std::cbrt(0.75);
    law.end_x = y * (y * y * y - 1), law.end_u = energy_at(y);
    law.scale = std::cbrt(2 * std::numbers::pi * work / E_eff);
    law.damping = 2 * std::sqrt(5.0 / 6.0) * damping_ratio(restitution);
    return law;
  }
  /// Takes a share of the attraction, while a bed settles; a trace stays, since the branch is measured by it.
  void weaken(double share) {
    work *= std::max(share, 1e-6);
    *this = resolved();
  }
  /// Longest neck of spheres up to this r_eff, m: -delta_f = -end_x a_0^2/R, which grows with the cube root.
  double cutoff(double r_eff) const { return -end_x * scale * scale * std::cbrt(r_eff); }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static Jkr example() {
    Jkr law;
    law.take_materials(1e7, 0.3, 1e7, 0.3);
    law.work = 1, law.restitution = 0.7;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  /// At the maximum pull part of the well is left unclimbed: by that convention it is given.
  bool may_gain() const { return separation == Separation::pull_off; }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a, T (&memory)[2]) const {
    const T zero(0.0), one(1.0), r = a.r_eff;
    const auto fresh = both(a.overlap > zero, zero >= memory[0]);
    if (any(fresh)) memory[0] = select(fresh, pow(r, 1.0 / 3.0), memory[0]);
    const auto wetted = memory[0] > zero;
    const T a0 = select(wetted, T(scale) * memory[0] * memory[0], r), unit = a0 * a0 / r;
    // Above the rupture, in units of the branch: x - x_f >= 0.
    const T above = max(a.overlap / unit - T(rupture_x), zero);
    const T y = branch_at(above), y3 = y * y * y, pull = T(2 * std::numbers::pi * work) * r;
    const T radius = a0 * y * y;
    const auto held = both(wetted, a.overlap >= T(end_x) * unit);
    NormalForce<T> n;
    n.in_contact = held;
    const T elastic = pull * y3 * (T(4.0 / 3.0) * y3 - T(2.0));
    n.k_n = T(2 * E_eff) * radius;
    n.k_t = T(8 * G_eff) * radius;
    n.stiffness_ratio = memory[1] / radius;
    n.tangential_compliance = select(held, one / n.k_t, zero);
    n.c_n = T(damping) * sqrt(n.k_n) * a.root_m;
    n.c_t = T(std::sqrt(4 * G_eff / E_eff)) * n.c_n;
    n.damping = select(held, n.c_n * a.rate, zero);
    n.attraction = select(held, T(2.0) * pull * y3, zero);
    n.force = select(held, elastic, zero) + n.damping;
    n.limiting_force = elastic + T(1.5) * pull;
    const T energy = pull / r * a0 * a0;
    n.stored = select(held, energy * y3 * y * (T(8.0 / 15.0) * y3 * y3 - T(4.0 / 3.0) * y3 + T(0.5)), zero);
    const T snaps = select(fresh, T(-energy_at(1)), zero), parts = select(held, zero, select(wetted, T(end_u), zero));
    n.lost = select(a.elapsed > zero, energy * (snaps + parts), zero);
    memory[0] = select(held, memory[0], zero);
    memory[1] = select(held, radius, zero);
    return n;
  }

  /// Throws std::invalid_argument where the neck would be as wide as the spheres: a_0 above r_eff.
  void refuse_collapse(double r_eff) const {
    if (scale * std::cbrt(r_eff * r_eff) < r_eff) return;
    throw std::invalid_argument(
        "at r_eff = " + std::to_string(1e3 * r_eff) +
        " mm the contact radius without load, (2 pi w R^2/E_eff)^(1/3), is above r_eff; the law "
        "holds far below: take a stiffer material or a smaller work of adhesion");
  }

  /// At the contact radius that the expected speed reaches on the branch; the tangent of F(delta) stays below 2 E* a.
  StiffnessBound bound(const WorstContact& w) const {
    const double a0 = std::cbrt(2 * std::numbers::pi * work * w.r_eff * w.r_eff / E_eff);
    const double wanted = w.m_eff * w.speed * w.speed / (4 * std::numbers::pi * work * a0 * a0) + energy_at(1);
    const double pressed = w.overlap * w.r_eff / (a0 * a0);
    const auto reaches = [&](double y) { return energy_at(y) >= wanted && y * y * y * y - y >= pressed; };
    double low = 1, high = 2;
    while (!reaches(high)) high *= 2;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      (reaches(middle) ? high : low) = middle;
    }
    const double radius = a0 * high * high;
    const double k_n = 2 * E_eff * radius, k_t = 8 * G_eff * radius;
    return {
        .k_n = k_n, .c_n = damping * std::sqrt(k_n * w.m_eff), .k_t = k_t, .c_t = damping * std::sqrt(k_t * w.m_eff)};
  }

 private:
  // The branch with y = (a/a_0)^(1/2): x = delta R/a_0^2 = y^4 - y, u = U/(2 pi w a_0^2).
  static constexpr double y_rupture = 0.629960524947436582;  ///< 4^(-1/3), where dx/dy = 0
  static constexpr double rupture_x = -0.75 * y_rupture;
  static double energy_at(double y) {
    const double y3 = y * y * y;
    return y3 * y * (8.0 / 15.0 * y3 * y3 - 4.0 / 3.0 * y3 + 0.5);
  }
  /// y on the branch from w = x - x_f: the root z >= 0 of z^2 (6 y_f^2 + 4 y_f z + z^2) = w, y = y_f + z. The guess is
  /// within 1.4e-3 of z for every w (its form is exact to first order at 0), two steps of Newton give 1e-11; written in
  /// z nothing is lost where the branch turns.
  template <class T>
  [[gnu::always_inline]] static T branch_at(const T& w) {
    constexpr double yf = y_rupture, at_zero = 0.816496580927726033;  // d(y^2)/d sqrt(w) at 0: sqrt(2/3)
    const T u = sqrt(w);
    const T rise = u * (T(at_zero) + T(0.72) * u) / (T(1.0) + T(0.722) * u);
    T z = rise / (sqrt(T(yf * yf) + rise) + T(yf));
    for (int k = 0; k < 2; ++k) {
      const T f = z * z * (T(6 * yf * yf) + z * (T(4 * yf) + z)) - w;
      const T slope = z * (T(12 * yf * yf) + z * (T(12 * yf) + T(4.0) * z));
      z = z - f / max(slope, tiny<T>());
    }
    return T(yf) + z;
  }
};

}  // namespace subsoil::dem
