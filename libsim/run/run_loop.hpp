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

#include "libdem/base/archive.hpp"
#include "libsim/base/live_line.hpp"
#include "libsim/run/checkpoints.hpp"
#include "libsim/run/output_folder.hpp"
#include "libsim/run/physics_monitor.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/run/run_output.hpp"
#include "libsim/run/run_summary.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/run/tool_monitor.hpp"

namespace subsoil::sim {

/// A run through time in a folder that is locked. Its steps have four observers: what follows the tools, what takes
/// samples, what checks the physics, and the loop itself, which decides about the end and writes states.
/// run_loop_end.cpp writes what only the end of a run knows.
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

  /// Prints it once, now, and writes it down.
  void warn(const std::string& text);

  int loop();
  void at_instant() override;
  void before_step(bool, StepRequest&) override {}
  bool take(const std::function<void()>& step) override { return guarded(step); }
  bool after_step() override;

  /// A signal waits for an instant at which a state is exact, but not for long.
  int signal_to_obey();

  /// False when the step cannot be taken; the output then states why.
  bool guarded(const std::function<void()>& take_step);

  std::string live_text(std::span<const double> row);
  /// Shows how far the run is, to a waiting user and in the folder, where it is time for either.
  void report_progress(std::span<const double> row);
  /// Into run.lock, as JSON: `time`, `from`, `until`, `remaining` s of wall time, `warnings` so far.
  void write_progress();

  /// Of contacts at the speeds that were met.
  void warn_of_coarse_contacts();

  /// What fixed machine steps are estimated to err by.
  void write_step_error();
  void warn_of_ground_contacts();

  void warn_of_machine_energy();

  /// What the explicit exchange between soil and machine has made or lost.
  void warn_of_exchange();
  /// What the iterated exchange took, and machine steps in which it found no agreement.
  void warn_of_open_exchange();

  /// What is left to be written after a failure of the disk is tried, each on its own.
  void attempt(int& code, const std::function<void()>& action);

  void finish(int& code);
  void write_energy(int code);

  /// What only the end of a run knows.
  void warn_of_missing(const PouredSoil& one);
  void last_warnings(int code);

  const Loaded& loaded_;
  const Scenario& s_;
  RunRequest request_;
  FolderLock& lock_;
  std::string begun_by_;                ///< scenario whose drivers began the run
  const RunProgress* go_on_ = nullptr;  ///< what stands in the folder, to append to; null: from the start
  Stepper& stepper_;
  World& world_;
  coupling::Simulation& simulation_;
  RunOutput output_;
  ToolMonitor tools_;
  PhysicsMonitor physics_;
  std::unique_ptr<Samples> samples_;
  Summary* summary_ = nullptr;
  LiveLine live_;
  RecentRate rate_;
  Checkpoints checkpoints_{request_.out};
  std::uint64_t state_bytes_ = 0;  ///< maximum of the states so far
  std::optional<Clock::time_point> signal_at_;
  long state_due_since_ = -1;        ///< step at which a state was due that is not saved yet; -1: none
  std::set<std::string> printed_;    ///< warnings, in this process
  std::vector<std::string> warned_;  ///< the same, as they came
  double reported_at_ = 0;           ///< s of wall time; of the last write_progress()
  double start_time_ = 0;
  long& steps_;
};

}  // namespace subsoil::sim
