#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "libsim/scenario/sections/placement.hpp"

/// What is written, and how often.
namespace subsoil::sim {

enum class Column { position, velocity, spin, force, torque, contacts };
inline constexpr std::array<const char*, 6> column_names{"position", "velocity", "spin", "force", "torque", "contacts"};
enum class OutputPrecision { single, full };
enum class State { none, full };
/// Which process writes the spheres of frames, of several.
enum class FrameFiles { automatic, parts, gathered };
enum class SeriesDigits { nine, all };
/// What the columns of forces hold: means over the interval of a row, or values at its instant.
enum class ForceColumns { automatic, mean, instant };

enum class CrossingDirection { both, rising, falling };

/// A named column of the series made for the reader's eye.
struct Watch {
  enum class Kind {
    column,
    driver,
    force,
    joint,
    soil_force,
    soil_moment,
    formula,
    integral,  // from here on: of a column over time
    derivative,
    mean,
    maximum,
    minimum,
    count,
    time_above,
    time_below
  };
  bool over_time() const { return kind >= Kind::integral; }
  std::string name;
  Kind kind = Kind::column;
  std::string of;       // column `shovel.angle`, or the driver, force, joint, body or boundary, or the formula
  Vec3 along{1, 0, 0};  // joint, soil force: direction of the component; need not be a unit vector
  std::vector<std::pair<std::string, std::string>> inputs{};  // formula: its names, and the columns that they stand for
  std::string unit = "1";                                     // formula: SI unit of its value, such as W
  std::optional<double> within{};                             // mean, extremes: of the last seconds; empty: of all
  std::string at{};                                           // count, time: value with the column's unit; empty: 0
  CrossingDirection direction = CrossingDirection::both;      // count
  bool unbroken = false;                                      // time: since it came there last
};

/// Instants at which a column passes a value.
struct CrossingSection {
  std::string name, column;
  std::string at;  // value with the column's unit; empty: 0
  CrossingDirection direction = CrossingDirection::both;
  long stop_after = 0;  // 0: never
};
void describe(Fields& v, CrossingSection& c);

struct Window {  // of the summary's means
  std::optional<double> from, until;
};
void describe(Fields& v, Window& w);

struct Output {
  std::optional<double> every;               // frames; end/200 unless given (unless `at` is)
  std::vector<double> at;                    // further frame times
  std::optional<double> series_every;        // rows; 1 ms unless given (unless `series at` is)
  std::vector<double> series_at;             // further times of rows
  SeriesDigits digits = SeriesDigits::nine;  // with soil; without always all
  long sample_losses_every = 0;              // soil steps; 0: the bed's own choice
  ForceColumns forces = ForceColumns::automatic;
  std::vector<Column> columns{Column::position, Column::velocity, Column::spin,
                              Column::force,    Column::torque,   Column::contacts};
  bool contact_forces = false;  // in frames
  FrameFiles frames = FrameFiles::automatic;
  OutputPrecision precision = OutputPrecision::single;
  long compression = 4;
  std::optional<Box> region;  // only spheres in it
  std::optional<double> state_every;
  State state = State::full;  // at the end
  std::vector<Watch> watch;
  std::vector<CrossingSection> crossings;
  Window window;

  /// Interval of rows, s; 0: only at listed times.
  double row_interval() const { return series_every.value_or(series_at.empty() ? 1e-3 : 0); }
};
void describe(Fields& v, Output& o);

struct Checks;
struct Scenario;
void check_output(Checks& checks, const Scenario& s);

}  // namespace subsoil::sim
