#pragma once
#include <variant>

#include "libsim/scenario/shapes/box.hpp"
#include "libsim/scenario/shapes/cylinder.hpp"
#include "libsim/scenario/shapes/extrude.hpp"
#include "libsim/scenario/shapes/mesh.hpp"
#include "libsim/scenario/shapes/plane.hpp"

/// The list of shapes that a scenario can give: a new one is its own file and one word here. Reader, checks, pictures
/// and the bed work from it. One whose contacts are neither those of triangles nor of another shape is a class of
/// libdem/geometry besides.
namespace subsoil::sim {

template <class... S>
struct ShapeList {
  static_assert(((Triangulated<S> != Analytic<S>)&&...), "a shape has either mesh() or surface(pose)");
  using type = std::variant<S...>;
};
using Shape = ShapeList<PlaneShape, BoxShape, CylinderShape, MeshShape, ExtrudeShape>::type;

struct Checks;
/// What is wrong with a shape beyond the ranges of its keys.
void check_shape(Checks& checks, const std::string& path, const Shape& shape);

}  // namespace subsoil::sim
