#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// One contact of a sphere with the surface of a body: a local minimum of the distance from the sphere's centre.
/// Overlap of a sphere of radius r is r - distance; it is negative across a gap.
struct SurfaceContact {
  Vec3 point;            ///< on the surface, in the axes of the query
  Vec3 normal;           ///< unit, from the surface to the centre; outward when the centre is inside a closed body
  double distance = 0;   ///< from the surface to the centre; negative inside a closed body
  uint32_t feature = 0;  ///< flat face, straight edge or vertex; the same across the triangles of one flat face
  uint32_t surface = 0;  ///< index of the body's surface that carries the point
};

/// A flat face that is all a sphere can touch of a body for a while; axes of the body.
struct FlatFace {
  Vec3 normal;           ///< unit, to the side of the sphere
  double offset = 0;     ///< m: the face is normal . x = offset
  uint32_t surface = 0;  ///< index of the body's surface that it belongs to
};

/// Pairs the contacts of now with those of the step before so that a history follows its contact across triangles,
/// edges and vertices: from[i] = index of the previous contact that now[i] continues, or -1.
///
/// The normal identifies a contact: two contacts of one centre with one body cannot lie in the same direction, since
/// the nearer one would hide the other, and the direction of a contact changes continuously while its feature jumps.
/// So each previous contact goes to the contact whose normal is nearest, the closest pairs first; a normal that turned
/// by more than 60 degrees in one step is another contact. All normals in one frame.
void match_contacts(std::span<const SurfaceContact> now, std::span<const Vec3> previous_normals, int* from);

}  // namespace subsoil::dem
