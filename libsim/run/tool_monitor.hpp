#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/run/run_output.hpp"
#include "libsim/run/surface_meeting.hpp"
#include "libsim/run/tool.hpp"
#include "libsim/run/wall_watch.hpp"

namespace subsoil::sim {

/// Follows the tools of a run: opens and closes the window of the means where their ways require it, checks the walls
/// while it is open, and ends a run in which a surface of the machine and a boundary come together.
class ToolMonitor : public StepObserver {
 public:
  explicit ToolMonitor(RunOutput& output);

  /// The window of the means: as given, of the tools' steady work, or the whole run.
  void set_window();
  void before_step(bool spheres_changed, StepRequest& request) override;
  bool after_step() override;

  const ToolProgress& progress() const { return progress_; }
  const WallWatch& walls() const { return walls_; }
  /// A tool has travelled in soil and never come to steady work.
  bool never_steady() const { return window_ == Opening::pending && progress_.any_travelled(); }

  void archive(Archive& a) {
    a("due", due_)("progress", progress_)("walls", walls_)("outside", outside_)("looks", looks_)("window", window_)(
        "entered", entered_);
  }

 private:
  void follow(double t);
  void warn_of_left_surfaces(double t);
  bool surfaces_have_met(double t);

  RunOutput& o_;
  ToolProgress progress_;
  WallWatch walls_;
  std::optional<SurfaceMeeting> meeting_;
  Schedule due_;
  long looks_ = 0;
  std::size_t entered_ = 0;           ///< tools in the soil when the window opened
  std::vector<std::string> outside_;  ///< surfaces that the window of a moving bed has left
  enum class Opening { fixed, pending, open, closed } window_ = Opening::fixed;
};

}  // namespace subsoil::sim
