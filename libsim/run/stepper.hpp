#pragma once
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "libsim/run/columns.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

struct SavedRun;

/// What an observer asks of the step that begins.
struct StepRequest {
  bool instant = false;   ///< columns that are of t_n; those of the step are always taken
  bool energies = false;  ///< also those that are sums over all spheres
  dem::Snapshot* snapshot = nullptr;
  std::vector<dem::ContactRecord>* contacts = nullptr;
  bool stop = false;  ///< the step is not taken
  /// A machine alone whose method ends steps anywhere ends this one here at the latest, s.
  double until = std::numeric_limits<double>::infinity();
};

/// Takes part in every step of a run. Calls come in this order.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  /// Bed and machine stand at t_n. Forces may be set here. A state that is saved here continues with the same bits.
  virtual void at_instant() {}
  /// Whether spheres have come or gone since the last step: the window of a moving bed advanced, or inlets poured.
  virtual void before_step(bool spheres_changed, StepRequest& request) = 0;
  /// Takes the step; false where it fails and the observer has noted why. The default lets faults pass.
  virtual bool take(const std::function<void()>& step) { return step(), true; }
  /// Forces are those of t_n, poses those of t_{n+1}; columns are taken unless the stepper is exact. False ends the
  /// run; the step does not count then, and observers behind are not called.
  virtual bool after_step() = 0;
};

/// Threads of a run, as asked for or as the scenario has them; those of OpenMP are set to it. 0: as many as there are.
int use_threads(const Loaded& loaded, int asked);

/// The step of every run, in process or of the program: one order for bed, machine, window and columns.
class Stepper {
 public:
  /// @param saved restored into the world before the columns are made; null: from the start
  Stepper(const Loaded& loaded, World world, const SavedRun* saved = nullptr);
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;

  World& world() { return world_; }
  const World& world() const { return world_; }
  coupling::Simulation& simulation() { return simulation_; }
  const coupling::Simulation& simulation() const { return simulation_; }
  Columns& columns() { return *columns_; }
  /// Of the columns, at the last step.
  std::vector<double>& values() { return values_; }
  long& steps() { return steps_; }

  /// One step; false where an observer ends the run.
  bool advance(std::span<StepObserver* const> observers);
  /// Whether columns are of an instant alone: of a machine without soil and means nothing is learnt of an instant by
  /// the step that leaves it. Observers then take them where they want them.
  bool is_exact() const { return !world_.bed && !columns_->has_means(); }
  /// What is due so near to an instant is of that instant, s.
  double close() const;

  /// Whether a state that is saved now continues with the same bits.
  bool is_restorable() const { return machine_is_fresh_ && world_.bed != nullptr; }
  /// Makes it so at any instant, where the machine is not near a singular configuration: the machine restarts from its
  /// own state. Moves last digits between the instants at which every run does so.
  void refresh_now();
  bool machine_is_fresh() const { return machine_is_fresh_; }
  /// A force or a motion that acts on the machine has jumped at this instant.
  void note_jump();
  /// Steps between two instants at which every run does so. They follow from the step's number alone: no bit of the
  /// motion depends on the states that are asked for.
  static constexpr long steps_between_states = 64;

  /// Puts a state of the same scenario in place. @param checkpoint of this bed, in place of the state's arrays; or null
  void restore(const SavedRun& saved, const dem::Bed::Checkpoint* checkpoint = nullptr);
  /// The pose of a boundary from now on, as a function of time; a servo still shifts it. Empty: as the scenario has it.
  void set_motion(int boundary, std::function<dem::Pose(double)> pose);

 private:
  using PoseOfTime = std::function<dem::Pose(double)>;
  /// Whether the bed stands at the first instant at the end of the run or beyond it.
  bool is_at_end() const;
  /// Advances a moving bed and pours inlets; whether spheres have come or gone.
  bool bring_soil();
  void take_step(const StepRequest& request);
  void refresh_machine();
  void meet_fixed_spheres(int boundary, bool driven);
  void replace_simulation();
  bool has_stepped() const { return simulation_.has_stepped(); }
  static coupling::SimulationOptions options_of(const Loaded& loaded, const World& world);

  const Loaded& loaded_;
  World world_;
  coupling::Simulation simulation_;
  std::unique_ptr<Columns> columns_;
  std::vector<double> values_;
  struct Driven {
    PoseOfTime pose, given;
  };
  std::map<int, std::shared_ptr<Driven>> driven_;  ///< by boundary, motions that set_motion() gave
  long steps_ = 0;
  bool machine_is_fresh_ = true;
};

}  // namespace subsoil::sim
