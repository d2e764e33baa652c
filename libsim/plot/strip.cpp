#include "libsim/plot/strip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "libsim/base/json.hpp"
#include "libsim/io/series.hpp"
#include "libsim/plot/gnuplot.hpp"
#include "libsim/plot/mechanism.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {
namespace {

constexpr double kMargin = 14, kTop = 44, kLabel = 22, kFoot = 34;  // pixels

/// A picture of the strip.
struct Panel {
  Poses poses;
  std::optional<Poses> shadow;
  std::string label;
  std::size_t row = 0;  ///< of the series: how far a path has got
};

struct Run {
  std::string name;
  Scenario scenario;
  Series series;
};

Run read_run(const std::filesystem::path& directory) {
  for (const char* file : {"scenario.yaml", "series.csv"})
    if (!std::filesystem::exists(directory / file))
      throw std::invalid_argument(directory.string() + " holds no " + file + ": is it the result directory of a run?");
  Run run{std::filesystem::absolute(directory / ".").parent_path().filename().string(),
          load_scenario((directory / "scenario.yaml").string()).scenario, read_series(directory / "series.csv")};
  if (!run.scenario.machine)
    throw std::invalid_argument(directory.string() +
                                " is a run without a machine: a strip shows mechanisms; leave --strip out");
  if (run.series.rows() == 0) throw std::invalid_argument((directory / "series.csv").string() + " has no sample yet");
  return run;
}

Poses poses_at(const Run& run, std::size_t row) {
  Poses poses{mbd::BodyState{}};
  for (const BodySection& b : run.scenario.machine->bodies) {
    const auto value = [&](const char* axis) { return run.series.at(b.name + axis)[row]; };
    poses.emplace_back(mbd::Vec2{value(".x"), value(".y")}, value(".angle"), mbd::Vec2{}, 0.0);
  }
  return poses;
}

std::size_t nearest_row(const Run& run, double time) {
  const std::vector<double>& t = run.series.at("time");
  if (time < t.front() - 1e-9 || time > t.back() + 1e-9)
    throw std::invalid_argument(
        fmt::format("--times {}: the run goes from {} to {} s; choose times in it", time, t.front(), t.back()));
  const auto after = std::lower_bound(t.begin(), t.end(), time);
  const auto at =
      after == t.end() || (after != t.begin() && time - *std::prev(after) < *after - time) ? std::prev(after) : after;
  return static_cast<std::size_t>(at - t.begin());
}

std::vector<Panel> instants(const Run& run, const StripOptions& options) {
  const std::vector<double>& t = run.series.at("time");
  std::vector<double> times = options.times;
  for (int k = 0; options.times.empty() && k < options.count; ++k)
    times.push_back(t.front() + (t.back() - t.front()) * k / std::max(1, options.count - 1));
  std::vector<Panel> panels;
  for (const double time : times) {
    const std::size_t row = nearest_row(run, time);
    panels.push_back({poses_at(run, row), {}, fmt::format("t = {:.4g} s", t[row]), row});
  }
  return panels;
}

Panel before_and_after(const Run& run) {
  const char* found = run.scenario.analysis == Analysis::assembly ? "assembled" : "equilibrium";
  return {poses_at(run, 0), start_poses(run.scenario), fmt::format("{}; as given: grey", found)};
}

std::vector<Panel> shapes(const Run& run, const std::filesystem::path& directory, const Sketch& sketch, int count) {
  const Series modes = read_series(directory / "modes.csv");
  const Poses rest = poses_at(run, 0);
  std::vector<Panel> panels;
  for (std::size_t k = 0; k < modes.rows() && panels.size() < static_cast<std::size_t>(count); ++k) {
    std::vector<double> shape;
    for (const BodySection& b : run.scenario.machine->bodies)
      for (const char* axis : {".x.real", ".y.real", ".angle.real"}) shape.push_back(modes.at(b.name + axis)[k]);
    const double factor = picture_factor(sketch, rest, shape);
    if (factor == 0) continue;  // a coordinate that nothing holds has no shape
    panels.push_back({displaced(rest, shape, factor), rest,
                      fmt::format("mode {}: {:.4g} Hz, damping {:.2g}, shape x {:.1g}", modes.at("mode")[k],
                                  modes.at("frequency")[k], modes.at("damping ratio")[k], factor),
                      0});
  }
  if (panels.empty())
    throw std::invalid_argument(directory.string() + ": no mode has a shape; there is nothing to draw");
  return panels;
}

/// A path in the plane, point by row of the series.
std::vector<mbd::Vec2> path_of(const mbd::Marker& m, const std::vector<Poses>& all) {
  std::vector<mbd::Vec2> path;
  for (const Poses& poses : all) {
    const mbd::BodyState& b = poses[static_cast<std::size_t>(m.body)];
    path.push_back(b.point_in_world(m.p));
  }
  return path;
}

std::vector<mbd::Marker> chosen_paths(const MachineSection& machine, const std::vector<std::string>& names) {
  std::vector<mbd::Marker> known, chosen;
  for (const mbd::Marker& m : machine.markers)
    if (m.body != mbd::ground) known.push_back(m);
  if (names.empty()) return known;
  for (std::size_t i = 0; i < machine.bodies.size(); ++i)
    known.push_back({.name = machine.bodies[i].name, .body = static_cast<int>(i + 1)});
  for (const std::string& name : names) {
    const auto found = std::find_if(known.begin(), known.end(), [&](const auto& m) { return m.name == name; });
    if (found == known.end()) {
      std::vector<std::string> all;
      for (const auto& m : known) all.push_back(m.name);
      throw std::invalid_argument("--paths " + name + ": no marker on a body, and no body" + suggestion(name, all));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

/// Takes a body's way out of all poses, so that it stays where it was in the first.
void follow(std::vector<Poses*> all, const MachineSection& machine, const std::string& name) {
  if (name.empty()) return;
  std::vector<std::string> names;
  for (const BodySection& b : machine.bodies) names.push_back(b.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw std::invalid_argument("--follow " + name + ": there is no body of this name" + suggestion(name, names));
  const auto body = static_cast<std::size_t>(found - names.begin()) + 1;
  const mbd::Vec2 home = (*all.front())[body].r;
  for (Poses* poses : all) {
    const mbd::Vec2 gone = (*poses)[body].r - home;
    for (mbd::BodyState& b : *poses) b.r = b.r - gone;
  }
}

/// 1, 2 or 5 times a power of ten, at most `largest`.
double round_length(double largest) {
  const double power = std::pow(10, std::floor(std::log10(largest)));
  return power * (largest >= 5 * power ? 5 : largest >= 2 * power ? 2 : 1);
}

std::string length_text(double metres) {
  return metres >= 1 ? fmt::format("{:g} m", metres) : fmt::format("{:g} mm", 1e3 * metres);
}

/// Panels in rows and columns on one scale, so many beside each other that the sheet is about 5 by 3.
class StripSheet {
 public:
  StripSheet(const Extent& seen, std::size_t panels, int width) : seen_(seen) {
    double best = INFINITY;
    for (std::size_t columns = 1; columns <= panels; ++columns) {
      const double scale = (width - 2 * kMargin - static_cast<double>(columns - 1) * kMargin) /
                           (static_cast<double>(columns) * seen.width());
      const auto rows = static_cast<double>((panels + columns - 1) / columns);
      const double height = rows * (scale * seen.height() + kLabel), off = std::abs(std::log(height / (0.6 * width)));
      // A hole in the last row counts a little.
      const double holes = (rows * static_cast<double>(columns) - static_cast<double>(panels)) / rows;
      if (off + 0.3 * holes < best) best = off + 0.3 * holes, columns_ = columns, scale_ = scale, height_ = height;
    }
    const double most = 1.4 * width;  // one tall picture
    if (height_ > most) scale_ *= most / height_, height_ = most;
  }
  int pixels_high(double foot) const { return static_cast<int>(std::ceil(kTop + height_ + foot)); }
  double scale() const { return scale_; }
  View view(std::size_t panel, int height) const {
    const double cell_x = scale_ * seen_.width() + kMargin, cell_y = scale_ * seen_.height() + kLabel;
    const auto column = static_cast<double>(panel % columns_), row = static_cast<double>(panel / columns_);
    return {seen_, {kMargin + column * cell_x, height - kTop - (row + 1) * cell_y}, scale_};
  }

 private:
  Extent seen_;
  std::size_t columns_ = 1;
  double scale_ = 1, height_ = 1;
};

class Strip {
 public:
  Strip(const Run& run, const Sketch& sketch, const std::vector<Poses>& all, const StripOptions& options)
      : run_(run), sketch_(sketch), width_(options.width), drawing_(sketch_, all) {
    if (run.scenario.runs_in_time())
      for (const mbd::Marker& m : chosen_paths(*run.scenario.machine, options.paths)) paths_.push_back(path_of(m, all));
  }

  /// What the panels and the paths cover.
  Extent extent(const std::vector<Panel>& panels) const {
    Extent seen;
    for (const Panel& p : panels) {
      drawing_.take_extent(p.poses, seen);
      if (p.shadow) drawing_.take_extent(*p.shadow, seen);
    }
    for (const auto& path : paths_)
      for (const mbd::Vec2 p : path) seen.take(p);
    widen(seen);
    return seen;
  }

  Canvas picture(const std::vector<Panel>& panels, const Extent& seen) const {
    const StripSheet sheet(seen, panels.size(), width_);
    const double foot = kFoot + 20.0 * legend(nullptr, 0, width_);
    Canvas canvas(width_, sheet.pixels_high(foot));
    canvas.words({kMargin, canvas.height() - 22.0}, title(), Canvas::Align::left, 13);
    for (std::size_t i = 0; i < panels.size(); ++i) draw(canvas, sheet.view(i, canvas.height()), panels[i]);
    scale_bar(canvas, sheet.scale(), seen.width());
    legend(&canvas, foot - kFoot, width_);
    return canvas;
  }

 private:
  std::string title() const { return run_.scenario.title.empty() ? run_.name : run_.name + ": " + run_.scenario.title; }

  /// Room for symbols that stand out, and no panel thinner than a fifth of its length.
  static void widen(Extent& e) {
    const double pad = 0.09 * std::max({e.width(), e.height(), 1e-9});
    const double wide = std::max(e.width(), 0.2 * e.height()) / 2 + pad,
                 high = std::max(e.height(), 0.2 * e.width()) / 2 + pad;
    const mbd::Vec2 middle{(e.left + e.right) / 2, (e.low + e.high) / 2};
    e = {middle.x - wide, middle.x + wide, middle.y - high, middle.y + high};
  }

  void draw(Canvas& canvas, const View& view, const Panel& panel) const {
    for (const auto& path : paths_) {
      std::vector<Spot> whole;
      for (const mbd::Vec2 p : path) whole.push_back(view(p));
      canvas.line(whole, {"#c8c8c8", 1});
      whole.resize(std::min(whole.size(), panel.row + 1));
      canvas.line(whole, {"#444444", 1.4});
    }
    if (panel.shadow) drawing_.draw_shadow(canvas, view, *panel.shadow);
    drawing_.draw(canvas, view, panel.poses);
    canvas.words(view.corner + Spot{4, view.scale * view.seen.height() + 6}, panel.label);
  }

  static void scale_bar(Canvas& canvas, double scale, double across) {
    const double metres = round_length(std::min(0.5 * across, 160 / scale)), pixels = metres * scale;
    const Spot from{kMargin, 14}, to{kMargin + pixels, 14}, tick{0, 4};
    canvas.line({from + tick, from - tick}, {});
    canvas.line({from, to}, {.width = 2});
    canvas.line({to + tick, to - tick}, {});
    canvas.words(to + Spot{8, 0}, length_text(metres));
  }

  /// Names of the bodies with their colours, in lines from `top` down; returns how many lines it takes.
  int legend(Canvas* canvas, double top, int width) const {
    int lines = 1;
    double x = kMargin;
    for (std::size_t i = 1; i < sketch_.names.size(); ++i) {
      const double needs = 30 + 7.5 * static_cast<double>(sketch_.names[i].size());
      if (x > kMargin && x + needs > width - kMargin) x = kMargin, ++lines;
      if (canvas) {
        const Spot at{x, top - 20.0 * (lines - 1) + 18};
        canvas->line({at, at + Spot{16, 0}}, {MechanismDrawing::colour_of(static_cast<int>(i)), 4});
        canvas->words(at + Spot{22, 0}, sketch_.names[i], Canvas::Align::left, 10, "#444444");
      }
      x += needs + 8;
    }
    return lines;
  }

  const Run& run_;
  const Sketch& sketch_;
  int width_;
  MechanismDrawing drawing_;
  std::vector<std::vector<mbd::Vec2>> paths_;
};

std::vector<Poses> every_row(const Run& run) {
  std::vector<Poses> all;
  for (std::size_t row = 0; row < run.series.rows(); ++row) all.push_back(poses_at(run, row));
  return all;
}

void follow_in_all(std::vector<Poses>& all, std::vector<Panel>& panels, const Run& run, const std::string& body) {
  std::vector<Poses*> moved;
  for (Poses& poses : all) moved.push_back(&poses);
  for (Panel& panel : panels) moved.push_back(&panel.poses);
  follow(moved, *run.scenario.machine, body);
}

}  // namespace

void strip(const std::filesystem::path& directory, const std::filesystem::path& out, const StripOptions& options) {
  const Run run = read_run(directory);
  if (options.count < 1) throw std::invalid_argument("--strip: draws at least one picture; give 1 or more");
  const Sketch sketch = sketch_of(run.scenario);
  std::vector<Poses> all = every_row(run);
  std::vector<Panel> panels;
  if (run.scenario.runs_in_time())
    panels = instants(run, options);
  else if (run.scenario.analysis == Analysis::modes)
    panels = shapes(run, directory, sketch, options.count);
  else
    panels = {before_and_after(run)};
  follow_in_all(all, panels, run, options.follow);
  const Strip drawn(run, sketch, all, options);
  run_gnuplot(drawn.picture(panels, drawn.extent(panels)).script(out.extension().string()), out);
}

void each_instant(const std::filesystem::path& directory, const StripOptions& options,
                  const std::function<void(const Canvas&)>& take) {
  const Run run = read_run(directory);
  const Sketch sketch = sketch_of(run.scenario);
  std::vector<Poses> all = every_row(run);
  std::vector<Panel> panels = instants(run, options);
  follow_in_all(all, panels, run, options.follow);
  const Strip drawn(run, sketch, all, options);
  const Extent seen = drawn.extent(panels);
  for (const Panel& panel : panels) take(drawn.picture({panel}, seen));
}

bool is_still(const std::filesystem::path& directory) {
  const Json summary = read_json_if_whole(directory / "summary.json");
  if (!summary.is_object()) return false;
  const std::string word = summary.value("/run/analysis"_json_pointer, "");
  return word == "modes" || word == "equilibrium" || word == "assembly";
}

}  // namespace subsoil::sim
