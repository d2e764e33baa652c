#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libdem/particles/periodic.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/post/tool_path.hpp"

namespace subsoil::sim {

/// What became of a layer of soil in the stretch that the tool has passed.
struct LayerMotion {
  std::string name;  ///< material, or range of depth before the pass
  std::size_t spheres = 0;
  double rise = 0;             ///< mean, m, up
  double forward = 0;          ///< mean, m, along the travel
  double aside = 0;            ///< mean, m, away from the middle of the tool
  double moved_out = 0;        ///< share that lies in another layer's depth afterwards
  std::vector<double> into{};  ///< share that lies in the depth of each layer afterwards
};

/// Cross-section across the travel, mean over a stretch that the tool has passed: between the first frame and the last.
struct Furrow {
  char along = 'x', across = 'z';        ///< the axes, as the tool travels
  double from = 0, until = 0;            ///< m; the stretch along the travel
  bool steady = false;                   ///< it lies in steady work; else it begins half a depth past the near face
  double cell = 0;                       ///< m; mean diameter of the spheres
  double column = 0;                     ///< m; width of a column across, so that whole ones fill the bed
  std::vector<double> z, before, after;  ///< middle of a column and height of the surface there, m; NaN: empty
  double furrow_area = 0;                ///< m^2 below the surface before
  double heap_area = 0;                  ///< m^2 above it
  double heave = 0;                      ///< m; maximum rise of a column's surface
  double depth = 0;                      ///< m; maximum drop
  double width = 0;                      ///< m; of the columns that dropped by more than a tenth of a cell
  double ridge_to_ridge = 0;             ///< m; between the highest columns on both sides of the tool; NaN without two
  double threshold = 0;                  ///< m; disturbed is a cell whose spheres have moved by more on average
  double disturbed_area = 0;             ///< m^2
  double loosened_area = 0;              ///< m^2; cells whose porosity has risen by more than `loosening`
  static constexpr double loosening = 0.02;
  double swell = 0;  ///< (heaps - furrow) over the disturbed area: by how much its volume has grown
  std::size_t rows = 0, columns = 0;
  double y0 = 0, z0 = 0;      ///< lower corner of the grid, m
  std::vector<double> moved;  ///< per cell (row by row from below): mean displacement, m; NaN: empty
  /// Per cell: rise of the porosity at its place, coarse-grained by Lucy's kernel of width one cell (zero two cells
  /// away) and averaged along the stretch; NaN within one cell of the surface before or after.
  std::vector<double> loosened;
  std::vector<LayerMotion> layers;  ///< from above
};

/// Empty with the reason in `why` where the tool has not passed far enough. `steady_from`: time at which steady work
/// begins, NaN where that is not known. Where too little of it is passed the stretch begins half a depth past the
/// soil's near face, or past where the rear of a tool that starts in the soil stood. `cell`: the bed's periodic sides,
/// on which spheres have taken the shortest way from their first place to the last.
std::optional<Furrow> furrow(const FramesFile& file, const ToolPath& tool, double steady_from,
                             const dem::PeriodicCell& cell, std::string& why);

}  // namespace subsoil::sim
