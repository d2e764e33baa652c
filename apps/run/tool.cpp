#include "apps/run/tool.hpp"

#include <algorithm>

namespace subsoil::app {

ToolProgress::ToolProgress(const World& world) : world_(world) {
  if (!world.bed || !world.machine) return;
  for (const SurfaceRecord& s : world.surfaces) {
    const auto* mesh = std::get_if<dem::MeshSurface>(&world.bed->boundary(s.boundary).shape);
    if (s.owner != SurfaceRecord::Owner::machine || mesh == nullptr) continue;
    Part part{s.body, {}};
    const dem::TriangleMesh& m = mesh->surfaces()[s.mesh];
    part.vertices.insert(part.vertices.end(), m.vertices().begin(), m.vertices().end());
    parts_.push_back(std::move(part));
  }
  if (parts_.empty() || world.bed->spheres().empty()) return;
  if (world.machine->body(parts_.front().body).v.x < 0) direction_ = -1;
  double low = 1e300, high = -1e300;
  for (const dem::Sphere& s : world.bed->spheres()) {
    low = std::min(low, s.x.x - s.r);
    high = std::max(high, s.x.x + s.r);
  }
  near_face_ = direction_ > 0 ? low : -high;
  far_face_ = direction_ > 0 ? high : -low;
  surface_ = world.soil.surface_mean;
}

ToolProgress::Place ToolProgress::place() const {
  Place out;
  out.tip.y = 1e300;
  double low = 1e300, high = -1e300;
  for (const Part& part : parts_) {
    const mbd::BodyState& body = world_.machine->body(part.body);
    const dem::Pose pose = coupling::pose_of(body);
    for (const Vec3& v : part.vertices) {
      const Vec3 p = pose.to_world(v);
      if (p.y < out.tip.y) out.tip = p, out.speed = direction_ * body.v.x;
      if (p.y > surface_) continue;
      low = std::min(low, direction_ * p.x);
      high = std::max(high, direction_ * p.x);
    }
  }
  out.depth = surface_ - out.tip.y;
  out.length = std::max(0.0, high - low);
  return out;
}

std::optional<double> ToolProgress::window_opens() const {
  const Place p = place();
  const double x = direction_ * p.tip.x;
  if (!(p.depth > 0) || x - near_face_ < p.length + p.depth || !(p.speed > 0)) return {};
  return std::max(0.0, far_face_ - p.depth - x) / p.speed;
}

double ToolProgress::time_to_soil() const {
  const Place p = place();
  const double way = near_face_ - direction_ * p.tip.x;
  return way > 0 && p.speed > 0 ? way / p.speed : 0;
}

}  // namespace subsoil::app
