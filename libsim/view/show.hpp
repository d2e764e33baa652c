#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "libsim/view/scene.hpp"

/// The picture of a scenario before it runs.
namespace subsoil::sim {

struct ShowRequest {
  std::string scenario;
  std::vector<std::string> sets;  ///< path=value
  std::filesystem::path out;
};

/// Motion that is known before a run: boundaries on given paths exactly, the machine without the soil's forces.
SceneMotion predicted_motion(const Loaded& loaded);

/// What will run: machine, surfaces, bed as placed or the region that it will fill, motion, warnings of `check`.
Json show_scene(const Loaded& loaded, const ShowRequest& request);

void write_show(const ShowRequest& request);

}  // namespace subsoil::sim
