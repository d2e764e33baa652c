#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libdem/geometry/triangle_mesh.hpp"
#include "libsim/post/run_folder.hpp"

/// What a run has worn off its surfaces, by triangle.
namespace subsoil::sim {

enum class WearLaw { archard, finnie };

/// A surface with wear, in the axes of its shape: before `at` and `rotation`.
struct WornSurface {
  std::string name;
  std::string key;              ///< of the scenario: machine.surfaces.shank, boundaries.plate
  dem::TriangleMesh mesh;       ///< as the run had it
  std::vector<double> volumes;  ///< m^3 of the run, by triangle
  double volume = 0;            ///< m^3, as summary.json has it
  double share = 1;             ///< of it that had come by the last frame, whose distribution this is
  double density = 0;           ///< kg/m^3
  WearLaw law = WearLaw::archard;
};

/// Surfaces of a run with wear. A shape without triangles is that which draws it.
/// @param law of surfaces with constants of both; without it they are refused
/// Throws std::invalid_argument, with the cure, where a run has no wear, no frames, or no constants of the law.
std::vector<WornSurface> worn_surfaces(const RunFolder& run, std::optional<WearLaw> law);

/// The strip that a run has worked.
struct WorkedStrip {
  double width = 0, length = 0;  ///< m
  std::string source;            ///< where both come from
  double hectares() const { return 1e-4 * width * length; }
};
/// Of options where they are given, else of the frames: the extent of the tool in the soil across its travel, and its
/// travel. Throws std::invalid_argument where frames show no tool that travels in soil.
WorkedStrip worked_strip(const RunFolder& run, std::optional<double> width, std::optional<double> length);

/// A scenario in which these surfaces are mesh files. `files`: one per surface, absolute.
Scenario with_meshes(Scenario scenario, const std::vector<WornSurface>& surfaces,
                     const std::vector<std::string>& files);
/// The same as values of `--set`.
std::vector<std::string> sets_of_meshes(const Scenario& scenario, const std::vector<WornSurface>& surfaces,
                                        const std::vector<std::string>& files);

}  // namespace subsoil::sim
