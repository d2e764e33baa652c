#include "libsim/run/surface_meeting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libdem/geometry/world_box.hpp"

namespace subsoil::sim {
namespace {

/// Over the way that a boundary goes, or that a body goes at its velocity.
dem::Bounds swept(const World& world, int boundary, const Vec3& velocity, double time) {
  const dem::Boundary& b = world.bed->boundary(boundary);
  const dem::Bounds own = dem::bounds(b.shape);
  dem::Bounds out = dem::world_box(own, b.pose);
  dem::Bounds later = out;
  later.low += time * velocity, later.high += time * velocity;
  out.include(later);
  constexpr int places = 100;
  for (const coupling::GivenMotion& m : world.motions)
    for (int k = 1; m.boundary == boundary && k <= places; ++k)
      out.include(dem::world_box(own, m.pose(time * k / places)));
  return out;
}

}  // namespace

const char* const surface_meeting_cure =
    "neither feels the other; make the stone of fixed spheres (`soil.bed.particles`, `fixed: NAME`), or give the "
    "machine "
    "a contact (`machine.forces`), or keep them apart";

SurfaceMeeting::SurfaceMeeting(const World& world) {
  if (!world.bed) return;
  for (const SurfaceRecord& s : world.surfaces) {
    if (s.owner == SurfaceRecord::Owner::container) continue;
    auto& to = s.owner == SurfaceRecord::Owner::machine ? tools_ : stones_;
    if (s.mesh == 0) to.push_back({s.name, s.boundary, s.body, dem::SolidOutline(world.bed->boundary(s.boundary))});
  }
  if (stones_.empty()) tools_.clear();
}

std::optional<std::string> SurfaceMeeting::look() const {
  for (const One& tool : tools_)
    for (const One& stone : stones_)
      if (tool.outline.meets(stone.outline))
        return fmt::format("the machine's surface `{}` has come into the boundary `{}`", tool.name, stone.name);
  return {};
}

std::vector<std::string> SurfaceMeeting::may_meet(const World& world, double time) const {
  std::vector<std::string> out;
  for (const One& tool : tools_)
    for (const One& stone : stones_) {
      const mbd::BodyState& body = world.machine->body(tool.body);
      const dem::Bounds a = swept(world, tool.boundary, {body.v.x, body.v.y, 0}, time);
      const dem::Bounds b = swept(world, stone.boundary, {}, time);
      bool apart = false;
      for (int d = 0; d < 3; ++d) apart = apart || a.high[d] < b.low[d] || b.high[d] < a.low[d];
      if (!apart)
        out.push_back(fmt::format("the machine's surface `{}` may come into the boundary `{}`, where the run stops: {}",
                                  tool.name, stone.name, surface_meeting_cure));
    }
  return out;
}

}  // namespace subsoil::sim
