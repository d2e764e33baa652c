#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libsim/plot/canvas.hpp"

/// `subsoil plot DIR --strip N`: the mechanism of a run drawn at N instants, its modes, or its pose before and after.
namespace subsoil::sim {

struct StripOptions {
  int count = 8;                   ///< instants, evenly spread over the run; of modes, at most so many
  std::vector<double> times;       ///< s; given instants instead
  std::vector<std::string> paths;  ///< markers and bodies whose paths are drawn; empty: markers of moving bodies
  std::string follow;              ///< body that stays in its place in every picture; empty: none
  int width = 1100;                ///< pixels
};

/// Runs in time: positions side by side on one scale, with time, path and a scale bar. Modes: every shape about the
/// equilibrium in grey, so large that it moves by a tenth of the machine; the factor on the table's shape is stated.
/// Equilibrium, assembly: the pose found, the given one in grey. The kind of file by suffix (.png .svg .pdf). Throws
/// std::runtime_error with the cure when the directory holds no run of a machine, or a name or time is not in it.
void strip(const std::filesystem::path& run, const std::filesystem::path& out, const StripOptions& = {});

/// The same instants of a run in time one by one, on one scale: the pictures of a film.
void each_instant(const std::filesystem::path& run, const StripOptions& options,
                  const std::function<void(const Canvas&)>& take);

/// True for runs that have no course over time to be plotted: modes, equilibrium, assembly.
bool is_still(const std::filesystem::path& run);

}  // namespace subsoil::sim
