#pragma once
#include <array>
#include <optional>

#include "libdem/packing/settle.hpp"
#include "libsim/io/bed_file.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Throws std::invalid_argument. @param density of its matter, kg/m3, where the section gives no mass
dem::ClumpShape clump_shape_of(const ClumpSection& clump, double density);
dem::ShareOf shares_of(ShareOf s);
/// A distribution of the scenario as the bed takes it.
dem::RadiusDistribution sizes_of(const RadiusDistribution& sizes);
/// Shares of clumps as the bed takes them, once it has their shapes.
std::vector<dem::ClumpPart> parts_of(const std::vector<ClumpShare>& clumps, const Scenario& s, const dem::Bed& bed);

/// Makes the bed of a scenario in the order in which it must be made: walls and spheres, settling, datum, opened walls,
/// and room for the machine.
class SoilBuilder {
 public:
  SoilBuilder(World& world, const Loaded& loaded, const BuildOptions& options);

  /// Container walls, and spheres unless they are rained later.
  void place();
  /// Container walls alone, where they stand when the run begins.
  void place_walls();
  bool settles() const;
  /// Whether the bed stands as it was poured, above where it will lie: `check` and pictures do not settle it.
  bool is_loose() const;
  void settle(double step);
  /// Report, shift to the datum, saved bed, opened walls.
  void finish();
  /// A bed whose surface lies more than a radius from the datum of a wheel's law is refused.
  void check_wheel_datum() const;
  /// How many spheres a random bed will have, about: what fills its depth at a solid fraction of 0.61, less a sixth of
  /// a diameter at walls, floor and surface, where spheres stand less dense. Within some percent
  /// (docs/reference/command-line.md).
  double expected_spheres() const;
  /// What the stable step must be asked for while there are no spheres yet.
  dem::StepQuestion question() const;

 private:
  const BedSection& bed() const { return *loaded_.scenario.soil->bed; }
  bool has_bed() const { return loaded_.scenario.soil && loaded_.scenario.soil->bed; }
  bool rains() const { return has_bed() && bed().fill == Fill::random && options_.place_soil; }
  void add_walls();
  void add_plate();
  void shift_walls();
  void open_walls();
  void shape_walls(double extra_height);
  dem::Bounds region() const;
  dem::Bounds measured() const;
  Directions periodic_region() const;
  dem::BedMaterial material_of(const std::string& name) const;
  dem::BedMaterial material() const { return material_of(bed().material); }
  bool layered() const { return has_bed() && !bed().layers.empty(); }
  std::vector<dem::BedLayer> layers() const;
  std::vector<dem::LatticeLayer> lattice_layers(const std::vector<dem::BedLayer>& layers, bool at_rest) const;
  double depth_of_layers() const;
  void place_layers(bool at_rest);
  void assign_layers(std::vector<dem::SphereSpec>& spheres);
  void place_stand_in();
  void add_shapes();
  double density_of(const ClumpSection& clump) const;
  void place_clumps();
  void clear_stones();
  bool has_fibres() const { return has_bed() && !bed().fibres.empty(); }
  void lay_fibres();
  void raise_walls(double height);
  void extend_layers();
  double expected_grains() const;
  double expected_grains(const dem::BedLayer& layer) const;
  bool has_clumps() const { return has_bed() && any_clumps(bed()); }
  dem::RadiusDistribution sizes() const;
  dem::RadiusDistribution sizes_among(const std::vector<ClumpShare>& clumps, const RadiusDistribution& radius) const;
  double radius_of_mean_grain() const;
  double spheres_per_grain(const std::vector<dem::ClumpPart>& clumps) const;
  std::vector<dem::ClumpPart> parts() const;
  void name_fixed();
  void place_made();
  void refuse_too_deep() const;
  void refuse_too_many() const;
  dem::RandomFill random_fill() const;
  dem::RandomFill from_floor(dem::RandomFill fill) const;
  double below_region() const;
  dem::LatticePlan lattice_plan(double pitch, bool around = true) const;
  double rest_overlap(int a, int b) const;
  std::vector<dem::SphereSpec> listed() const;
  struct SavedGrains;
  SavedGrains from_file();
  void place_saved(const SavedGrains& saved);
  void refuse_idle_material(const BedTable& table) const;
  int material_of(const BedTable& table, std::size_t row) const;
  void save() const;
  std::optional<double> datum() const;
  void refuse_save_folder() const;
  void fix_rough_floor();

  World& world_;
  const Loaded& loaded_;
  const BuildOptions& options_;
  std::array<int, 6> wall_{-1, -1, -1, -1, -1, -1};
  int plate_ = -1;                       ///< that presses on the bed while it settles
  std::vector<int> layer_;               ///< of each sphere, by its id; from below
  std::optional<double> datum_of_file_;  ///< BedTable::surface, of a bed in a container
};

}  // namespace subsoil::sim
