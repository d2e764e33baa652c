#include "libsim/run/wall_watch.hpp"

#include <algorithm>

#include "libsim/scenario/sections/soil.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {

namespace {

bool lies_at(const dem::Boundary& b, const Vec3& x, double near) {
  std::vector<std::uint32_t> triangles;
  const Vec3 c = b.pose.to_local(x);
  dem::candidates(b.shape, c, near, triangles);
  dem::SurfaceContact touch[1];
  return !triangles.empty() && dem::contacts(b.shape, c, near, triangles, touch, 1) > 0;
}

}  // namespace

void WallWatch::begin(const World& world) {
  const auto spheres = world.bed->spheres();
  if (spheres.empty()) return;
  if (world.moving) return begin(world, world.moving->window);
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
    for (const dem::Sphere& s : spheres)
      if (lies_at(b, s.x, s.r + 2 * radius_)) wall.ids.push_back(s.id);
    walls_.push_back(std::move(wall));
  }
}

/// By the place in the period: each lies at floor and side walls alike. Walls at the ends touch held spheres
/// only.
void WallWatch::begin(const World& world, const dem::MovingBed& window) {
  const std::size_t count = window.block().size();
  lay_.assign(count, {});
  radius_ = 0;
  for (std::size_t i = 0; i < count; ++i) radius_ += window.block().sphere(i).r / static_cast<double>(count);
  for (const SurfaceRecord& r : world.surfaces) {
    const dem::Boundary& b = world.bed->boundary(r.boundary);
    if (r.owner != SurfaceRecord::Owner::container || !b.active || r.name == wall_name(0) || r.name == wall_name(1))
      continue;
    Wall wall{r.name, {}};
    for (std::uint32_t i = 0; i < count; ++i) {
      Vec3 place = window.place_at_rest(i);
      place.x = 0.5 * (window.rear() + window.front());  // between the ends of the walls
      if (lies_at(b, place, window.block().sphere(i).r + 2 * radius_)) wall.ids.push_back(i);
    }
    walls_.push_back(std::move(wall));
  }
  walls_.push_back({"the end of the window ahead", {}});
}

/// Of all spheres in the window, those that left the place where they had been at rest.
std::vector<std::string> WallWatch::look(const World& world, const dem::MovingBed& window) {
  std::vector<std::size_t> near(walls_.size()), displaced(walls_.size());
  const double ahead = window.front() - window.plan().direction * 2 * radius_;
  for (const dem::Sphere& s : world.bed->spheres()) {
    if (dem::is_fixed(s)) continue;
    const Vec3 lay = window.place_at_rest(s.id);
    const bool gone = dem::norm(s.x - lay) > moved * radius_;
    const auto place = static_cast<std::uint32_t>(window.place_in_block(s.id));
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      const bool at = w + 1 == walls_.size() ? window.plan().direction * (lay.x - ahead) > 0
                                             : std::binary_search(walls_[w].ids.begin(), walls_[w].ids.end(), place);
      near[w] += at, displaced[w] += at && gone;
    }
  }
  std::vector<std::string> reached;
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    if (walls_[w].reached || static_cast<double>(displaced[w]) <= share * static_cast<double>(near[w])) continue;
    walls_[w].reached = true;
    reached.push_back(walls_[w].name);
  }
  return reached;
}

std::optional<bool> WallWatch::any_reached() const {
  if (!has_begun()) return std::nullopt;
  return std::any_of(walls_.begin(), walls_.end(), [](const Wall& wall) { return wall.reached; });
}

std::vector<std::string> WallWatch::look(const World& world) {
  if (world.moving) return look(world, world.moving->window);
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

}  // namespace subsoil::sim
