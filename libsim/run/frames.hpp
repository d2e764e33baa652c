#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/io/run_writer.hpp"
#include "libsim/run/fibre_drag.hpp"
#include "libsim/run/frame_loads.hpp"
#include "libsim/run/mechanism_frames.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// How the scenario wants its frames kept.
RunOptions frame_options(const Scenario& scenario);
/// Interval of frames, s; 0: only at listed times.
double frame_interval(const Scenario& scenario);

/// Frames of a run: who is drawn, and the state at the instant at which a step begins.
class FrameOutput {
 public:
  /// @param go_on what an earlier run into this directory has written, to append to; null: from the start
  FrameOutput(const std::filesystem::path& directory, const Scenario& scenario, const World& world,
              const coupling::Simulation& simulation, const RunProgress* go_on = nullptr);

  /// Before the step that begins at t: where surfaces stand. Returns what the step is to fill (null without a bed).
  dem::Snapshot* begin(double t);
  /// The same of a machine alone at an instant.
  void begin(double t, const mbd::Instant& at);
  /// Likewise the contacts, where frames hold them.
  std::vector<dem::ContactRecord>* contacts() { return holds_contacts_ ? &now_.contacts : nullptr; }
  /// After the step: a frame at its beginning or between that and the instant of the begin() before. In between,
  /// positions lie on the cubic through x and v of both, the rest on a line (poses turn about one axis), which is
  /// of second order in the step; counts are those of the nearer instant. Spheres, and the window of a moving bed, are
  /// those of the instant before: who comes or goes does so at the end of the step.
  void write(double time, long step);
  /// A frame of a machine without soil at other poses than its own: the shape of a mode, the pose as given.
  void write_poses(double time, const Poses& poses);
  /// What pictures show of the machine; null without one.
  const Sketch* sketch() const { return mechanism_ ? &mechanism_->sketch() : nullptr; }
  const FibreDrag& fibre_drag() const { return drag_; }
  long count() const { return writer_ ? writer_->frames() : 0; }
  void finish();
  /// The instant that a frame between the steps still needs (`needed`), to or from a state.
  void archive(Archive& a, bool needed);
  /// All frames so far are on the disk; fills from what a later run continues.
  void publish(RunProgress& progress);

 private:
  void list_particles(ParticleTable& table, const Scenario& scenario);
  void list_poured(ParticleTable& table, double end) const;
  void list_period(ParticleTable& table) const;
  void list_surfaces(std::vector<OutputSurface>& surfaces);
  std::vector<FrameValue> list_measures(const Scenario& scenario);
  struct Instant {
    double t = 0;
    double rear = 0, front = 0;  ///< x of the ends of a moving bed's window, m
    dem::Snapshot spheres;
    std::vector<dem::Pose> surfaces;  ///< of the boundaries that are shown
    Poses bodies;                     ///< of the machine
    std::vector<double> values;       ///< measures
    std::vector<dem::ContactRecord> contacts;
    void archive(Archive& a);
  };
  Between between(double time) const;
  const Instant& at(double time);
  void archive_now(Archive& a);
  dem::PeriodicCell cell() const { return world_.bed ? world_.bed->options().periodic : dem::PeriodicCell{}; }
  void take_poses(const Poses& poses);
  void begin_instant(double t);
  void take_values(const mbd::Instant& at);
  void write_instant(const Instant& now, const Between& between, double time, long step);

  const World& world_;
  const coupling::Simulation& simulation_;
  std::unique_ptr<RunWriter> writer_;  ///< none without spheres, surfaces and machine: nothing to draw
  std::optional<MechanismFrames> mechanism_;
  std::vector<int> shown_;  ///< boundaries that frames hold, in their order
  std::vector<dem::Pose> poses_;
  std::vector<std::vector<Vec3>> deformed_;
  std::vector<std::size_t> measures_;  ///< columns of the machine
  bool holds_contacts_;
  FrameLoads loads_;
  FibreDrag drag_;
  Instant before_, now_, between_;
};

}  // namespace subsoil::sim
