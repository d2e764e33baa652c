#pragma once
#include "libdem/base/archive.hpp"
#include "libsim/base/json.hpp"
#include "libsim/run/body_watch.hpp"
#include "libsim/run/physics_watch.hpp"
#include "libsim/run/run_output.hpp"

namespace subsoil::sim {

/// Ends a run in which soil or machine do what no physics does, and warns of what is doubtful.
class PhysicsMonitor : public StepObserver {
 public:
  explicit PhysicsMonitor(RunOutput& output);

  void before_step(bool spheres_changed, StepRequest& request) override;
  bool after_step() override;
  /// The step that was taken is valid.
  void count_step();

  /// What the summary's energy balance starts from; the bed's terms are of the first step.
  const EnergyStart& energy_start() const { return start_; }
  bool has_begun() const { return begun_; }
  /// Works and losses are those of the whole motion; so is what gravity has given, and what the balance closes over.
  /// What a change of the scenario adds by itself, to contacts and potentials, counts as there at the start.
  void take_up(const SavedRun& saved, bool changed);
  void continue_from(long steps) { begun_ = steps > 0; }
  double deepest() const { return deepest_; }  ///< overlap, share of the smaller radius
  double fastest() const { return fastest_; }  ///< sphere, m/s

  /// The energy balance of the last instant at which the bed's energies were taken, with its time; null before.
  const Json& balance() const { return balance_; }

  void archive(Archive& a) {
    a("physics", physics_)("bodies", bodies_)("deepest", deepest_)("fastest", fastest_)("start", start_);
  }

 private:
  void begin();
  bool physics_fails();

  RunOutput& o_;
  PhysicsWatch physics_;
  BodyWatch bodies_;
  EnergyStart start_;
  Json balance_;
  bool begun_ = false, changed_ = false;
  double deepest_ = 0, fastest_ = 0;
};

}  // namespace subsoil::sim
