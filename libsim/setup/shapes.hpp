#pragma once
#include <vector>

#include "libdem/geometry/boundary.hpp"
#include "libsim/scenario/sections/machine.hpp"

/// Scenario shapes as surfaces of the bed.
namespace subsoil::sim {

/// Triangles of a shape in the axes of its owner after `at` and `rotation`; a plane and a cylinder have none.
dem::TriangleMesh mesh_of(const Shape& shape, const dem::Pose& placement);

/// A shape for contacts; planes and cylinders stay analytic.
dem::Shape contact_shape(const Shape& shape, const dem::Pose& placement);

bool is_mesh(const Shape& shape);
/// Pictures show it by its own size; not a plane.
bool is_bounded(const Shape& shape);

/// Placement of something at `at`, turned by `rotation`.
dem::Pose placement(const Vec3& at, const Rotation& rotation);

/// Where a surface's shape is in the axes of the body that carries it.
dem::Pose place_in_body(const Surface& surface, const MachineSection& machine);
/// A surface as pictures show it, in the axes of its body.
dem::TriangleMesh drawn_mesh(const Surface& surface, const MachineSection& machine);

/// Triangles for pictures; a plane is a square of side `plane_size`.
dem::TriangleMesh drawing_of(const dem::Shape& shape, double plane_size);

}  // namespace subsoil::sim
