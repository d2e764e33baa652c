#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libdem/particles/periodic.hpp"
#include "libsim/post/frames_file.hpp"

namespace subsoil::sim {

/// Of what stands in the soil a part that stands apart across the travel, in the frame of the greatest depth.
struct Shank {
  double from = 0, until = 0;  ///< across the travel, m
  double depth = 0;            ///< m
  /// Angles against the horizontal of the chords from its tip to its front face at heights from a quarter of its depth
  /// up to the surface: minimum and maximum, rad.
  double rake_low = 0, rake_high = 0;
  double width() const { return until - from; }
};

/// What of a machine works in the soil, read off the surfaces in the frames: the surface that reaches deepest below the
/// soil's mean surface, those of its body that reach below it too, and others that reach at least half as deep.
struct ToolPath {
  std::vector<std::size_t> surfaces;  ///< of FramesFile::surfaces()
  std::vector<std::string> names;
  double soil_surface = 0;         ///< y of the soil's mean surface, m
  std::size_t axis = 0;            ///< along which it travels: 0 for x, 2 for z, by which it has gone further
  double direction = 1;            ///< of travel along it, +1 or -1
  std::vector<double> tip, depth;  ///< per frame: lowest point along the axis, m; depth below the surface (< 0: above)
  std::vector<double> rear;        ///< per frame: of what is below the surface, the hindmost along the axis, m
  double middle = 0;               ///< of its width, across the axis, m
  double width = 0;                ///< extent of what is below the surface in the frame of the greatest depth, m
  std::vector<Shank> shanks;       ///< what stands apart in it: two shanks side by side are two
  /// Of the mean of the tool's vertices along the axis while the tip is below the surface, m, >= 0: between two frames
  /// the depth is linear.
  double travel = 0;
  double speed = 0;                    ///< mean over that time, m/s
  std::vector<double> times;           ///< of the frames, s
  double rake_low = 0, rake_high = 0;  ///< of all shanks: minimum and maximum, rad

  std::size_t across() const { return 2 - axis; }
  /// Share of the frames' time between two instants in which the tip is not below the surface; 0 without such time.
  double share_out(double from, double until) const;
  /// tip at a time, linear between frames.
  double tip_at(const std::vector<double>& times, double time) const;
};

/// Empty where no moving surface comes below the soil's surface. `body_of`: of a surface by its name, where known.
/// `cell`: the bed's periodic sides, beyond which a tool works no soil.
std::optional<ToolPath> tool_path(const SurfaceSamples& file, double soil_surface,
                                  const std::map<std::string, std::string>& body_of = {},
                                  const dem::PeriodicCell& cell = {});

}  // namespace subsoil::sim
