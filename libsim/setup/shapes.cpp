#include "libsim/setup/shapes.hpp"

#include <cmath>

namespace subsoil::sim {

dem::Pose placement(const Vec3& at, const Rotation& rotation) {
  const double length = dem::norm(rotation.axis);
  if (rotation.angle == 0 || length == 0) return {at, {}};
  return {at, dem::Quaternion::from_rotation_vector(rotation.axis * (rotation.angle / length))};
}

bool is_mesh(const Shape& shape) {
  return std::visit([]<class S>(const S&) { return Triangulated<S>; }, shape);
}

bool is_bounded(const Shape& shape) {
  return std::visit([]<class S>(const S&) { return S::bounded; }, shape);
}

dem::TriangleMesh mesh_of(const Shape& shape, const dem::Pose& placed) {
  return std::visit(
      [&]<class S>(const S& given) -> dem::TriangleMesh {
        if constexpr (Triangulated<S>) return given.mesh().placed(placed);
        return {};
      },
      shape);
}

dem::Shape contact_shape(const Shape& shape, const dem::Pose& placed) {
  return std::visit(
      [&]<class S>(const S& given) -> dem::Shape {
        if constexpr (Triangulated<S>) {
          return dem::MeshSurface(given.mesh().placed(placed));
        } else {
          return given.surface(placed);
        }
      },
      shape);
}

dem::Pose place_in_body(const Surface& surface, const MachineSection& machine) {
  const dem::Pose place = placement(surface.at, surface.rotation);
  if (surface.placed_in == PlacedIn::body) return place;
  const BodySection& body = machine.bodies[static_cast<std::size_t>(surface.body_index - 1)];
  const dem::Pose start{{body.at[0], body.at[1], 0}, {std::cos(body.angle / 2), 0, 0, std::sin(body.angle / 2)}};
  return {start.to_local(place.position), start.attitude.conjugate() * place.attitude};
}

dem::TriangleMesh drawn_mesh(const Surface& surface, const MachineSection& machine) {
  const dem::Pose place = place_in_body(surface, machine);
  return is_mesh(surface.shape) ? mesh_of(surface.shape, place) : drawing_of(contact_shape(surface.shape, place), 1.0);
}

dem::TriangleMesh drawing_of(const dem::Shape& shape, double plane_size) {
  std::vector<Vec3> vertices;
  std::vector<dem::Triangle> triangles;
  for (const dem::TriangleMesh& mesh : dem::drawing(shape, plane_size)) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), mesh.vertices().begin(), mesh.vertices().end());
    for (const dem::Triangle& t : mesh.triangles()) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return {std::move(vertices), std::move(triangles)};
}

}  // namespace subsoil::sim
