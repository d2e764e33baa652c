#include <gtest/gtest.h>

#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>

#include "libdem/particles/rigid_rotation.hpp"

/// Rotation of clumps without torque against the motion of tops in closed form (Landau & Lifshitz, Mechanics, sections
/// 33 and 37): second order, momentum kept, no drift of the energy.
namespace subsoil::dem::test::free_rotation {
namespace {

struct Top {
  Vec3 inertia, momentum;  ///< momentum in world axes
  Quaternion attitude;

  void advance(double time, int steps) {
    for (int k = 0; k < steps; ++k) attitude = rotate_freely(attitude, inertia, momentum, time / steps).attitude;
  }
  double energy() const { return 0.5 * dot(momentum, angular_velocity_of(attitude, inertia, momentum)); }
};

double apart(const Quaternion& a, const Quaternion& b) {
  const Quaternion q = a * b.conjugate();
  return 2 * norm(Vec3{q.x, q.y, q.z});
}

/// The axis of a symmetric top goes round L at |L|/J_1, the top about its axis at L_3 (1/J_3 - 1/J_1).
TEST(FreeRotation, SymmetricTopPrecesses) {
  const Vec3 inertia{2, 2, 3};
  const Quaternion start = Quaternion::from_rotation_vector({0.7, -0.3, 0.2});
  const Vec3 momentum{0.4, 1.5, 2.2};
  const double time = 7, along = start.conjugate().rotate(momentum).z;
  const Quaternion exact = Quaternion::from_rotation_vector((time / inertia.x) * momentum) * start *
                           Quaternion::from_rotation_vector({0, 0, time * along * (1 / inertia.z - 1 / inertia.x)});
  double before = 0;
  for (const int steps : {50, 100, 200, 400}) {
    Top top{inertia, momentum, start};
    top.advance(time, steps);
    const double error = apart(top.attitude, exact);
    if (before > 0) {
      EXPECT_NEAR(before / error, 4, 0.1) << steps;  // the next power, h^4, adds 1 % at 50 steps
    }
    before = error;
  }
  EXPECT_LT(before, 2e-3);
}

/// Body components of L of an asymmetric top are Jacobi's elliptic functions of time.
TEST(FreeRotation, AsymmetricTopFollowsEllipticFunctions) {
  const double i1 = 1, i2 = 2, i3 = 3.5;
  const double w1 = 0.9, w3 = 1.1;  // at t = 0, where w2 = 0
  const double twice = i1 * w1 * w1 + i3 * w3 * w3, m2 = i1 * i1 * w1 * w1 + i3 * i3 * w3 * w3;
  ASSERT_GT(m2, twice * i2);  // the side of the separatrix that the formulas are for
  const double k = std::sqrt((i2 - i1) * (twice * i3 - m2) / ((i3 - i2) * (m2 - twice * i1)));
  const double rate = std::sqrt((i3 - i2) * (m2 - twice * i1) / (i1 * i2 * i3));
  const double amplitude = std::sqrt((twice * i3 - m2) / (i2 * (i3 - i2)));
  const double time = 9;
  double cn = 0, dn = 0;
  const double sn = boost::math::jacobi_elliptic(k, rate * time, &cn, &dn);
  const Vec3 exact{i1 * w1 * cn, i2 * amplitude * sn, i3 * w3 * dn};
  double before = 0;
  for (const int steps : {100, 200, 400, 800}) {
    Top top{{i1, i2, i3}, {i1 * w1, 0, i3 * w3}, {}};
    top.advance(time, steps);
    const double error = norm(top.attitude.conjugate().rotate(top.momentum) - exact);
    if (before > 0) {
      EXPECT_NEAR(before / error, 4, 0.15) << steps;
    }
    before = error;
  }
  EXPECT_LT(before, 1e-3 * norm(exact));
}

/// About the middle axis, where the motion is unstable: over 2000 turnings the energy comes back, within the square of
/// the step times the rate, 0.02^2.
TEST(FreeRotation, EnergyDoesNotDrift) {
  Top top{{1, 2, 3.5}, {0.01, 4, 0}, {}};
  const double start = top.energy();
  double worst = 0;
  for (int k = 0; k < 40; ++k) {
    top.advance(100, 10000);
    worst = std::max(worst, std::abs(top.energy() / start - 1));
  }
  EXPECT_LT(worst, 4e-4);
}

/// What bodies move by: a point of the body goes by dt w x (its mean arm), to rounding, and w is J^-1 L of the attitude
/// half way.
TEST(FreeRotation, PointsMoveByTheirMeanArm) {
  const Quaternion q = Quaternion::from_rotation_vector({0.2, 0.5, -1});
  const Vec3 inertia{1, 2, 3}, momentum{3, -1, 2}, arm{0.3, 0.4, -0.1};
  const double dt = 0.05;
  const RotationStep s = rotate_freely(q, inertia, momentum, dt);
  const Vec3 from = q.rotate(arm), to = s.attitude.rotate(arm);
  EXPECT_LT(norm(to - from - dt * cross(s.angular_velocity, 0.5 * (from + to))), 1e-16);
  const double turned = 2 * std::atan(0.5 * dt * norm(s.angular_velocity));
  const Quaternion half = Quaternion::from_rotation_vector((0.5 * turned) * normalized(s.angular_velocity)) * q;
  EXPECT_LT(norm(angular_velocity_of(half, inertia, momentum) - s.angular_velocity), 1e-14);
}

}  // namespace
}  // namespace subsoil::dem::test::free_rotation
