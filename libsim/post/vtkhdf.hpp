#pragma once
#include <cstddef>
#include <filesystem>
#include <vector>

namespace subsoil::sim {

struct VtkhdfRequest {
  std::filesystem::path run;  ///< results of a run
  std::filesystem::path out;  ///< of the files; empty: vtkhdf in them
};

struct VtkhdfReport {
  std::size_t steps = 0;
  std::vector<std::filesystem::path> files;
};

/// Writes the frames of a run into one VTKHDF file: a collection of polygonal data with a block for the soil, for
/// contact forces and for every surface, and a step for every frame. Numbers keep their type and bits. Memory holds one
/// frame. Throws std::invalid_argument where there are no frames, std::runtime_error with the frame where arrays do not
/// fit together, DiskFault.
VtkhdfReport write_vtkhdf(const VtkhdfRequest& request);

}  // namespace subsoil::sim
