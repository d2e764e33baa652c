#pragma once

// Mechanisms that several tests and the work-precision benchmark share, as libmbd models.

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::test {

/// A pin of two bodies at a world point, wherever and however turned they stand.
inline mbd::Revolute pin_at(const mbd::Model& model, int a, int b, mbd::Vec2 at) {
  const auto local = [&](int body) -> std::array<double, 2> {
    if (body == mbd::ground) return {at.x, at.y};
    const auto& p = model.bodies[static_cast<std::size_t>(body - 1)].pose;
    return mbd::BodyState({p[0], p[1]}, p[2], {}, 0).point_in_body(at);
  };
  return {.body_a = a, .body_b = b, .p_a = local(a), .p_b = local(b)};
}

/// A uniform rod between two world points; x of its axes along it.
inline int add_rod(mbd::Model& m, const std::string& name, mbd::Vec2 from, mbd::Vec2 to, double mass) {
  const mbd::Vec2 d = to - from, mid = 0.5 * (from + to);
  return m.add(
      {.name = name, .mass = mass, .inertia = mass * dot(d, d) / 12, .pose = {mid.x, mid.y, std::atan2(d.y, d.x)}});
}

/// Rods hung on each other, stretched out to the right and let go: one is a pendulum, two the double pendulum.
inline mbd::Model make_chain(int links, double length = 1, double mass = 1) {
  mbd::Model m;
  int before = mbd::ground;
  for (int i = 0; i < links; ++i) {
    const mbd::Vec2 from{i * length, 0}, to{(i + 1) * length, 0};
    const int rod = add_rod(m, "rod " + std::to_string(i + 1), from, to, mass);
    m.add("pin " + std::to_string(i + 1), pin_at(m, before, rod, from));
    before = rod;
  }
  return m;
}

/// Crank, connecting rod and slider, the crank thrown at `spin` and then free.
inline mbd::Model make_slider_crank(double spin = 12) {
  mbd::Model m;
  const mbd::Vec2 top{0.15 * std::cos(0.7), 0.15 * std::sin(0.7)};
  const mbd::Vec2 end{top.x + std::sqrt(0.5 * 0.5 - top.y * top.y), 0};
  const int crank = add_rod(m, "crank", {0, 0}, top, 1.4);
  const int rod = add_rod(m, "rod", top, end, 0.9);
  const int slider = m.add({.name = "slider", .mass = 0.6, .inertia = 0.01, .pose = {end.x, end.y, 0}});
  // Consistent as it stands: assembly must not share the spin out among the bodies.
  const double turn = -spin * top.x / (end.x - top.x), slide = (turn - spin) * top.y;
  m.bodies[0].velocity = {-spin * top.y / 2, spin * top.x / 2, spin};
  m.bodies[1].velocity = {(slide - spin * top.y) / 2, spin * top.x / 2, turn};
  m.bodies[2].velocity = {slide, 0, 0};
  m.add("O", pin_at(m, mbd::ground, crank, {0, 0}));
  m.add("A", pin_at(m, crank, rod, top));
  m.add("B", pin_at(m, rod, slider, end));
  m.add("guide", mbd::Translational{.body_a = mbd::ground, .body_b = slider});
  return m;
}

/// That slider-crank in its one coordinate, the crank's angle a: mass(a) a'' + mass_slope a'^2/2 + weight = torque.
/// Derivatives by complex steps of the closed form, exact to rounding.
struct SliderCrankTerms {
  double mass, mass_slope, weight;
};
inline SliderCrankTerms slider_crank_terms(double angle) {
  using C = std::complex<double>;
  constexpr double r = 0.15, l = 0.5, crank = 1.4, rod = 0.9, slider = 0.6, g = 9.81, h = 1e-30;
  const C a(angle, h), sine = -r * std::sin(a) / l, cosine = std::sqrt(1. - sine * sine);
  const C turn = -r * std::cos(a) / (l * cosine);  // d(rod's angle)/da
  const C x = -r * std::sin(a) - 0.5 * l * sine * turn, y = 0.5 * r * std::cos(a);
  const C slide = -r * std::sin(a) - l * sine * turn;
  const C mass = crank * r * r / 3. + rod * (x * x + y * y + l * l / 12. * turn * turn) + slider * slide * slide;
  const C potential = (crank + rod) * g * 0.5 * r * std::sin(a);
  return {mass.real(), mass.imag() / h, potential.imag() / h};
}

/// A crank-rocker thrown at about `spin` under gravity, with a damped spring on its rocker.
inline mbd::Model make_four_bar(double spin = 9) {
  mbd::Model m;
  const double crank = 0.2, coupler = 0.7, rocker = 0.5, base = 0.6, phi = 0.4;
  const mbd::Vec2 a{crank * std::cos(phi), crank * std::sin(phi)}, to{base - a.x, -a.y};
  // The rocker's pin by the law of cosines in the triangle that the crank's end makes with the base.
  const double far = length(to),
               turn = std::acos((coupler * coupler + far * far - rocker * rocker) / (2 * coupler * far));
  const double up = std::atan2(to.y, to.x) + turn;
  const mbd::Vec2 b{a.x + coupler * std::cos(up), a.y + coupler * std::sin(up)};
  const int first = add_rod(m, "crank", {0, 0}, a, 1.2), second = add_rod(m, "coupler", a, b, 2.5),
            third = add_rod(m, "rocker", {base, 0}, b, 1.7);
  m.bodies[0].velocity = {-spin * a.y / 2, spin * a.x / 2, spin};
  m.add("O", pin_at(m, mbd::ground, first, {0, 0}));
  m.add("A", pin_at(m, first, second, a));
  m.add("B", pin_at(m, second, third, b));
  m.add("C", pin_at(m, mbd::ground, third, {base, 0}));
  m.add("spring", mbd::RotationalSpringDamper{.body_a = mbd::ground, .body_b = third, .stiffness = 40, .damping = 0.2});
  return m;
}

/// Andrews' squeezing mechanism: seven bodies, ten pins, a motor torque, a spring; no gravity. Numbers and start of the
/// IVP test set (Mazzia & Magherini 2008, release 2.4, II-6; Schiehlen 1990). Bodies K1 ... K7, angles as there:
/// beta, beta + Theta, gamma, Phi + delta, delta, Omega + epsilon, epsilon.
inline mbd::Model make_squeezer() {
  constexpr double rr = 7e-3, da = 115e-4, d = 28e-3, ra = 92e-5, sa = 1874e-5, sb = 1043e-5, sc = 18e-3, sd = 2e-2,
                   e = 2e-2, ea = 1421e-5, zf = 2e-2, fa = 1421e-5, zt = 4e-2, ta = 2308e-5, tb = 916e-5, u = 4e-2,
                   ua = 1228e-5, ub = 449e-5;
  constexpr mbd::Vec2 a{-.06934, -.00227}, b{-.03635, .03273}, c{.014, .072};
  constexpr double masses[7] = {.04325, .00365, .02373, .00706, .07050, .00706, .05498};
  constexpr double inertias[7] = {2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5};
  constexpr double beta = -0.0617138900142764496358948458001, gamma = 0.455279819163070380255912382449,
                   phi = 0.222668390165885884674473185609, delta = 0.487364979543842550225598953530,
                   omega = -0.222668390165885884674473185609, eps = 1.23054744454982119249735015568;
  const double angle[7] = {beta, beta, gamma, phi + delta, delta, omega + eps, eps};
  const auto from = [](mbd::Vec2 p, double t, double x, double y) {
    return mbd::Vec2{p.x + x * std::cos(t) - y * std::sin(t), p.y + x * std::sin(t) + y * std::cos(t)};
  };
  const mbd::Vec2 tip = from({0, 0}, beta, rr, 0), meet = from(tip, beta, -d, 0);
  const mbd::Vec2 elbow5 = from(a, delta, zt, 0), elbow7 = from(a, eps, 0, -u);
  const mbd::Vec2 centre[7] = {from({0, 0}, beta, ra, 0), from(tip, beta, -da, 0),
                               from(b, gamma, sb, -sa),   from(elbow5, phi + delta, 0, -(e - ea)),
                               from(a, delta, ta, tb),    from(elbow7, omega + eps, zf - fa, 0),
                               from(a, eps, -ub, -ua)};
  mbd::Model m;
  m.gravity = {0, 0};
  for (int i = 0; i < 7; ++i)
    m.add({.name = std::string("K").append(std::to_string(i + 1)),
           .mass = masses[i],
           .inertia = inertias[i],
           .pose = {centre[i].x, centre[i].y, angle[i]}});
  m.add("O", pin_at(m, mbd::ground, 1, {0, 0}));
  m.add("1-2", pin_at(m, 1, 2, tip));
  m.add("2-3", pin_at(m, 2, 3, meet));
  m.add("B", pin_at(m, mbd::ground, 3, b));
  m.add("2-4", pin_at(m, 2, 4, meet));
  m.add("4-5", pin_at(m, 4, 5, elbow5));
  m.add("A5", pin_at(m, mbd::ground, 5, a));
  m.add("2-6", pin_at(m, 2, 6, meet));
  m.add("6-7", pin_at(m, 6, 7, elbow7));
  m.add("A7", pin_at(m, mbd::ground, 7, a));
  // K3's own axes: pin B at (-sb, sa), the spring's point D at (sd, -sc) from it.
  m.add("spring", mbd::SpringDamper{.body_a = 3,
                                    .body_b = mbd::ground,
                                    .p_a = {sd - sb, sa - sc},
                                    .p_b = {c.x, c.y},
                                    .stiffness = 4530,
                                    .free_length = 0.07785});
  m.add("motor", mbd::AppliedForce{.body = 1, .moment = 0.033});
  return m;
}

/// beta, Theta, gamma, Phi, delta, Omega, epsilon of the squeezer at 0.03 s, by the IVP test set.
inline constexpr std::array<double, 7> squeezer_reference{15.81077119629904,   -15.75637105984298, 0.04082224013073101,
                                                          -0.5347301163226948, 0.5244099658805304, 0.5347301163226948,
                                                          1.048080741042263};
/// The same angles of a machine.
inline std::array<double, 7> squeezer_angles(const mbd::Machine& machine) {
  const auto at = [&](int i) { return machine.body(i).angle; };
  return {at(1), at(2) - at(1), at(3), at(4) - at(5), at(5), at(6) - at(7), at(7)};
}

}  // namespace subsoil::test
