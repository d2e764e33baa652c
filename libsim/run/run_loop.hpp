#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "libsim/base/live_line.hpp"
#include "libsim/io/series_writer.hpp"
#include "libsim/io/summary.hpp"
#include "libsim/run/body_watch.hpp"
#include "libsim/run/checkpoints.hpp"
#include "libsim/run/columns.hpp"
#include "libsim/run/crossings.hpp"
#include "libsim/run/frames.hpp"
#include "libsim/run/motion_summary.hpp"
#include "libsim/run/output_folder.hpp"
#include "libsim/run/peak_search.hpp"
#include "libsim/run/physics_watch.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/run/rows.hpp"
#include "libsim/run/run_summary.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/run/schedule.hpp"
#include "libsim/run/stepper.hpp"
#include "libsim/run/surface_meeting.hpp"
#include "libsim/run/tool.hpp"
#include "libsim/run/wall_watch.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// A run through time in a folder that is locked: observes the steps of the coupled simulation to its end and writes
/// series, frames, states and summary on the way. run_loop.cpp observes, run_loop_alone.cpp steps a machine without
/// soil; run_loop_end.cpp writes what only the end of a run knows.
class RunLoop : private StepObserver {
 public:
  /// @param saved is restored in the stepper
  RunLoop(const Loaded& loaded, const RunRequest& request, Stepper& stepper, const std::optional<SavedRun>& saved,
          FolderLock& lock, bool goes_on);

  int run();

 private:
  using Clock = std::chrono::steady_clock;  // a clock on the wall may be set back

  void open_output();

  /// Of series.csv, where the run continues in its folder.
  std::optional<std::uint64_t> kept_bytes() const;

  /// All that the run has added up beside bed, machine and coupling.
  void archive(Archive& a);
  /// What the summary states of where the run came from.
  void archive_origin(Archive& a);

  void save(const std::filesystem::path& path);

  /// Of a machine alone there is none: it is run again.
  bool checkpoint_is_due() const;

  void set_fixed_window();

  /// What is due so near to an instant is of that instant, s.
  double close() const;

  /// Prints it once, now, and writes it down.
  void warn(const std::string& text);

  int loop();
  void at_instant() override;
  void before_step(bool window_advanced, StepRequest& request) override;
  bool take(const std::function<void()>& step) override { return guarded(step); }
  bool after_step() override;
  /// A machine alone without columns of means: rows and frames are of their times exactly. Methods with a dense output
  /// end there; with fixed steps what lies between is read from the step that leads past it.
  int loop_alone();
  /// Moves a machine alone to `t`, with fixed steps to the first end at or behind it; false as step().
  bool reach(double t, double close);
  int code_of(int signal) const;
  /// Of a machine alone: takes what is followed over time, and crossings, through the segments of its last step, each
  /// in so many parts, and over what jumps between them; true where the run is to end.
  bool look_over(double before, double t, int parts);
  struct Splits {  ///< that a part may still take
    int at_peaks, in_halves;
  };
  bool look_through(std::size_t segment, double from, double until, Splits left);
  bool look_at(double t, const mbd::Instant& at);
  /// Of a machine alone: at a time of its last step; at the step's end where `t` is beyond it by `close` at the most.
  mbd::Instant instant_at(double t, double close = 0);
  /// Whether the summary has columns.
  bool sums_up() const;
  /// The time from t on at which a machine alone is looked at next, at the latest.
  double next_due(double t, double close) const;

  /// A signal waits for an instant at which a state is exact, but not for long.
  int signal_to_obey();

  /// Rows and frames that are due up to the instant, whose values are known; at it too if it is the last.
  void write_due();

  /// Whether the soil does what no physics does, beyond repair; failure_ then states it.
  bool physics_fails();

  /// Whether the machine's energy balance is off by more than it may; failure_ then states it.
  bool energy_is_lost();
  bool energy_is_lost(const mbd::Instant& at);
  bool fails(const std::string& fault);

  /// Whether a surface of the machine and a boundary have come together; failure_ then states it.
  bool surfaces_have_met(double t);

  /// The step from t on of length `taken`, with what acts in it, enters the means and the summary.
  void count_step(double t, double taken, std::span<const double> values);

  /// False when the step cannot be taken; failure_ then states why.
  bool guarded(const std::function<void()>& take_step);

  /// Surfaces that the window of a moving bed has left are named once.
  void warn_of_left_surfaces(double t);

  /// Opens and closes the window of the means where the tools' ways require it, and checks the walls while it is open.
  void follow_tools(double t);

  std::string live_text(std::span<const double> row);
  /// Shows how far the run is, to a waiting user and in the folder, where it is time for either.
  void report_progress(std::span<const double> row);
  /// Into run.lock, as JSON: `time`, `from`, `until`, `remaining` s of wall time, `warnings` so far.
  void write_progress();

  /// What the summary's energy balance starts from; the bed's terms are of the first step.
  void begin_energy();
  void take_up_energy(const SavedRun& saved);

  /// Of contacts at the speeds that were met.
  void warn_of_coarse_contacts();

  /// What fixed machine steps are estimated to err by.
  void write_step_error();

  void warn_of_machine_energy();

  /// What the explicit exchange between soil and machine has made or lost.
  void warn_of_exchange();

  /// What is left to be written after a failure of the disk is tried, each on its own.
  void attempt(int& code, const std::function<void()>& action);

  void finish(int& code);

  /// What only the end of a run knows.
  void last_warnings(int code);

  const Loaded& loaded_;
  const Scenario& s_;
  RunRequest request_;
  FolderLock& lock_;
  const RunProgress* go_on_ = nullptr;  ///< what stands in the folder, to append to; null: from the start
  Stepper& stepper_;
  World& world_;
  coupling::Simulation& simulation_;
  Columns* const columns_;
  std::unique_ptr<ToolProgress> tool_;
  std::unique_ptr<SeriesWriter> series_;
  std::unique_ptr<Summary> summary_;
  std::unique_ptr<MotionSummary> motion_;        ///< into it, of a machine alone
  std::unique_ptr<mbd::Evaluation> evaluation_;  ///< of a machine alone, between the ends of its steps
  std::unique_ptr<FrameOutput> frames_;
  std::unique_ptr<Rows> rows_;
  std::unique_ptr<Crossings> crossings_;
  std::vector<double>& values_;         // of the step
  std::vector<double> summarised_;      // of the summary's columns
  std::vector<double> begin_, middle_;  // where a part of it begins, and halfway through it
  std::vector<double> between_;         // at a time in it
  std::vector<double> rounding_;        // of its columns
  std::vector<Sought> sought_;          // in that part
  bool follows_sums_ = false;           ///< what is followed over time is of sums over all spheres
  LiveLine live_;
  RecentRate rate_;
  WallWatch walls_;
  std::optional<SurfaceMeeting> meeting_;
  PhysicsWatch physics_;
  BodyWatch bodies_;
  Schedule frame_due_, sample_due_, state_due_, tool_due_;
  Checkpoints checkpoints_{request_.out};
  std::uint64_t state_bytes_ = 0;  ///< maximum of the states so far
  bool energy_begun_ = false;
  struct Instant {  ///< the one at which the step begins
    double t = 0;
    int signal = 0;
    bool last = false, row = false, first = false, window_advanced = false;
    bool stood = true;  ///< the machine, and not at the start of a window
  } now_;
  bool stops_ = false;  ///< a crossing ends the run at the next instant
  int code_ = exit_failed;
  std::optional<Clock::time_point> signal_at_;
  long state_due_since_ = -1;  ///< step at which a state was due that is not saved yet; -1: none
  long looks_ = 0;
  std::set<std::string> printed_;     ///< warnings, in this process
  std::vector<std::string> warned_;   ///< the same, as they came
  double reported_at_ = 0;            ///< s of wall time; of the last write_progress()
  std::vector<std::string> outside_;  ///< surfaces that the window of a moving bed has left
  std::string failure_;
  double start_time_ = 0, reached_ = 0;
  EnergyStart energy_start_;
  double deepest_ = 0, fastest_ = 0;
  long& steps_;
  enum class Opening { fixed, pending, open, closed } window_ = Opening::fixed;
};

}  // namespace subsoil::sim
