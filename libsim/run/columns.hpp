#pragma once
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/base/vec3.hpp"
#include "libsim/io/series.hpp"
#include "libsim/run/history.hpp"

namespace subsoil::coupling {
class Simulation;
}

namespace subsoil::mbd {
class Evaluation;
struct Instant;
}  // namespace subsoil::mbd

namespace subsoil::sim {

class BuriedFibres;
struct Loaded;
struct MachineSection;
struct Scenario;
struct Watch;
struct World;
enum class Taken;
template <class Owner>
struct ColumnFamily;

/// The columns of series.csv of one run. What they are and where their numbers come from stands in column_table.hpp;
/// the machine names its own (mbd::Machine::column_names), and the scenario's monitors come last.
///
/// Values belong to the instant t_n at which a step begins: poses, velocities and energies are of t_n. Columns with the
/// unit N or N m are means over the steps since the row before, or with `output.forces: instant` (without soil the
/// default) of t_n too. Formulas of such means are means themselves, of what the formula is in every step: the mean of
/// F v is not the mean of F times v. With soil it is in a step the half sum over both its ends, where instants are of
/// the end and what the soil does is what acts over the step; so F v of soil is its work over the displacement, and the
/// machine's own forces count by the trapezium rule. Without soil both are of the step's middle, as the forces are, so
/// the formula F is the column F. Rows lie between instants (rows.hpp).
class Columns {
 public:
  Columns(const Loaded& loaded, World& world, coupling::Simulation& simulation);
  ~Columns();

  const std::vector<SeriesColumn>& list() const { return columns_; }
  bool is_mean(std::size_t column) const { return mean_[column] != 0; }
  bool has_means() const { return has_means_; }
  /// Whole numbers have no value between two instants: states of joints and friction, counts.
  bool is_whole(std::size_t column) const { return whole_[column] != 0; }
  /// Values of every step are needed, not only of samples: for means, or for the summary.
  bool needs_every_step() const { return has_means_ || !summarised_.empty(); }
  /// Before a step: everything that is of the instant t_n, into `row`. Without soil and means that is all.
  void take_instant(std::span<double> row);
  /// The same of a machine alone at the time t, to which `at` belongs.
  void take_instant(double t, const mbd::Instant& at, std::span<double> row);
  /// After the step: forces that acted from t_n on (means over a sample are made of these), and the bed's energies.
  void take_step(std::span<double> row, bool energies);
  /// The scenario's monitors, from the other columns of the row. What is followed over time stays as it is in the row.
  void take_watches(std::span<double> row) const;
  /// Whether monitors are followed over time (integrals, extremes ...): then every instant goes to follow().
  bool has_history() const { return !histories_.empty(); }
  /// Whether a column is followed over time, or made of such.
  bool of_history(std::size_t column) const;
  bool history_needs_sums() const;
  /// The instant t with all other columns in `row`: moves what is followed over time on to it. `middle`: a row halfway
  /// since the instant before, or empty. What the machine has of an instant is followed from window to window.
  void follow(double t, std::span<double> row, std::span<double> middle = {});
  /// What is followed over time, to follow it again from there.
  using Followed = std::vector<History>;
  const Followed& followed() const { return histories_; }
  void set_followed(const Followed& histories) { histories_ = histories; }
  /// `row` at a time between the last two instants, as if followed to there only.
  /// @param of_machine of what the machine has at the ends of windows, or of the rest
  void follow_back(double t, std::span<double> row, bool of_machine) const;
  /// What each column of the row at an instant may change by from rounding alone: 1e-12 of the maximum value in the row
  /// with its unit, and for forces and moments of the maximum reaction of the machine. For machines alone.
  void rounding_of(const mbd::Instant& at, std::span<const double> row, std::vector<double>& out) const;
  /// What a pose or velocity near 0 is not known to, from the tolerance of the machine's method; 0 of other columns.
  double noise_of(std::size_t column) const;
  /// Adds what is worth looking for between instants, for what is followed over time.
  void request(std::vector<mbd::Request>& out) const;
  void archive_histories(Archive& a);
  /// Columns that the machine has of an instant; with soil it stands at the ends of windows only.
  const std::vector<std::size_t>& of_machine_instant() const { return of_machine_instant_; }

  /// Columns worth a line in the summary: monitors, draft and lift, forces of surfaces.
  const std::vector<std::size_t>& summarised() const { return summarised_; }
  /// Index of a column or -1.
  int find(const std::string& name) const;
  /// Throws ScenarioError at `path` of the scenario, with the nearest name.
  std::size_t find_or_throw(const std::string& name, const std::string& path, const Loaded& loaded) const;
  /// Made of sums over all spheres, only in steps that are asked for them.
  bool is_sum(std::size_t column) const;

 private:
  struct Source {  ///< a column of the table
    std::size_t column;
    std::function<double()> value;
  };
  struct WatchSource {
    std::size_t target;
    int column = -1;              ///< copied from this column, or
    std::vector<int> components;  ///< components projected on `along`, of one owner or several
    dem::Vec3 along;
    std::function<double(std::span<const double>)> formula{};  ///< of a row
    std::vector<std::size_t> inputs{};                         ///< of the formula
    int history = -1;                                          ///< its place among those followed over time
    Watch::Kind kind = Watch::Kind::column;
    bool averaged = false;    ///< a formula of columns of means
    bool of_machine = false;  ///< of what the machine has of an instant
  };
  double value_of(const WatchSource& w, std::span<const double> row) const;
  bool is_of_machine(const WatchSource& w) const;
  std::size_t add(const std::string& name, const std::string& unit, bool whole = false);
  template <class Owner>
  void add(const ColumnFamily<Owner>& family, const std::string& owner, const Owner& of);
  void add_soil();
  void add_watch(const Watch& watch, const Loaded& loaded);
  std::vector<std::string> borne_by(const std::string& of) const;
  std::vector<std::string> force_components(const std::string& of) const;
  int force_column(const Watch& watch, const Loaded& loaded) const;
  void add_formula(const Watch& watch, const Loaded& loaded);
  void add_history(const Watch& watch, const Loaded& loaded);
  void take(Taken when, std::span<double> row) const;
  void take_machine(const mbd::Instant& at, std::span<double> row, bool means);
  void keep_step_begin(std::span<double> row);
  void take_machine_means(std::span<double> row);
  void take_middle(std::span<const double> row);
  void take_ends(std::span<const double> row);
  void take_averaged(std::span<double> row);

  World& world_;
  coupling::Simulation& simulation_;
  const Scenario& scenario_;
  std::unique_ptr<BuriedFibres> buried_;
  bool has_means_ = false, has_averaged_ = false;
  std::vector<SeriesColumn> columns_;
  std::vector<char> mean_, whole_;
  std::vector<double> machine_values_;
  std::unique_ptr<mbd::Evaluation> middle_;    ///< of a step of a machine alone
  std::vector<double> step_begin_, step_end_;  ///< rows of both ends of a step, for formulas of means
  std::size_t machine_first_ = 0;
  std::vector<std::size_t> unit_of_;  ///< of each column: the first one with its unit
  std::vector<Source> sources_[3];    ///< by Taken
  std::vector<WatchSource> watches_;
  bool machine_stands_ = true;  ///< at the instant taken last, and not at the start of a window
  std::vector<History> histories_;
  std::vector<std::size_t> summarised_, of_machine_instant_;
};

/// Whether a column is one of the machine's measures: NAME or NAME.x ...
bool is_measure(const MachineSection& machine, const std::string& column);

}  // namespace subsoil::sim
