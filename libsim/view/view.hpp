#pragma once
#include <filesystem>

#include "libsim/view/scene.hpp"

/// The picture of a run: what its folder holds.
namespace subsoil::sim {

struct ViewRequest {
  std::filesystem::path run;
  std::filesystem::path out;
  double bytes = 48e6;  ///< of the spheres in the page; frames are left out until they fit
};

Json view_scene(const ViewRequest& request);

void write_view(const ViewRequest& request);

}  // namespace subsoil::sim
