// Simeon's flexible slider-crank of the IVP test set: its equations, written here as it states them (rod in the frame
// of its chord: two sines across, a quadratic along), meet the published solution; the rod as a beam meets these
// equations. Source: Simeon 1996, Math. Modelling of Systems 2, 1-18; Mazzia & Magherini, Test Set for IVP Solvers,
// slider crank.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "libmbd/system/beam.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::flexible_slider_crank_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double crank = 0.15, rod = 0.3, crank_mass = 0.36, crank_inertia = 0.002727, slider_mass = 0.075552;
constexpr double rod_mass = 0.151104, rod_inertia = 0.0045339259, young = 2e11, edge = 8e-3, density = 7870,
                 speed = 150;
constexpr double area = edge * edge;

// Start close to the smooth motion: q_3, q_4 along, rates of q_1 ... q_4.
constexpr std::array<double, 8> start{
    0, 0, .103339863e-4, .169327969e-4, .444896105, .463434311e-2, -.178591076e-5, -.268938672e-5};

using Vector4 = Eigen::Vector4d;
using Matrix4 = Eigen::Matrix4d;

/// Simeon's equations in the four elastic coordinates, the rigid ones and multipliers eliminated at every call.
struct Simeon {
  /// Inertia along the rod: the test set's matrix [8 1; 1 2] rho A L is 15 times that of a quadratic element.
  double along = 1;
  bool nonlinear = false;  ///< bending feels the axial force
  Matrix4 M = Matrix4::Zero(), K = Matrix4::Zero(), B = Matrix4::Zero();
  Vector4 c1 = Vector4::Zero(), c2 = Vector4::Zero(), c12 = Vector4::Zero(), c21 = Vector4::Zero();

  Simeon(double along_share, bool with_nonlinear) : along(along_share), nonlinear(with_nonlinear) {
    const double mass = density * area * rod, k = young * area / rod, v = area * rod, slender = edge / rod;
    M.topLeftCorner<2, 2>() = 0.5 * mass * Eigen::Matrix2d::Identity();
    M.bottomRightCorner<2, 2>() << 8 * mass * along, mass * along, mass * along, 2 * mass * along;
    K(0, 0) = k * std::pow(pi, 4) / 24 * slender * slender;
    K(1, 1) = k * std::pow(pi, 4) * 2 / 3 * slender * slender;
    K.bottomRightCorner<2, 2>() << k * 16 / 3, -k * 8 / 3, -k * 8 / 3, k * 7 / 3;
    B(0, 2) = -v * 16 / std::pow(pi, 3), B(0, 3) = v * (8 / std::pow(pi, 3) - 1 / pi), B(1, 3) = v * 0.5 / pi;
    B -= Matrix4(B.transpose());
    c1 << 0, 0, v * 2 / 3, v / 6;
    c2 << v * 2 / pi, 0, 0, 0;
    c12 << 0, 0, rod * v / 3, rod * v / 6;
    c21 << rod * v / pi, -rod * v / (2 * pi), 0, 0;
  }

  struct Chord {
    double angle, slider, length;
  };
  static Chord chord(double t, double q4) {
    const double l = rod + q4, angle = -std::asin(crank * std::sin(speed * t) / l);
    return {angle, crank * std::cos(speed * t) + l * std::cos(angle), l};
  }

  Vector4 accelerations(double t, const Vector4& q, const Vector4& w) const {
    const Chord c = chord(t, q[3]);
    const double p1 = speed * t, v1 = speed, s2 = std::sin(c.angle), k2 = std::cos(c.angle);
    const double v2 = -(crank * std::cos(p1) * v1 + s2 * w[3]) / (c.length * k2);
    const double s = std::sin(p1 - c.angle), k = std::cos(p1 - c.angle), rho = density;
    Eigen::Matrix<double, 10, 10> A = Eigen::Matrix<double, 10, 10>::Zero();
    Eigen::Matrix<double, 10, 1> b = Eigen::Matrix<double, 10, 1>::Zero();
    A(0, 0) = crank_inertia + rod_mass * crank * crank;
    A(0, 1) = 0.5 * crank * rod * rod_mass * k + rho * crank * (s * c2.dot(q) + k * c1.dot(q));
    A(1, 1) = rod_inertia + q.dot(M * q) + 2 * rho * c12.dot(q);
    A(2, 2) = slider_mass;
    A.block<1, 4>(0, 3) = rho * crank * (-s * c1 + k * c2).transpose();
    A.block<1, 4>(1, 3) = rho * (c21.transpose() + q.transpose() * B);
    A.block<4, 4>(3, 3) = M;
    A(7, 0) = crank * std::cos(p1), A(7, 1) = c.length * k2, A(7, 6) = s2;
    A(8, 0) = crank * std::sin(p1), A(8, 1) = c.length * s2, A(8, 2) = 1, A(8, 6) = -k2;
    A(9, 0) = 1;
    A.block<3, 3>(0, 7) = A.block<3, 3>(7, 0).transpose().eval();
    A.block<4, 3>(3, 7) = A.block<3, 4>(7, 3).transpose().eval();
    for (int i = 0; i < 7; ++i)
      for (int j = i + 1; j < 7; ++j) A(j, i) = A(i, j);
    b[0] = -0.5 * crank * rod * rod_mass * v2 * v2 * s + rho * crank * v2 * v2 * (-s * c1.dot(q) + k * c2.dot(q)) -
           2 * rho * crank * v2 * (k * c1.dot(w) + s * c2.dot(w));
    b[1] = 0.5 * crank * rod * rod_mass * v1 * v1 * s + rho * crank * v1 * v1 * (s * c1.dot(q) - k * c2.dot(q)) -
           2 * rho * v2 * c12.dot(w) - 2 * v2 * w.dot(M * q) - rho * w.dot(B * w);
    b.segment<4>(3) = v2 * v2 * M * q + rho * (v2 * v2 * c12 + crank * v1 * v1 * (k * c1 + s * c2) + 2 * v2 * B * w) -
                      K * q - stiffening(q);
    b[7] = crank * std::sin(p1) * v1 * v1 + c.length * s2 * v2 * v2 - 2 * v2 * k2 * w[3];
    b[8] = -crank * std::cos(p1) * v1 * v1 - c.length * k2 * v2 * v2 - 2 * v2 * s2 * w[3];
    return A.partialPivLu().solve(b).segment<4>(3);
  }
  Vector4 stiffening(const Vector4& q) const {
    if (!nonlinear) return Vector4::Zero();
    const double k = 0.5 * young * area / (rod * rod) * pi * pi, f = 80 / (9 * pi * pi), u = -4 * q[2] + 2 * q[3];
    // The test set's own terms, quadratic in q, and the cubic ones that belong to them: the mean of w'^2/2 strains the
    // rod.
    const double mean = pi * pi / (4 * rod * rod) * (q[0] * q[0] + 4 * q[1] * q[1]);
    return k * Vector4(q[0] * q[3] - f * q[1] * u, 4 * q[1] * q[3] - f * q[0] * u, 4 * f * q[0] * q[1],
                       0.5 * q[0] * q[0] + 2 * q[1] * q[1] - 2 * f * q[0] * q[1]) +
           k * rod * mean * Vector4(q[0], 4 * q[1], 0, 0);
  }
  test::OdeState solve(const test::OdeState& y, double from, double to, double tolerance = 1e-12) const {
    const auto right = [this](const test::OdeState& s, test::OdeState& d, double t) {
      const Vector4 a = accelerations(t, Vector4(s.data()), Vector4(s.data() + 4));
      d = {s[4], s[5], s[6], s[7], a[0], a[1], a[2], a[3]};
    };
    return test::solve_ode(right, y, from, to, tolerance);
  }
};

// The published solution at 0.1 s to 16 digits, from several codes; pi is 3.1415927 there, which the mode's stiffness
// feels by 6e-8 and some 20 oscillations turn into 1e-5 of the deflections.
TEST(FlexibleSliderCrank, ItsEquationsMeetThePublishedSolution) {
  const Simeon published(1, false);
  const test::OdeState y = published.solve({start.begin(), start.end()}, 0, 0.1);
  const Simeon::Chord c = Simeon::chord(0.1, y[3]);
  EXPECT_NEAR(c.angle, -0.3311734988256260, 1e-9);
  EXPECT_NEAR(c.slider, 0.1697373328427860, 1e-9);
  const double deflections[] = {0.1893192899613509e-3, 0.2375751249879174e-4, -0.5323896770569702e-5,
                                -0.8363313279112129e-5};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(y[i], deflections[i], 2e-9) << i;
}

/// The mechanism with its rod as a beam, started with the rod's elongation and velocities of the test set.
Model flexible(long elements) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "crank",
         .mass = crank_mass,
         .inertia = crank_inertia - crank_mass * crank * crank / 4,
         .pose = {crank / 2, 0, 0},
         .velocity = {0, speed * crank / 2, speed}});
  const Beam beam{.name = "rod",
                  .points = {{crank, 0}, {crank + rod, 0}},
                  .section = GivenSection{.area = area, .second_moment = area * area / 12},
                  .young = young,
                  .density = density,
                  .elements = elements};
  const DividedBeam divided = divide(beam);
  const double turn = -crank * speed / (rod + start[3]);
  for (std::size_t i = 0; i < divided.nodes.size(); ++i) {
    Body node = divided.nodes[i];
    const double x = static_cast<double>(i) / static_cast<double>(elements), mid = 4 * x * (1 - x),
                 end = x * (2 * x - 1);
    const double along = rod * x + mid * start[2] + end * start[3];
    node.pose[0] = crank + along;
    node.velocity = {mid * start[6] + end * start[7],
                     crank * speed + turn * along + start[4] * std::sin(pi * x) + start[5] * std::sin(2 * pi * x),
                     turn + pi / rod * (start[4] * std::cos(pi * x) + 2 * start[5] * std::cos(2 * pi * x))};
    m.add(node);
  }
  long k = 0;
  for (BeamElement e : divided.elements) {
    e.body_a += 2, e.body_b += 2;
    m.add(beam.element_name(++k), e);
  }
  const int last = static_cast<int>(elements) + 2;
  m.add({.name = "slider",
         .mass = slider_mass,
         .inertia = 1e-4,
         .pose = {crank + rod + start[3], 0, 0},
         .velocity = {start[7], 0, 0}});
  m.add("bearing", Revolute{.body_a = ground, .body_b = 1, .p_b = {-crank / 2, 0}});
  m.add("crank pin", Revolute{.body_a = 1, .body_b = 2, .p_a = {crank / 2, 0}});
  m.add("wrist pin", Revolute{.body_a = last, .body_b = last + 1});
  m.add("guide", Translational{.body_a = ground, .body_b = last + 1});
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = speed}});
  return m;
}

/// Of the rod against its chord: angle, length, first and second sine of the deflection.
struct Rod {
  double angle, length;
  std::array<double, 2> sines{};
  Rod(const Machine& machine, int nodes) {
    const Vec2 a = machine.body(2).r, d = machine.body(nodes + 1).r - a;
    angle = std::atan2(d.y, d.x), length = mbd::length(d);
    for (int i = 1; i + 1 < nodes; ++i) {
      const double x = static_cast<double>(i) / (nodes - 1), w = cross((1 / length) * d, machine.body(2 + i).r - a);
      for (int mode = 1; mode <= 2; ++mode)
        sines[static_cast<std::size_t>(mode - 1)] += 2.0 / (nodes - 1) * w * std::sin(mode * pi * x);
    }
  }
};

// The published equations leave out what the axial force does to bending (some 5 % of the stiffness here). With it they
// differ from the beam by its higher modes and its rotary inertia, 6e-4 of a frequency. Measured: 3.6e-6 m of 1.57e-3
// m.
TEST(FlexibleSliderCrank, ABeamMeetsItsEquations) {
  constexpr long elements = 8;
  Machine machine(flexible(elements), {.integrator = IntegratorKind::ida, .ida = {.rtol = 1e-7, .atol = 1e-9}});
  machine.start_from_pose();
  const Simeon equations(1. / 15, true), published(1, false);
  test::OdeState y{start.begin(), start.end()}, z = y;
  double most = 0, worst = 0, worst_second = 0, worst_angle = 0, from_published = 0;
  for (int i = 1; i <= 50; ++i) {
    const double t = machine.time();
    machine.advance(2e-3);
    y = equations.solve(y, t, machine.time(), 1e-9);
    z = published.solve(z, t, machine.time(), 1e-9);
    const Rod found(machine, elements + 1);
    most = std::max(most, std::abs(y[0]));
    worst = std::max(worst, std::abs(found.sines[0] - y[0]));
    worst_second = std::max(worst_second, std::abs(found.sines[1] - y[1]));
    worst_angle = std::max(worst_angle, std::abs(found.angle - Simeon::chord(machine.time(), y[3]).angle));
    from_published = std::max(from_published, std::abs(found.sines[0] - z[0]));
  }
  EXPECT_LT(worst, 5e-3 * most);
  EXPECT_LT(worst_second, 5e-6);
  EXPECT_LT(worst_angle, 5e-7);
  // What the published model leaves out is seen: a test of the two that could not tell them apart would say little.
  EXPECT_GT(from_published, 0.05 * most);
  EXPECT_LT(from_published, 0.15 * most);
}

}  // namespace
}  // namespace subsoil::mbd::flexible_slider_crank_test
