#include "libsim/run/body_watch.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace subsoil::sim {

BodyWatch::BodyWatch(const Scenario& scenario, const World& world) : world_(world) {
  if (!world.bed || !world.machine || !scenario.soil || !scenario.soil->container || world.moving) return;
  const Container& c = *scenario.soil->container;
  low_ = c.at + Vec3{0, world.container_shift, 0}, high_ = low_ + c.size;
  for (std::size_t f = 0; f < closed_.size(); ++f) closed_[f] = keeps_wall(c, f);
  double smallest = 0;
  for (const dem::Sphere& s : world.bed->spheres()) smallest = smallest > 0 ? std::min(smallest, s.r) : s.r;
  margin_ = 0.01 * smallest;
  for (std::size_t k = 0; k < world.surfaces.size(); ++k) {
    const SurfaceRecord& s = world.surfaces[k];
    if (s.owner != SurfaceRecord::Owner::machine) continue;
    all_.push_back(
        {.surface = k, .points = dem::drawing(world.bed->boundary(s.boundary).shape, 1.0)[s.mesh].vertices()});
  }
}

std::array<bool, 6> BodyWatch::beyond(const Watched& one, const coupling::Simulation& simulation) const {
  const SurfaceRecord& s = world_.surfaces[one.surface];
  const dem::Pose pose = simulation.surface_pose(s.boundary);
  std::array<bool, 6> out{};
  for (const Vec3& point : one.points) {
    const Vec3 p = pose.to_world(point);
    std::array<bool, 3> between{};
    for (int d = 0; d < 3; ++d) between[static_cast<std::size_t>(d)] = p[d] > low_[d] && p[d] < high_[d];
    for (std::size_t f = 0; f < out.size(); ++f) {
      const std::size_t d = f / 2;
      if (!between[(d + 1) % 3] || !between[(d + 2) % 3]) continue;  // past the edges of the face
      const double x = p[static_cast<int>(d)];
      out[f] =
          out[f] || (f % 2 == 0 ? x < low_[static_cast<int>(d)] - margin_ : x > high_[static_cast<int>(d)] + margin_);
    }
  }
  return out;
}

std::vector<std::string> BodyWatch::look(const coupling::Simulation& simulation) {
  std::vector<std::string> said;
  for (Watched& one : all_) {
    const std::array<bool, 6> now = beyond(one, simulation);
    for (std::size_t f = 0; f < now.size(); ++f) {
      if (!now[f] || !closed_[f] || one.through[f]) continue;
      one.through[f] = true;
      if (!begun_) continue;
      const SurfaceRecord& s = world_.surfaces[one.surface];
      said.push_back(
          fmt::format("`{}` of `{}` reaches through the {} of the container: bodies of the machine meet spheres alone, "
                      "and go through walls; keep it inside, or open that side",
                      s.name, world_.machine->system().body_name(s.body), wall_name(f)));
    }
  }
  begun_ = true;
  return said;
}

void BodyWatch::archive(Archive& a) {
  a("begun", begun_);
  for (Watched& one : all_)
    for (bool& through : one.through) a("through", through);
}

}  // namespace subsoil::sim
