#include "apps/run/wall_watch.hpp"

#include <algorithm>

namespace subsoil::app {

void WallWatch::begin(const World& world) {
  const auto spheres = world.bed->spheres();
  if (spheres.empty()) return;
  std::uint32_t most = 0;
  radius_ = 0;
  for (const dem::Sphere& s : spheres) {
    most = std::max(most, s.id);
    radius_ += s.r / static_cast<double>(spheres.size());
  }
  lay_.assign(most + 1, {});
  for (const dem::Sphere& s : spheres) lay_[s.id] = s.x;
  for (const SurfaceRecord& r : world.surfaces) {
    const dem::Boundary& b = world.bed->boundary(r.boundary);
    if (r.owner != SurfaceRecord::Owner::container || !b.active) continue;
    Wall wall{r.name, {}};
    for (const dem::Sphere& s : spheres) {
      const double near = s.r + 2 * radius_;
      std::vector<std::uint32_t> triangles;
      const Vec3 c = b.pose.to_local(s.x);
      dem::candidates(b.shape, c, near, triangles);
      dem::SurfaceContact touch[1];
      if (!triangles.empty() && dem::contacts(b.shape, c, near, triangles, touch, 1) > 0) wall.ids.push_back(s.id);
    }
    walls_.push_back(std::move(wall));
  }
}

std::vector<std::string> WallWatch::look(const World& world) {
  std::vector<char> displaced(lay_.size());
  for (const dem::Sphere& s : world.bed->spheres())
    if (s.id < lay_.size()) displaced[s.id] = dem::norm(s.x - lay_[s.id]) > moved * radius_;
  std::vector<std::string> reached;
  for (Wall& wall : walls_) {
    const auto count = std::count_if(wall.ids.begin(), wall.ids.end(), [&](std::uint32_t id) { return displaced[id]; });
    if (wall.reached || static_cast<double>(count) <= share * static_cast<double>(wall.ids.size())) continue;
    wall.reached = true;
    reached.push_back(wall.name);
  }
  return reached;
}

}  // namespace subsoil::app
