#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/report/frames_file.hpp"

namespace subsoil::app {

/// What of a machine works in the soil, read off the surfaces in the frames: the surface that reaches deepest below the
/// soil's mean surface, those of its body that reach below it too, and others that reach at least half as deep.
struct ToolPath {
  std::vector<std::size_t> surfaces;  ///< of FramesFile::surfaces()
  std::vector<std::string> names;
  double soil_surface = 0;           ///< y of the soil's mean surface, m
  double direction = 1;              ///< of travel along x, +1 or -1
  std::vector<double> tip_x, depth;  ///< per frame: lowest point, m; depth below the surface (negative: above)
  std::vector<double> rear_x;        ///< per frame: of what is below the surface, its hindmost x
  double z = 0;                      ///< middle of its width, m
  double width = 0;                  ///< of what is below the surface in the frame of the greatest depth, m
  double speed = 0;                  ///< mean speed of the tip along x over the record, m/s
  /// Angles against the horizontal of the chords from the tip to the tool's front face at heights from a quarter of the
  /// depth up to the surface: least and largest, rad.
  double rake_low = 0, rake_high = 0;

  /// tip_x at a time, linear between frames.
  double tip_at(const std::vector<double>& times, double time) const;
};

/// Empty where no moving surface comes below the soil's surface. `body_of`: of a surface by its name, where known.
std::optional<ToolPath> tool_path(const FramesFile& file, double soil_surface,
                                  const std::map<std::string, std::string>& body_of = {});

}  // namespace subsoil::app
