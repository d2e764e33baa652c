#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/base/symmetric_eigen.hpp"
#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// A sphere of a clump.
struct ClumpMember {
  Vec3 at;            ///< centre, m
  double radius = 0;  ///< m
  void archive(Archive& a) { a("at", at)("radius", radius); }
};

/// A rigid grain made of spheres that touch or overlap (multi-sphere particle), in its principal axes about its centre
/// of mass.
///
/// Mass, centre and inertia are those of the union of the spheres, matter that two of them share counted once
/// (geometry/sphere_union.hpp states how exactly), or those that are given.
struct ClumpShape {
  std::string name;
  std::vector<ClumpMember> members;  ///< principal axes, from the centre of mass
  double mass = 0;                   ///< kg
  Vec3 inertia;                      ///< principal moments, kg m2
  double volume = 0;                 ///< of the union, m3
  double error = 0;                  ///< bound on the relative error of volume and moments; 0: exact, or given
  double reach = 0;                  ///< radius of the sphere about the centre of mass that holds all of it, m
  Vec3 centre;                       ///< centre of mass in the axes in which the members were given, m
  Quaternion axes;                   ///< from the principal axes to these

  void archive(Archive& a);
};

/// Mass properties as measured, in place of those of the union.
struct GivenMass {
  double mass = 0;             ///< kg
  std::optional<Vec3> centre;  ///< m, axes of the members; else of the union
  /// About the centre, kg m2, symmetric; else of the union, in proportion to the mass.
  std::optional<SquareMatrix<3>> inertia;
};

/// Throws std::invalid_argument for spheres without sense or an inertia that no body has.
ClumpShape clump_shape(std::string name, const std::vector<ClumpMember>& members, double density,
                       const std::optional<GivenMass>& given = {});

/// How the mass is divided among the spheres where results need it sphere by sphere: by their volumes.
std::vector<double> shares_by_volume(const ClumpShape& shape);

double widest_gap(const ClumpShape& shape);  ///< between centres of two of its spheres, at most, m

/// A clump as the user gives it: the centre of mass and the principal axes.
struct ClumpSpec {
  int shape = 0;          ///< index of its shape in the bed
  Vec3 position;          ///< of the centre of mass, m
  Quaternion attitude;    ///< principal axes to world axes
  Vec3 velocity;          ///< of the centre of mass, m/s, at t = 0
  Vec3 angular_velocity;  ///< rad/s, world axes
  int material = 0;       ///< of all its spheres
  /// Number of its first sphere, and its own; the other spheres follow. Left out: the next numbers.
  std::optional<std::uint32_t> number{};
};

/// State of a clump in the bed.
struct Clump {
  std::uint32_t id = 0;            ///< number of the clump, kept for life
  std::uint32_t shape = 0;         ///< index of its shape
  std::uint32_t first_sphere = 0;  ///< id of its first member; the others follow
  std::uint16_t material = 0;
  Vec3 position;          ///< of the centre of mass, m, at t_n
  Vec3 velocity;          ///< m/s, at t_n - dt/2 (leapfrog)
  Quaternion attitude;    ///< principal axes to world axes, at t_n
  Vec3 angular_momentum;  ///< about the centre of mass, N m s, world axes, at t_n - dt/2

  void archive(Archive& a) {
    a("id", id)("shape", shape)("first sphere", first_sphere)("material", material);
    a("attitude", attitude)("position", position)("velocity", velocity)("angular momentum", angular_momentum);
  }
};

}  // namespace subsoil::dem
