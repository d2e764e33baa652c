#pragma once
#include <array>
#include <cmath>

/// Small fixed-size vectors and rotations of the bed. libdem links no linear-algebra library: three components, a
/// cross product and a quaternion are all it needs, and they must inline into the sweep.
namespace subsoil::dem {

struct Vec3 {
  double x = 0, y = 0, z = 0;

  constexpr Vec3& operator+=(const Vec3& b) { return x += b.x, y += b.y, z += b.z, *this; }
  constexpr Vec3& operator-=(const Vec3& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
  constexpr Vec3& operator*=(double s) { return x *= s, y *= s, z *= s, *this; }
  constexpr double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  constexpr double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  friend constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
  friend constexpr Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
  friend constexpr Vec3 operator*(Vec3 a, double s) { return a *= s; }
  friend constexpr Vec3 operator*(double s, Vec3 a) { return a *= s; }
  friend constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(const Vec3& a) { return a * (1 / norm(a)); }

/// Unit quaternion w + (x, y, z): rotation from body axes to world axes.
struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;

  /// Rotation by |rotation| radians about the direction of `rotation` (rotation vector, rad).
  static Quaternion from_rotation_vector(const Vec3& rotation) {
    const double angle = norm(rotation);
    const double s = angle > 1e-12 ? std::sin(angle / 2) / angle : 0.5;
    return {std::cos(angle / 2), s * rotation.x, s * rotation.y, s * rotation.z};
  }
  friend constexpr Quaternion operator*(const Quaternion& a, const Quaternion& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
  constexpr Quaternion conjugate() const { return {w, -x, -y, -z}; }
  /// Body-axes vector in world axes.
  constexpr Vec3 rotate(const Vec3& v) const {
    const Vec3 u{x, y, z};
    const Vec3 t = 2.0 * cross(u, v);
    return v + w * t + cross(u, t);
  }
  Quaternion normalized() const {
    const double s = 1 / std::sqrt(w * w + x * x + y * y + z * z);
    return {w * s, x * s, y * s, z * s};
  }
};

/// Position and attitude of a rigid surface: world = position + attitude.rotate(local).
struct Pose {
  Vec3 position;
  Quaternion attitude;

  constexpr Vec3 to_world(const Vec3& local) const { return position + attitude.rotate(local); }
  constexpr Vec3 to_local(const Vec3& world) const { return attitude.conjugate().rotate(world - position); }
};

}  // namespace subsoil::dem
