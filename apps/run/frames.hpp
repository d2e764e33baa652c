#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/build/world.hpp"
#include "apps/output/run_writer.hpp"

namespace subsoil::app {

/// How the scenario wants its frames kept.
RunOptions frame_options(const Scenario& scenario);
/// Interval of frames, s; 0: only at listed times.
double frame_interval(const Scenario& scenario);

/// Frames of a run: who is drawn, and the state at the instant at which a step begins.
class FrameOutput {
 public:
  FrameOutput(const std::filesystem::path& directory, const Scenario& scenario, const World& world,
              const coupling::Simulation& simulation);

  /// Before the step: where surfaces stand. Returns what the step is to fill (null without a bed).
  dem::Snapshot* begin();
  /// After the step that filled the snapshot.
  void write(double time, long step);
  long count() const { return writer_ ? writer_->frames() : 0; }
  void finish();

 private:
  void list_particles(ParticleTable& table, const Scenario& scenario);
  void list_surfaces(std::vector<OutputSurface>& surfaces);

  const World& world_;
  const coupling::Simulation& simulation_;
  std::unique_ptr<RunWriter> writer_;  ///< none for a machine without surfaces: nothing to draw
  std::vector<int> shown_;             ///< boundaries that frames hold, in their order
  std::vector<dem::Pose> poses_;
  dem::Snapshot snapshot_;
  std::size_t particles_ = 0;
};

}  // namespace subsoil::app
