#pragma once
#include <concepts>
#include <string>

#include "libdem/geometry/shapes.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/scenario/sections/defaults.hpp"

/// What a shape of the scenario is: parameters with a card, and what the bed is to touch.
namespace subsoil::sim {

/// A key of a shape and what is wrong with its value beyond the range of the key; `rule` empty: nothing.
struct ShapeFault {
  std::string key, rule;
};
inline ShapeFault direction_fault(const char* key, const Vec3& direction) {
  return direction == Vec3{} ? ShapeFault{key, "a direction must not be the zero vector"} : ShapeFault{};
}

template <class S>
concept Described = requires(S& s, const S& given, Fields& v) {
  s.describe(v);
  { given.fault() } -> std::same_as<ShapeFault>;
  requires std::same_as<decltype(S::bounded), const bool>;  // pictures show it by its own size
};
/// Given by triangles in its own axes. Meshes of one body and material act as one surface.
template <class S>
concept Triangulated = Described<S> && requires(const S& given) {
  { given.mesh() } -> std::same_as<dem::TriangleMesh>;
};
/// Touched without triangles.
template <class S>
concept Analytic = Described<S> && requires(const S& given, const dem::Pose& placed) {
  { given.surface(placed) } -> std::same_as<dem::Shape>;
};

}  // namespace subsoil::sim
