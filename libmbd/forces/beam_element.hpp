#pragma once

#include <algorithm>
#include <stdexcept>

#include "libmbd/element/force_geometry.hpp"

namespace subsoil::mbd {

/// Element of an elastic beam, without mass, between a point (node) of body a and one of body b. Displacements and
/// turns of any size, strains small.
///   d = r_b - r_a,  c = |d|,  psi = (phi_a + phi_b)/2,  Delta = phi_b - phi_a   phi: angle of a body's section normal
///   (rad) e_1 = (cos psi, sin psi),  e_2 = k x e_1 G_2 = e_2 . d - g_2                            shear of its middle
///   section      (m) G_1 = c + u^2/(10 l) - l sinc(Delta/2) - g_1   extension of the arc             (m) u = rho G_2 +
///   g_2,  rho = k_s l^3/(12 EI)      the part of e_2 . d that bends it to an S N = EA/l (G_1 + tau G_1'),  Q = k_s
///   (G_2 + tau G_2'),  M = EI/l (Delta - Delta_0 + tau Delta') 1/k_s = l^3/(12 EI) + l/GA
/// l: length of the arc between the nodes. For small displacements these are the three strains in which the stiffness
/// of an exact Timoshenko beam (Euler-Bernoulli where GA is not given) is diagonal, so nodes loaded at nodes are exact.
/// The arc over the chord is that of the element's cubic to the second order, l Delta^2/24 + u^2/(10 l), so that the
/// axial force stiffens or softens the bent element by its consistent geometric stiffness; l sinc(Delta/2), the chord
/// of a circle, makes pure bending exact for any angle. Forces are the gradient of the energy, so momenta are kept and
/// the balance closes:   stored = EA/(2l) G_1^2 + k_s/2 G_2^2 + EI/(2l) (Delta - Delta_0)^2,   lost rate = tau times
/// the same squares of rates, doubled. tau: Kelvin-Voigt, sigma = E (epsilon + tau epsilon'), the beta of Rayleigh.
/// g_1, g_2 and Delta_0 make the start pose free of stress: the element may be bent there.
/// Columns: force along the chord (tension positive) and across it, bending moments in the sections at a and b
/// (positive where they turn b counter-clockwise against a), maximum |force along|/A + |moment|/W of the two. Sources:
/// Przemieniecki, Theory of Matrix Structural Analysis, 1968, 5.6 (Phi = 12 EI/(GA l^2)) and 15.2 (geometric
/// stiffness); Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1, 1991, 7.3 (frame of the
/// chord).
struct BeamElement {
  static constexpr ForceMembers has{.check = true, .initialise_from_pose = true};
  static constexpr std::array<ForceColumn, 5> columns{
      {{"axial force", "N"}, {"shear force", "N"}, {"moment a", "N m"}, {"moment b", "N m"}, {"stress", "Pa"}}};
  static constexpr double not_given = std::numeric_limits<double>::quiet_NaN();
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double axial_stiffness = not_given, bending_stiffness = not_given, shear_stiffness = not_given;
  double damping_time = 0;
  double area = not_given, section_modulus = not_given;
  double length = not_given;         ///< l (m)
  bool placed = false;               ///< what follows is given; else the beam is straight in the start pose
  double turn_a = 0, turn_b = 0;     ///< phi over the angle of the body (rad)
  std::array<double, 2> rest{0, 0};  ///< g (m)
  double rest_turn = 0;              ///< Delta_0 (rad)

  template <class V>
  void describe(V& v) {
    v.card("beam", "a beam without mass between points of two bodies, straight in the start pose");
    v.bodies("beam", body_a, body_b, "the two bodies, each clamped to one end");
    v.end_points(body_a, p_a, body_b, p_b, "the two ends");
    v.quantity("axial stiffness", axial_stiffness, "N", "(0, inf)", "EA");
    v.quantity("bending stiffness", bending_stiffness, "N m^2", "(0, inf)", "EI");
    v.optional_quantity("shear stiffness", shear_stiffness, "N", "(0, inf)",
                        "GA over the shear factor of the section; left out: no deformation by shear");
    v.quantity("damping time", damping_time, "s", "[0, inf)",
               "tau of sigma = E (epsilon + tau epsilon'); a mode of circular frequency w has the damping ratio "
               "w tau/2");
    v.optional_quantity("area", area, "m^2", "(0, inf)", "of the section, for its stress");
    v.optional_quantity("section modulus", section_modulus, "m^3", "(0, inf)",
                        "second moment of area over the distance of the outermost fibre, for the stress; left out, as "
                        "the area: the column `stress` is 0");
    v.optional_quantity("length", length, "m", "(0, inf)",
                        "of the beam without force; left out: the distance of its ends in the start pose");
  }

  void check() const {
    if (!(axial_stiffness > 0) || !(bending_stiffness > 0))
      throw std::invalid_argument("axial stiffness and bending stiffness must be given, above 0");
    if (!(damping_time >= 0)) throw std::invalid_argument("damping time must not be negative");
  }

  /// What the start pose decides for a beam between two bodies.
  void initialise_from_pose(const Scene& scene) {
    if (placed) return;
    const BodyState &a = body_of(scene, body_a), &b = body_of(scene, body_b);
    const Vec2 d = b.point_in_world(p_b) - a.point_in_world(p_a);
    if (std::isnan(length)) length = mbd::length(d);
    if (!(mbd::length(d) > 0)) throw std::invalid_argument("both ends are at the same point; a beam has a length");
    const double angle = std::atan2(d.y, d.x);
    turn_a = angle - a.angle, turn_b = angle - b.angle;
  }

  /// k_s (N/m).
  double shear_spring() const {
    const double l = length, bending = l * l * l / (12 * bending_stiffness);
    return 1 / (std::isnan(shear_stiffness) ? bending : bending + l / shear_stiffness);
  }

  /// Extension, shear and turn of the arc with their rates, and what forces need of the geometry.
  struct Strain {
    Vec2 chord, e2, arm_a, arm_b;       ///< chord: d/c
    double along, across;               ///< e_1 . d, e_2 . d
    double slanted;                     ///< dG_1/dG_2 = rho u/(5 l)
    double bent;                        ///< d(l sinc(Delta/2))/d(Delta)
    std::array<double, 3> value, rate;  ///< G_1, G_2, Delta - Delta_0
  };
  Strain strain(const BodyState& a, const BodyState& b) const {
    Strain s;
    const double phi_a = a.angle + turn_a, phi_b = b.angle + turn_b, delta = phi_b - phi_a, half = 0.5 * delta;
    const double psi = 0.5 * (phi_a + phi_b), spin = 0.5 * (a.omega + b.omega), turn_rate = b.omega - a.omega;
    const Vec2 e1{std::cos(psi), std::sin(psi)};
    s.e2 = turned(e1), s.arm_a = a.vector_in_world(p_a), s.arm_b = b.vector_in_world(p_b);
    const Vec2 d = b.r + s.arm_b - a.r - s.arm_a, d_rate = b.velocity_at(s.arm_b) - a.velocity_at(s.arm_a);
    const double c = mbd::length(d), shear_share = shear_spring() * length * length * length / (12 * bending_stiffness);
    s.chord = c > 0 ? (1 / c) * d : e1;
    s.along = dot(e1, d), s.across = dot(s.e2, d);
    const bool small = std::abs(half) < 0.05;  // series to rounding: the quotients lose digits there
    const double h2 = half * half, sinc = small ? 1 - h2 / 6 * (1 - h2 / 20 * (1 - h2 / 42)) : std::sin(half) / half,
                 slope = small ? -half / 3 * (1 - h2 / 10 * (1 - h2 / 28)) : (std::cos(half) - sinc) / half;
    s.bent = 0.5 * length * slope;
    const double sheared = s.across - rest[1], u = shear_share * sheared + rest[1];
    s.slanted = shear_share * u / (5 * length);
    s.value = {c + u * u / (10 * length) - length * sinc - rest[0], sheared, delta - rest_turn};
    const double sheared_rate = dot(s.e2, d_rate) - spin * s.along;
    s.rate = {dot(s.chord, d_rate) + s.slanted * sheared_rate - s.bent * turn_rate, sheared_rate, turn_rate};
    return s;
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const Strain s = strain(body_of(scene, body_a), body_of(scene, body_b));
    const std::array<double, 3> stiffness{axial_stiffness / length, shear_spring(), bending_stiffness / length};
    std::array<double, 3> force{};
    ForcePower power;
    for (std::size_t i = 0; i < 3; ++i) {
      force[i] = stiffness[i] * (s.value[i] + damping_time * s.rate[i]);
      power.stored += 0.5 * stiffness[i] * s.value[i] * s.value[i];
      power.lost += stiffness[i] * damping_time * s.rate[i] * s.rate[i];
    }
    const auto [tension, shear, m] = force;
    const double q = shear + tension * s.slanted;
    const Vec2 f = tension * s.chord + q * s.e2;
    // Derivatives of the energy by psi, half of it for either body, and by Delta.
    const double turns = -0.5 * q * s.along, bends = m - tension * s.bent;
    loads.add(body_b, s.arm_b, -1.0 * f);
    loads.add(body_a, s.arm_a, f);
    loads.add_wrench(body_b, 0, 0, -turns - bends);
    loads.add_wrench(body_a, 0, 0, -turns + bends);
    const double n = dot(f, s.chord);
    const double moment_a = bends - turns, moment_b = bends + turns;
    const bool stressed = !std::isnan(area) && !std::isnan(section_modulus);
    const double stress =
        stressed ? std::abs(n) / area + std::max(std::abs(moment_a), std::abs(moment_b)) / section_modulus : 0;
    values = {n, dot(f, turned(s.chord)), moment_a, moment_b, stress};
    return power;
  }
};

}  // namespace subsoil::mbd
