#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

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

/// A run whose spheres are read frame by frame, finished or in progress. Not for two threads at once.
class ServedRun {
 public:
  /// Throws std::invalid_argument for a directory that holds nothing of a run.
  explicit ServedRun(std::filesystem::path run);
  ~ServedRun();
  /// Of `spheres.frames` the times only.
  Json scene();
  /// One of `spheres.frames`, with `low`, `high` and `error` of its coordinates: the box grows with the run. Throws
  /// std::out_of_range where there is none.
  Json frame(std::size_t number);
  /// `progress` of an active run (run_loop.hpp) or null, and `stamp`; unless that is the one given, also `motion`,
  /// `series`, `forces`, `warnings`, times of the `frames` and `count` of the spheres so far.
  Json state(const std::string& stamp);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace subsoil::sim
