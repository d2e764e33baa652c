#include "apps/build/shapes.hpp"

#include <admesh/stl.h>
#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::app {

dem::Pose placement(const Vec3& at, const Rotation& rotation) {
  const double length = dem::norm(rotation.axis);
  if (rotation.angle == 0 || length == 0) return {at, {}};
  return {at, dem::Quaternion::from_rotation_vector(rotation.axis * (rotation.angle / length))};
}

dem::TriangleMesh read_stl(const std::string& file, double unit) {
  if (!std::filesystem::exists(file)) throw std::runtime_error(file + ": no such file");
  stl_file stl{};
  std::string name = file;
  stl_open(&stl, name.data());
  if (stl_get_error(&stl) != 0 || stl.stats.number_of_facets <= 0) {
    stl_close(&stl);
    throw std::runtime_error(file + ": no STL file that can be read (binary or ASCII triangles are expected)");
  }
  std::vector<std::array<Vec3, 3>> soup;
  for (int i = 0; i < stl.stats.number_of_facets; ++i) {
    std::array<Vec3, 3> t;
    for (std::size_t k = 0; k < 3; ++k) {
      const stl_vertex& v = stl.facet_start[i].vertex[k];
      t[k] = Vec3{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)} * unit;
    }
    soup.push_back(t);
  }
  stl_close(&stl);
  return dem::welded_mesh(soup);
}

namespace {

struct ToMesh {
  dem::TriangleMesh operator()(const PlaneShape&) const { return {}; }
  dem::TriangleMesh operator()(const CylinderShape&) const { return {}; }
  dem::TriangleMesh operator()(const BoxShape& b) const { return dem::box_mesh(b.size); }
  dem::TriangleMesh operator()(const MeshShape& m) const { return read_stl(m.file, m.unit); }
  dem::TriangleMesh operator()(const ExtrudeShape& e) const {
    std::vector<dem::Point2> outline;
    for (const Vec2& p : e.outline) outline.push_back({p[0], p[1]});
    return dem::extruded_mesh(outline, e.width);
  }
};

}  // namespace

bool is_mesh(const Shape& shape) {
  return !std::holds_alternative<PlaneShape>(shape) && !std::holds_alternative<CylinderShape>(shape);
}

dem::TriangleMesh mesh_of(const Shape& shape, const dem::Pose& placed) {
  return std::visit(ToMesh{}, shape).placed(placed);
}

dem::Shape contact_shape(const Shape& shape, const dem::Pose& placed) {
  if (const auto* plane = std::get_if<PlaneShape>(&shape))
    return dem::Plane(placed.to_world(plane->point), placed.attitude.rotate(plane->normal));
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape))
    return dem::Cylinder(placed.position, placed.attitude.rotate(cylinder->axis), cylinder->radius, cylinder->length);
  return dem::MeshSurface(mesh_of(shape, placed));
}

dem::Pose place_in_body(const Surface& surface, const Machine& machine) {
  const dem::Pose place = placement(surface.at, surface.rotation);
  if (surface.placed_in == PlacedIn::body) return place;
  const Body& body = machine.bodies[static_cast<std::size_t>(surface.body_index - 1)];
  const dem::Pose start{{body.at[0], body.at[1], 0}, {std::cos(body.angle / 2), 0, 0, std::sin(body.angle / 2)}};
  return {start.to_local(place.position), start.attitude.conjugate() * place.attitude};
}

dem::TriangleMesh drawn_mesh(const Surface& surface, const Machine& machine) {
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

}  // namespace subsoil::app
