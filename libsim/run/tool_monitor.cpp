#include "libsim/run/tool_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libdem/geometry/world_box.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {
namespace {

// Between two looks at where the tools are (s), whatever rows are asked for: the window of the means opens and closes
// at them.
constexpr double tool_interval = 1e-3;

}  // namespace

ToolMonitor::ToolMonitor(RunOutput& output)
    : o_(output), progress_(o_.world, o_.simulation, o_.s), due_(tool_interval, {}, o_.simulation.time()) {}

void ToolMonitor::set_window() {
  const Window& w = o_.s.output.window;
  const double start = o_.simulation.time(), end = o_.s.time.end;
  double longest = end - start, steady_from = start;
  if (w.from || w.until) {
    const double from = w.from.value_or(0), until = w.until.value_or(end);
    o_.summary->set_window(from, until, "given in output.window");
    longest = std::min(until, end) - from, steady_from = from;
  } else if (!progress_.any_passes()) {
    o_.summary->set_window(start, end, "no tool passes through soil: the whole run");
  } else {
    window_ = Opening::pending, steady_from = end;
    o_.summary->set_provisional_window(start, end, "no tool passed through soil: the whole run");
  }
  const double period = period_of(o_.s, steady_from);
  // Both ends of a window that are given stand; so does one into which no period fits.
  if (period > 0 && period < longest && !w.until)
    o_.summary->take_whole_periods(period);
  else if (period > 0)
    o_.summary->take_blocks_of(period);
  if (std::isnan(period))
    o_.warn("the given motions and forces have no period in common: means are over the whole window");
}

void ToolMonitor::before_step(bool spheres_changed, StepRequest& request) {
  if (!o_.world.bed) return;
  const double t = o_.now.t;
  if (spheres_changed && o_.world.moving) warn_of_left_surfaces(t);
  if (!due_.due(t, o_.close) && !o_.now.last) return;
  follow(t);
  if (surfaces_have_met(t)) request.stop = true;
}

bool ToolMonitor::after_step() {
  progress_.look_for_touch();
  return true;
}

bool ToolMonitor::surfaces_have_met(double t) {
  if (!meeting_) meeting_.emplace(o_.world);
  const std::optional<std::string> met = meeting_->look();
  if (met) o_.failure = fmt::format("t = {:.9g} s: {}: {}", t, *met, surface_meeting_cure);
  return met.has_value();
}

void ToolMonitor::warn_of_left_surfaces(double t) {
  const dem::MovingBed& window = o_.world.moving->window;
  const double low = std::min(window.rear(), window.front()), high = std::max(window.rear(), window.front());
  for (const SurfaceRecord& s : o_.world.surfaces) {
    if (s.owner == SurfaceRecord::Owner::container || std::count(outside_.begin(), outside_.end(), s.name) > 0)
      continue;
    const dem::Boundary& b = o_.world.bed->boundary(s.boundary);
    const dem::Bounds box = dem::world_box(dem::bounds(b.shape), b.pose);
    if (box.high.x >= low && box.low.x <= high) continue;
    outside_.push_back(s.name);
    o_.warn(fmt::format(
        "t = {:.4g} s: the window of the moving bed has left `{}`, which meets no soil there; let it go with "
        "`{}`, or make the container longer",
        t, s.name, o_.s.soil->moving->follows));
  }
}

void ToolMonitor::follow(double t) {
  if (progress_.tools().empty()) return;
  Summary& summary = *o_.summary;
  progress_.follow();
  const bool another = window_ == Opening::open && progress_.entered() > entered_ && !progress_.steady();
  if (another || (progress_.turned() && (window_ == Opening::open || window_ == Opening::closed))) {
    window_ = Opening::pending;  // another tool has entered the soil, or one turned to its way
    summary.drop_window();
    progress_.forget_looks();
  }
  if (window_ == Opening::pending && progress_.steady() && !progress_.at_the_end()) {
    window_ = Opening::open, entered_ = progress_.entered();
    summary.set_window(
        t, o_.s.time.end,
        "from when the tool has travelled, in soil, its length there plus its depth, until its foremost point is one "
        "depth from the end of the soil");
  } else if (window_ == Opening::open && progress_.at_the_end()) {
    window_ = Opening::closed;
    summary.close_window(t);
  }
  if (!progress_.any_passes() || window_ == Opening::pending || t < summary.window_from() ||
      t > summary.window_until() + tool_interval)
    return;
  progress_.count_look();
  if (!walls_.has_begun()) return walls_.begin(o_.world);
  if (++looks_ % 20 != 0) return;  // a look goes through all spheres
  for (const std::string& wall : walls_.look(o_.world))
    o_.warn(fmt::format(
        "t = {:.4g} s: disturbed soil reaches {} ({:.0f} % of the spheres there have moved by half a radius "
        "since the means began); make the bin larger there",
        t, wall, 100 * WallWatch::share));
}

}  // namespace subsoil::sim
