#pragma once
#include <string>
#include <vector>

#include "libsim/setup/world.hpp"

/// What `check` prints of the surfaces that a scenario names, and what both `check` and `run` warn of.
namespace subsoil::sim {

struct SurfaceFacts {
  std::string name;
  Vec3 low, high;             ///< box around it in the world, at the start; infinite for a plane
  std::size_t triangles = 0;  ///< 0: a plane or a cylinder
  bool from_file = false;     ///< its unit is a guess: a file of triangles has none
  bool closed = true;         ///< has an inside; planes and cylinders have
  double from_soil = 0;       ///< m between the boxes of surface and soil, the minimum along a given path; 0: they meet
  bool below = false;         ///< wholly below the soil where gravity acts down: soil may fall onto it
  bool servo = false;         ///< its path is that at the speed limit of its servo: the farthest it may come
  bool path_known = true;     ///< no: a body's surface; what is known of it is the start
};

/// Of bodies' and given surfaces; the container's own walls are not among them.
std::vector<SurfaceFacts> surface_facts(const World& world, const Scenario& scenario, double end);

/// "blade: 0.02 x 0.26 x 0.03 m, 12 triangles, closed, 0.015 m from the soil at the start"
std::string surface_text(const SurfaceFacts& facts, const World& world);

/// A unit that cannot be right, a mesh that is open, a path that never meets the soil, a body too light for its law.
std::vector<std::string> surface_warnings(const std::vector<SurfaceFacts>& facts, const World& world);

}  // namespace subsoil::sim
