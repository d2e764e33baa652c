#pragma once
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "libdem/laws/contact.hpp"

/// Attraction that adds to a normal law: F = F_normal - F_c, F_c >= 0.
///     linear:         F_c = k A(delta), delta > 0
///                     A by `contact area`: hertz pi R delta, sjkr2 4 pi R delta, or lens, with c = 1/(r1 + r2),
///                     A = pi delta (4 R - 2 delta + c delta^2) (2 - c delta)/(4 (1 - c delta)^2)
///     dmt:            F_c = 2 pi w R, delta > 0
///     linear-adhesion: F_c = f, delta > 0, and max(0, f - k_a S) across the gap S = -delta
///     liquid-bridge:  F_c = 4 pi R gamma cos(theta) (1 - S/sqrt(S^2 + V/(pi R))), S = max(0, -delta) < S_r,
///                     S_r = (1 + theta/2) V^(1/3)
/// Symbols: R = r1 r2/(r1 + r2) m (the sphere's radius at a boundary); k cohesion energy density J/m^3; w work of
/// adhesion J/m^2; f maximum pull N, k_a its fall with the gap N/m; gamma surface tension N/m, theta contact angle, V
/// volume of one bridge m^3, S gap, S_r the gap at which a bridge ruptures, m. `lens` is the circle in which the two
/// spheres cut each other (LIGGGHTS sjkr), of equal ones 2 pi R delta - pi delta^2/4, at a boundary (c = 0) pi delta (2
/// R - delta); `hertz` the circle of Hertz's contact (EDEM; Ucgul 2014), `sjkr2` that of LIGGGHTS. Linear adhesion
/// (MercuryDPM's irreversible) and a bridge begin when the surfaces touch, and end at the gap f/k_a, S_r;
/// `at-rupture-distance` lets them begin there too (reversible). The bridge's meniscus is a cylinder: V/R^3 below 0.01.
/// No viscous force. Friction and rolling are limited by `friction limit`:
///     pressing-force  max(0, F + F_c), what presses the surfaces together (default)
///     net-force       |F| (LIGGGHTS)
///     thornton        max(0, F + 2 F_c) (LAMMPS, dmt)
/// Energy: stored is that of the normal law less the work that separation takes; what one that begins on contact
/// sets free, U(S_r) - U(0), is lost. The other two lose nothing: F_c is the same on the way in and out.
/// Sources: linear, Kloss & Goniva (LIGGGHTS), Ucgul, Fielke & Saunders 2014; dmt, Derjaguin, Muller & Toporov 1975;
/// bridge, Rabinovich, Esayanur & Moudgil 2005, Langmuir 21, 10992, in the form of Lambert et al. 2008, J. Adhes. Sci.
/// Technol. 22, 597, eq. (65); S_r, Lian, Thornton & Adams 1993.
namespace subsoil::dem {

struct Cohesion {
  enum class Kind { none, linear, dmt, linear_adhesion, liquid_bridge };
  enum class Area { lens, hertz, sjkr2 };
  enum class Forms { on_contact, at_rupture_distance };
  enum class FrictionLimit { pressing_force, net_force, thornton };
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  static constexpr double pi = std::numbers::pi;
  Kind kind = Kind::none;
  double density = left_out;
  Area area = Area::lens;
  double work = left_out;
  double force = left_out, stiffness = left_out;
  double tension = left_out, angle = left_out, volume = left_out;
  Forms forms = Forms::on_contact;
  FrictionLimit limit = FrictionLimit::pressing_force;
  // Filled by completed(): attraction over r_eff, and over r_eff and overlap (of a lens where it begins); gap of
  // rupture, m.
  double strength = 0, slope = 0, end = 0;

  template <class V>
  void describe(V& v) {
    v.choice(
        "cohesion", kind,
        {{"none", Kind::none},
         {"linear", Kind::linear},
         {"dmt", Kind::dmt},
         {"linear-adhesion", Kind::linear_adhesion},
         {"liquid-bridge", Kind::liquid_bridge}},
        "attraction besides: over the contact area, constant while touching (DMT), constant while touching and falling "
        "linearly across a gap (MercuryDPM), or by a bridge of liquid");
    v.derived("cohesion energy density", density, "J/m^3", "(0, inf)", "attraction per contact area; linear cohesion");
    v.choice("contact area", area, {{"lens", Area::lens}, {"hertz", Area::hertz}, {"sjkr2", Area::sjkr2}},
             "linear cohesion: the circle in which the bodies cut each other (2 pi R delta and less), Hertz's (pi R "
             "delta), or "
             "LIGGGHTS sjkr2's 4 pi R delta");
    v.derived("work of adhesion", work, "J/m^2", "(0, inf)", "to part a unit of surface; dmt (w = 2 gamma of LAMMPS)");
    v.derived("adhesion force", force, "N", "(0, inf)", "pull while touching; linear adhesion");
    v.derived("adhesion stiffness", stiffness, "N/m", "(0, inf)",
              "by which the pull falls with the gap; linear adhesion");
    v.derived("surface tension", tension, "N/m", "(0, inf)", "of the liquid; liquid bridge");
    v.derived("contact angle", angle, "rad", "[0, 1.57]", "of the liquid on the solid; liquid bridge");
    v.derived("liquid volume", volume, "m^3", "(0, inf)", "of one bridge; valid to 0.01 r_eff^3");
    v.choice("bridge forms", forms,
             {{"on-contact", Forms::on_contact}, {"at-rupture-distance", Forms::at_rupture_distance}},
             "liquid bridge and linear adhesion begin when the surfaces touch (irreversible), or as soon as they are "
             "near enough for it to hold (reversible)");
    v.choice("friction limit", limit,
             {{"pressing-force", FrictionLimit::pressing_force},
              {"net-force", FrictionLimit::net_force},
              {"thornton", FrictionLimit::thornton}},
             "cohesion: friction and rolling are limited by the force without attraction, by the net force, or by the "
             "net force and twice the attraction");
  }

  /// With what the sweep needs filled in. Throws std::invalid_argument when the kind lacks a quantity of its own or is
  /// given another's.
  Cohesion completed() const {
    check();
    Cohesion c = *this;
    if (kind == Kind::linear) {
      c.slope = density * pi * (area == Area::hertz ? 1 : area == Area::lens ? 2 : 4);
    } else if (kind == Kind::dmt) {
      c.strength = 2 * pi * work;
    } else if (kind == Kind::linear_adhesion) {
      c.end = force / stiffness;
    } else if (kind == Kind::liquid_bridge) {
      c.strength = 4 * pi * tension * std::cos(angle);
      c.end = (1 + 0.5 * angle) * std::cbrt(volume);
    }
    return c;
  }

  /// Takes a share of the attraction, while a bed settles.
  void weaken(double share) {
    density *= share, work *= share, force *= share, tension *= share;  // those left out are NaN and stay so
    *this = completed();
  }

  bool acts() const { return kind != Kind::none; }
  /// Gap at which a bridge ruptures or linear adhesion ends, m; elsewhere attraction ends with the contact.
  double cutoff() const { return end; }

  /// Adds the attraction to what the normal law gives. @param bridge the contact's memory, 1 once wetted
  template <class T>
  [[gnu::always_inline]] void add(const Approach<T>& a, NormalForce<T>& n, T& bridge) const {
    const T zero(0.0);
    const T depth = max(a.overlap, zero);
    T pull = zero, stored = zero;
    if (kind == Kind::linear) {
      area == Area::lens ? lens(a, depth, pull, stored) : circle(a, depth, pull, stored);
    } else if (kind == Kind::dmt) {
      const T constant = T(strength) * a.r_eff;
      pull = select(n.in_contact, constant, zero);
      stored = constant * depth;
    } else if (kind == Kind::linear_adhesion) {
      falling(a, n, bridge, pull, stored);
    } else if (kind == Kind::liquid_bridge) {
      capillary(a, n, bridge, pull, stored);
    }
    n.attraction = n.attraction + pull;
    n.force = n.force - pull;
    n.stored = n.stored - stored;
    if (limit == FrictionLimit::net_force) n.limiting_force = select(n.in_contact, max(n.force, -n.force), zero);
    if (limit == FrictionLimit::thornton)
      n.limiting_force = select(n.in_contact, max(zero, n.force + T(2.0) * pull), zero);
  }

  /// Steepest change of the attraction with the distance, N/m.
  double steepest(const WorstContact& w) const {
    if (kind == Kind::linear_adhesion) return stiffness;
    if (kind == Kind::liquid_bridge) return strength * w.r_eff * std::sqrt(pi * w.r_eff / volume);
    return slope * w.r_eff;
  }

  /// Throws std::invalid_argument as completed() does.
  void check() const {
    const struct {
      const char* name;
      double value;
      Kind user;
    } quantities[] = {
        {"cohesion energy density", density, Kind::linear}, {"work of adhesion", work, Kind::dmt},
        {"adhesion force", force, Kind::linear_adhesion},   {"adhesion stiffness", stiffness, Kind::linear_adhesion},
        {"surface tension", tension, Kind::liquid_bridge},  {"contact angle", angle, Kind::liquid_bridge},
        {"liquid volume", volume, Kind::liquid_bridge}};
    for (const auto& q : quantities) {
      const bool given = !std::isnan(q.value);
      if (q.user == kind && !given) throw std::invalid_argument("cohesion: " + word(kind) + " needs `" + q.name + "`");
      if (q.user != kind && given)
        throw std::invalid_argument("`" + std::string(q.name) + "` belongs to cohesion: " + word(q.user) +
                                    ", which here is " + word(kind) + "; leave it out, or change the word");
    }
  }

 private:
  template <class T>
  [[gnu::always_inline]] void circle(const Approach<T>& a, T depth, T& pull, T& stored) const {
    pull = T(slope) * a.r_eff * depth;
    stored = T(0.5) * pull * depth;
  }
  /// Integral of A: pi delta^2 (12 R - 4 delta + c delta^2)/(12 (1 - c delta)). Written in c = 1/(r1 + r2) both hold at
  /// a boundary too, and subtract nothing that is nearly equal.
  template <class T>
  [[gnu::always_inline]] void lens(const Approach<T>& a, T depth, T& pull, T& stored) const {
    const T apart = T(1.0) - a.per_sum * depth, inverse = T(1.0) / apart;  // centres' distance over r1 + r2
    const T bend = a.per_sum * depth * depth, share = T(density * pi) * depth * inverse;
    pull = T(0.25) * share * (T(4.0) * a.r_eff - T(2.0) * depth + bend) * (T(1.0) + apart) * inverse;
    stored = T(1.0 / 12.0) * share * depth * (T(12.0) * a.r_eff - T(4.0) * depth + bend);
  }

  static std::string word(Kind k) {
    constexpr const char* words[] = {"none", "linear", "dmt", "linear-adhesion", "liquid-bridge"};
    return words[static_cast<int>(k)];
  }

  /// Whether the attraction holds: once the surfaces have touched, or always, up to the gap of its end; what a touch
  /// sets free is lost. @param free at the first touch, J
  template <class T>
  [[gnu::always_inline]] Mask<T> holds(const Approach<T>& a, NormalForce<T>& n, T& bridge, T gap, T free) const {
    const T zero(0.0), one(1.0);
    const auto touches = a.overlap > zero;
    const auto fresh = both(both(touches, zero >= bridge), a.elapsed > zero);
    if (forms == Forms::on_contact) {
      n.lost = n.lost + select(fresh, free, zero);
      bridge = select(touches, one, bridge);
    } else {
      bridge = one;
    }
    bridge = select(T(end) > gap, bridge, zero);
    return bridge > zero;
  }

  template <class T>
  [[gnu::always_inline]] void falling(const Approach<T>& a, NormalForce<T>& n, T& bridge, T& pull, T& stored) const {
    const T zero(0.0), gap = max(-a.overlap, zero), left = T(end) - gap;
    const auto held = holds(a, n, bridge, gap, T(0.5 * force * end));
    pull = select(held, T(stiffness) * left, zero);
    stored = select(held, T(force) * max(a.overlap, zero) + T(0.5 * stiffness) * left * left, zero);
  }

  /// S - sqrt(S^2 + b) = -b/(S + sqrt(S^2 + b)), which subtracts nothing: the force is -its slope, and its difference
  /// to that at rupture the work.
  template <class T>
  [[gnu::always_inline]] void capillary(const Approach<T>& a, NormalForce<T>& n, T& bridge, T& pull, T& stored) const {
    const T zero(0.0), last(end);
    const T most = T(strength) * a.r_eff, b = T(volume / pi) / a.r_eff;
    const T gap = max(-a.overlap, zero), root = sqrt(gap * gap + b);
    const T inner = b / (gap + root), outer = b / (last + sqrt(last * last + b));
    const auto held = holds(a, n, bridge, gap, T(most * (sqrt(b) - outer)));
    pull = select(held, most * inner / root, zero);
    stored = select(held, most * (max(a.overlap, zero) + inner - outer), zero);
  }
};

}  // namespace subsoil::dem
