#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// What forces on a sphere move: itself; nothing; its clump.
enum class SphereKind : std::uint8_t { free, fixed, member };

/// Working record of one sphere, 96 bytes: one and a half cache lines, read whole by every contact. Structure-of-arrays
/// lost: a contact needs eleven numbers of its partner, which would be eleven cache lines instead of two. Aligned so
/// that none of its three groups of four lies across two lines.
struct alignas(32) Sphere {
  Vec3 x;                  ///< centre, m, at time t_n
  double r;                ///< radius, m
  Vec3 v;                  ///< velocity, m/s, at t_n - dt/2 (leapfrog)
  double m;                ///< mass of its matter, kg; of a clump's its share by volume: over all spheres, the bed's
  Vec3 w;                  ///< angular velocity, rad/s, at t_n - dt/2
  std::uint32_t id;        ///< the user's number, kept for life
  std::uint16_t material;  ///< index into the table of laws
  SphereKind kind;
  std::uint8_t calm;  ///< active_region.hpp
};
static_assert(sizeof(Sphere) == 96);

/// Of what passes between pairs of spheres. Mixed: positions and forces on surfaces in double, linear and angular
/// velocities, springs, laws and the sum of the forces on a sphere in float.
enum class Precision { doubles, mixed };

/// What a step of mixed precision reads and writes of a sphere, one cache line: position in double, for contacts live
/// on the difference of two nearly equal numbers; all else in float.
struct alignas(64) MixedSphere {
  Vec3 x;
  double r;
  float v[3], m;  ///< m: as contacts find it
  float w[3];
  float r_single;
};
static_assert(sizeof(MixedSphere) == 64);

/// @param mass that contacts find of it, kg (ParticleStore)
inline MixedSphere rounded(const Sphere& s, double mass) {
  const auto f = [](double x) { return static_cast<float>(x); };
  return {s.x, s.r, {f(s.v.x), f(s.v.y), f(s.v.z)}, f(mass), {f(s.w.x), f(s.w.y), f(s.w.z)}, f(s.r)};
}

inline double sphere_volume(double radius) { return 4.0 / 3.0 * M_PI * radius * radius * radius; }
inline double inertia(const Sphere& s) { return 0.4 * s.m * s.r * s.r; }
inline double density(const Sphere& s) { return s.m / sphere_volume(s.r); }  ///< kg/m3

/// A sphere as the user gives it.
struct SphereSpec {
  Vec3 position;          ///< m
  Vec3 velocity;          ///< m/s, at t = 0
  Vec3 angular_velocity;  ///< rad/s
  double radius = 0;      ///< m
  double density = 0;     ///< kg/m3
  int material = 0;
  SphereKind kind = SphereKind::free;
};

/// State of all spheres at one instant, in ascending id; what results are written from.
struct Snapshot {
  std::vector<std::uint32_t> id;
  std::vector<double> radius;
  std::vector<int> material;
  std::vector<Vec3> position, velocity, angular_velocity;  ///< m, m/s, rad/s, all at t_n
  std::vector<Vec3> force, torque;                         ///< N, N m: contacts and gravity
  std::vector<int> contacts;                               ///< touching neighbours and surfaces
  std::vector<int> bonds;                                  ///< intact ones; empty when no law has any
};

}  // namespace subsoil::dem
