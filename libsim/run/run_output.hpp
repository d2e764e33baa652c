#pragma once
#include <fmt/format.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libsim/io/series_writer.hpp"
#include "libsim/io/summary.hpp"
#include "libsim/run/columns.hpp"
#include "libsim/run/crossings.hpp"
#include "libsim/run/frames.hpp"
#include "libsim/run/rows.hpp"
#include "libsim/run/schedule.hpp"
#include "libsim/run/stepper.hpp"

namespace subsoil::sim {

/// What a run writes to and when, and how it stands: shared by the observers of its steps.
struct RunOutput {
  RunOutput(const Scenario& scenario, Stepper& stepper)
      : s(scenario),
        world(stepper.world()),
        simulation(stepper.simulation()),
        columns(stepper.columns()),
        values(stepper.values()),
        steps(stepper.steps()) {}

  const Scenario& s;
  World& world;
  coupling::Simulation& simulation;
  Columns& columns;
  std::vector<double>& values;  ///< of the columns, at the last step
  long& steps;
  std::unique_ptr<SeriesWriter> series;
  std::unique_ptr<Summary> summary;
  std::unique_ptr<FrameOutput> frames;
  std::unique_ptr<Crossings> crossings;
  std::unique_ptr<Rows> rows;
  Schedule frame_due, sample_due, state_due;
  double close = 0;                              ///< what is due so near to an instant is of that instant, s
  std::function<void(const std::string&)> warn;  ///< prints it once, now, and writes it down

  struct Now {  ///< the instant at which the step begins
    double t = 0;
    int signal = 0;
    bool last = false;      ///< of the run
    bool row = false;       ///< a row is due at it
    bool first = false;     ///< of all
    bool energies = false;  ///< the bed's are taken at it
  } now;
  double reached = 0;     ///< s
  bool stops = false;     ///< a crossing ends the run at the next instant
  bool ended = false;     ///< an observer has written the run's last instant
  std::string failure{};  ///< why the run ends; empty: it has not failed

  /// Notes it with the time reached; true where there is one.
  bool fails(const std::string& fault) {
    if (!fault.empty()) failure = fmt::format("t = {:.9g} s: {}", reached, fault);
    return !fault.empty();
  }
};

/// Samples of a run: series, frames, crossings and means, from the steps.
class Samples : public StepObserver {
 public:
  /// The time at which the run stands, s.
  virtual double time() const = 0;
  /// The machine at that time.
  virtual mbd::Instant machine() = 0;
  /// The row of series.csv that was taken last.
  virtual const std::vector<double>& last_row() const = 0;
  /// The step that was taken is valid: it enters the means.
  virtual void count_step() {}
};

}  // namespace subsoil::sim
