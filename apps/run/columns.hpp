#pragma once
#include <string>
#include <vector>

#include "apps/build/world.hpp"
#include "apps/output/series.hpp"

namespace subsoil::app {

/// The columns of series.csv and where their numbers come from.
///
/// A row belongs to the instant t_n at which a step begins. Poses, velocities and energies are of t_n. Columns with the
/// unit N or N m are means over the steps since the row before, or with `output.forces: instant` (without soil the
/// default) of t_n too.
/// Names: `<body>.x`, `<joint>.fx`, `<driver>.force` as the machine reports them; `<body>.soil.Fx` ... `.Mz` wrench of
/// the soil on a body about its centre of mass; `<surface>.Fx` ... about the surface's reference point, world axes;
/// `<boundary>.x` ... place of a boundary on a given path;
/// `soil.draft`, `soil.lift` the soil's force on the whole machine, rearward and upward; `soil.kinetic` ... the bed's
/// energy book; where a law has bonds `soil.bonds` intact ones,
/// `soil.bonds broken in tension`, `soil.bonds broken in shear` since the start and `soil.broken` the energy that they
/// held; `interface.on soil`, `interface.on machine` the work both sides book; then the scenario's watches.
class Columns {
 public:
  Columns(const Loaded& loaded, World& world, coupling::Simulation& simulation);

  const std::vector<SeriesColumn>& list() const { return columns_; }
  bool is_mean(std::size_t column) const { return mean_[column] != 0; }
  bool has_means() const { return has_means_; }
  /// Values of every step are needed, not only of samples: for means, or for the summary.
  bool needs_every_step() const { return has_means_ || !summarised_.empty(); }
  /// Before a step: everything that is of the instant t_n, into `row`. Without soil and means that is all.
  void take_instant(std::span<double> row);
  /// After the step: forces that acted from t_n on (means over a sample are made of these), and the bed's energies.
  void take_step(std::span<double> row, bool energies);

  /// Columns worth a line in the summary: watches, draft and lift, forces of surfaces.
  const std::vector<std::size_t>& summarised() const { return summarised_; }
  /// Index of a column or -1.
  int find(const std::string& name) const;
  /// Value of a watch column in a row, or NaN.
  double soil_draft(std::span<const double> row) const {
    return draft_ >= 0 ? row[static_cast<std::size_t>(draft_)] : NAN;
  }

 private:
  struct WatchSource {
    std::size_t target;
    int column = -1;              ///< copied from this column, or
    std::vector<int> components;  ///< three columns projected on `along`
    Vec3 along;
  };
  std::size_t add(const std::string& name, const std::string& unit);
  void add_wrench(const std::string& name);
  void add_watch(const Watch& watch, const Loaded& loaded);
  int find_or_throw(const std::string& name, const Watch& watch, const Loaded& loaded) const;
  void take_machine(std::span<double> row, bool means);
  void take_bonds(std::span<double> row, double energy);
  void take_watches(std::span<double> row);

  World& world_;
  coupling::Simulation& simulation_;
  bool instant_forces_ = false, has_means_ = false;
  std::vector<SeriesColumn> columns_;
  std::vector<char> mean_;
  std::vector<double> machine_values_;
  std::vector<int> tool_bodies_;
  std::size_t machine_first_ = 0, body_first_ = 0, surface_first_ = 0, path_first_ = 0, energy_first_ = 0;
  int bonds_ = -1;
  int draft_ = -1;
  std::vector<WatchSource> watches_;
  std::vector<std::size_t> summarised_;
};

/// Whether a column is one of the machine's measures: NAME or NAME.x ...
bool is_measure(const MachineSection& machine, const std::string& column);

/// Wrench of the spheres on a surface about its reference point.
dem::Wrench wrench_at_reference(const dem::Boundary& boundary, const Vec3& reference);

}  // namespace subsoil::app
