#include "libsim/plot/plot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "libsim/base/problems.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/moving_mean.hpp"
#include "libsim/io/series.hpp"
#include "libsim/plot/gnuplot.hpp"
#include "libsim/post/unit_factor.hpp"

namespace subsoil::sim {
namespace {

constexpr double kSmoothing = 50e-3;  // s; what a load cell on a field frame resolves, and the summary's second mean
constexpr const char* kFirst[] = {"pull", "draft", "spring force", "pitch", "height"};

/// A unit that gives numbers a reader can take in: factor and its name.
struct Shown {
  double factor = 1;
  std::string unit;
};

struct PlottedLine {
  std::vector<double> x, y;
};

/// Range of an axis.
struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double size() const { return std::max(std::abs(low), std::abs(high)); }
};

Range range_of(const std::vector<double>& values) {
  Range range;
  for (const double v : values) range.take(v);
  return range;
}

std::string name_of(const std::filesystem::path& directory) {
  const auto whole = std::filesystem::absolute(directory).lexically_normal();
  return whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
}

/// In the units of the run before, which monitors may set otherwise in each.
void take_units_of(const NamedSeries& first, NamedSeries& run) {
  for (std::size_t c = 0; c < run.series.columns.size(); ++c) {
    SeriesColumn& column = run.series.columns[c];
    const int same = first.series.find(column.name);
    if (same < 0) continue;
    const std::string& unit = first.series.columns[static_cast<std::size_t>(same)].unit;
    const std::optional<double> factor = unit_factor(column.unit, unit);
    if (!factor) continue;  // refused where it is drawn
    if (*factor != 1)
      for (double& v : run.series.values[c]) v *= *factor;
    column.unit = unit;
  }
}

std::vector<NamedSeries> read_runs(const std::vector<std::filesystem::path>& directories) {
  if (directories.empty()) throw std::invalid_argument("nothing to plot: name at least one result directory");
  std::vector<NamedSeries> runs;
  for (const auto& directory : directories) {
    const auto path = directory / "series.csv";
    if (!std::filesystem::exists(path))
      throw std::invalid_argument(directory.string() + " holds no series.csv: is it the result directory of a run?");
    runs.push_back({name_of(directory), read_series(path)});
    if (runs.back().series.rows() < 2) throw std::invalid_argument(path.string() + " has fewer than two samples yet");
    runs.back().series.at("time");
  }
  for (std::size_t r = 1; r < runs.size(); ++r)
    for (std::size_t before = 0; before < r; ++before) take_units_of(runs[before], runs[r]);
  return runs;
}

/// A column that is not there, with the nearest that is.
[[noreturn]] void refuse_column(const char* flag, const std::string& wish, const std::vector<NamedSeries>& runs) {
  constexpr std::size_t most = 12;
  std::vector<std::string> names;
  for (const NamedSeries& run : runs)
    for (const SeriesColumn& column : run.series.columns)
      if (std::find(names.begin(), names.end(), column.name) == names.end()) names.push_back(column.name);
  const bool many = names.size() > most && nearest(wish, names) == nullptr;
  throw std::invalid_argument(
      fmt::format("{} {}: series.csv has no column of this name{}", flag, wish,
                  many ? fmt::format("; its first line names all {}", names.size()) : suggestion(wish, names)));
}

/// The wished columns; `foot` stands for all of foot.x, foot.y ...
std::vector<std::string> expanded(const std::vector<NamedSeries>& runs, const std::vector<std::string>& wished) {
  std::vector<std::string> names;
  for (const std::string& wish : wished) {
    const std::size_t before = names.size();
    for (const NamedSeries& run : runs)
      for (const SeriesColumn& column : run.series.columns)
        if (column.name == wish || column.name.rfind(wish + ".", 0) == 0)
          if (std::find(names.begin(), names.end(), column.name) == names.end()) names.push_back(column.name);
    if (names.size() == before) refuse_column("--columns", wish, runs);
  }
  return names;
}

/// What is drawn, in the order of the panels: names wished for, or every watch that any run has.
std::vector<std::string> choose_columns(const std::vector<NamedSeries>& runs, const std::vector<std::string>& wished) {
  const auto some_run_has = [&](const std::string& name) {
    return std::any_of(runs.begin(), runs.end(), [&](const NamedSeries& run) { return run.series.find(name) >= 0; });
  };
  if (!wished.empty()) return expanded(runs, wished);
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (some_run_has(name) && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const char* name : kFirst) add(name);
  for (const auto& run : runs)
    for (const auto& column : run.series.columns)
      if (column.is_watch()) add(column.name);
  if (names.empty())
    throw std::invalid_argument("no run has a monitor: name one under output.monitor, or columns to plot");
  return names;
}

/// `size` is the largest number to be shown, of all panels with this unit.
Shown shown_unit(const std::string& unit, double size) {
  if (unit == "N" && size >= 2000) return {1e-3, "kN"};
  if (unit == "N m" && size >= 2000) return {1e-3, "kN m"};
  if (unit == "rad") return {180 / std::acos(-1.0), "deg"};
  if (unit == "rad/s" && size < 20) return {180 / std::acos(-1.0), "deg/s"};
  if (unit == "m" && size < 1e-3) return {1e6, "µm"};
  if (unit == "m" && size < 1) return {1e3, "mm"};
  if (unit == "s" && size < 2e-3) return {1e6, "µs"};
  if (unit == "s" && size < 0.2) return {1e3, "ms"};
  if (unit == "J" && size >= 2000) return {1e-3, "kJ"};
  if (unit == "W" && size >= 2000) return {1e-3, "kW"};
  if (unit == "Pa" && size >= 2e6) return {1e-6, "MPa"};
  if (unit == "Pa" && size >= 2000) return {1e-3, "kPa"};
  return {1, unit};
}

PlottedLine smoothed(const PlottedLine& line) {
  PlottedLine means;
  MovingMean mean(kSmoothing);
  for (std::size_t i = 1; i < line.x.size(); ++i) {
    mean.add(line.x[i], line.x[i] - line.x[i - 1], line.y[i]);
    if (!mean.full()) continue;
    means.x.push_back(line.x[i] - kSmoothing / 2);  // a mean belongs to the middle of its interval
    means.y.push_back(mean.mean());
  }
  return means;
}

/// Forces of the soil are rough: the mean tells more than the samples. A spring's or a pose's curve would only lose its
/// peaks. Rough is a curve from which the mean takes something visible (1 % of its range), of which at least half jumps
/// from one sample to the next.
bool is_rough(const PlottedLine& line, const PlottedLine& means) {
  if (means.x.size() < line.x.size() / 2 || means.x.size() < 200) return false;
  const std::size_t skipped = (line.x.size() - means.x.size()) / 2;
  double jumps = 0, taken = 0;
  for (std::size_t i = 0; i < means.y.size(); ++i) {
    jumps += std::pow(line.y[i + skipped + 1] - line.y[i + skipped], 2);
    taken += std::pow(line.y[i + skipped] - means.y[i], 2);
  }
  const Range range = range_of(line.y);
  const double visible = 0.01 * (range.high - range.low);
  return taken > visible * visible * static_cast<double>(means.y.size()) && jumps > 0.25 * taken;
}

/// At most about `bins` pairs of lowest and highest value: a peak is never thinned away.
PlottedLine thinned(const PlottedLine& line, std::size_t bins) {
  if (line.x.size() <= 2 * bins) return line;
  PlottedLine thin;
  for (std::size_t k = 0; k < bins; ++k) {
    const std::size_t begin = k * line.x.size() / bins, end = (k + 1) * line.x.size() / bins;
    const auto at = [&](std::size_t i) { return line.y.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto [low, high] = std::minmax_element(at(begin), at(end));
    for (const auto value : {std::min(low, high), std::max(low, high)}) {
      thin.x.push_back(line.x[static_cast<std::size_t>(value - line.y.begin())]);
      thin.y.push_back(*value);
    }
  }
  return thin;
}

/// The gnuplot script, panel by panel.
class Sheet {
 public:
  Sheet(const std::vector<NamedSeries>& runs, const std::string& x, const std::vector<std::string>& columns,
        const PlotOptions& options, const std::string& terminal)
      : runs_(runs), x_name_(x), columns_(columns), options_(options) {
    const Panel along = panel_of(x);
    x_range_ = along.range, x_shown_ = shown_unit(along.unit, along.range.size());
    top_ = 46;
    height_ = top_ + 58 + static_cast<int>(columns.size()) * options.panel_height;
    script_ = fmt::format(
        "set encoding utf8\n{}set output {{out}}\n"
        "set border 3 linecolor rgb '#555555'\nset tics nomirror out scale 0.6 textcolor rgb '#222222'\n"
        "set grid xtics ytics linetype 1 linewidth 0.6 linecolor rgb '#e4e4e4'\nset mxtics 2\n"
        "set xzeroaxis linetype 1 linewidth 1 linecolor rgb '#999999'\n"
        "set xrange [{:.9g}:{:.9g}]\nset multiplot\nset lmargin at screen {:.5f}\nset rmargin at screen 0.975\n",
        gnuplot_terminal(terminal, options.width, height_), x_range_.low * x_shown_.factor,
        x_range_.high * x_shown_.factor, 92.0 / options.width);
    for (std::size_t i = 0; i < columns.size(); ++i) add_panel(i);
    script_ += "unset multiplot\nunset output\n";
  }
  const std::string& script() const { return script_; }

 private:
  void add_block(const std::string& name, const PlottedLine& line, double factor) {
    script_ += '$' + name + " << EOD\n";
    for (std::size_t i = 0; i < line.x.size(); ++i) {
      csv::append_number(script_, line.x[i] * x_shown_.factor);
      script_ += ' ';
      // gnuplot leaves a gap where it reads NaN.
      csv::append_number(script_, line.y[i] * factor, 7);
      script_ += '\n';
    }
    script_ += "EOD\n";
  }

  struct Panel {
    std::string unit;
    Range range;
  };
  /// Unit and range of a column over all runs.
  Panel panel_of(const std::string& name) const {
    Panel panel;
    for (const auto& run : runs_) {
      const int column = run.series.find(name);
      if (column < 0) continue;
      const std::string& unit = run.series.columns[static_cast<std::size_t>(column)].unit;
      if (!panel.unit.empty() && panel.unit != unit)
        throw std::invalid_argument(
            fmt::format("column {}: is in {} in {} and in {} before it; leave it out, or draw one run", name, unit,
                        run.name, panel.unit));
      panel.unit = unit;
      const auto own = range_of(run.series.values[static_cast<std::size_t>(column)]);
      panel.range.take(own.low);
      panel.range.take(own.high);
    }
    if (panel.range.low > panel.range.high) panel.range = {0, 1};  // nothing finite anywhere
    return panel;
  }

  void add_panel(std::size_t panel) {
    const auto& name = columns_[panel];
    const auto [unit, range] = panel_of(name);
    double size = range.size();
    if (unit == "N" || unit == "N m")  // forces side by side are compared: one unit for all
      for (const auto& other : columns_)
        if (const auto p = panel_of(other); p.unit == unit) size = std::max(size, p.range.size());
    const Shown shown = shown_unit(unit, size);
    std::string faint, strong;
    const auto bins = static_cast<std::size_t>(2 * options_.width);
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      const auto& series = runs_[r].series;
      const int column = series.find(name);
      if (column < 0) continue;
      const PlottedLine line{series.at(x_name_), series.values[static_cast<std::size_t>(column)]};
      const char* colour = plot_colours[r % plot_colours.size()];
      const auto block = fmt::format("p{}r{}", panel, r);
      std::string drawn = block;
      add_block(block, thinned(line, bins), shown.factor);
      if (const PlottedLine means = smoothed(line); x_name_ == "time" && is_rough(line, means)) {
        any_rough_ = true;
        faint += fmt::format("${} with lines linewidth 0.7 linecolor rgb '#60{}' notitle, ", block, colour + 1);
        drawn += "mean";
        add_block(drawn, thinned(means, bins), shown.factor);
      }
      strong += fmt::format("${} with lines linewidth 1.8 linecolor rgb '{}' title {}, ", drawn, colour,
                            panel == 0 && runs_.size() > 1 ? gnuplot_text(runs_[r].name) : "''");
    }
    place(panel, range, shown);
    script_ += fmt::format("set ylabel {} offset 0.6,0 textcolor rgb '#222222'\n",
                           gnuplot_text(shown.unit == "1" ? name : name + " [" + shown.unit + "]"));
    if (any_rough_ && panel + 1 == columns_.size())
      script_ += fmt::format(
          "set label 1 'thin: samples, thick: 50 ms means' at screen 0.975,{:.5f} right font ',9' "
          "textcolor rgb '#777777'\n",
          14.0 / height_);
    script_ += "plot " + faint + strong;
    script_.erase(script_.size() - 2);
    script_ += '\n';
  }

  /// Margins, axes, and the key above the first panel.
  void place(std::size_t panel, Range range, const Shown& shown) {
    const double pad = std::max(0.06 * (range.high - range.low), 1e-3 * range.size() + 1e-12);
    const auto screen = [&](double pixels_from_top) { return 1 - pixels_from_top / height_; };
    const double begin = top_ + static_cast<double>(panel) * options_.panel_height;
    const bool last = panel + 1 == columns_.size();
    script_ += fmt::format("set tmargin at screen {:.5f}\nset bmargin at screen {:.5f}\nset yrange [{:.9g}:{:.9g}]\n",
                           screen(begin + 8), screen(begin + options_.panel_height - 8),
                           (range.low - pad) * shown.factor, (range.high + pad) * shown.factor);
    if (panel == 0 && runs_.size() > 1)
      script_ += fmt::format("set key at screen 0.975,{:.5f} right top horizontal samplen 2 spacing 1.1\n", screen(10));
    else
      script_ += "unset key\n";
    if (panel == 0 && runs_.size() == 1)
      script_ += fmt::format("set label 2 {} at screen {:.5f},{:.5f} left font ',12' textcolor rgb '#222222'\n",
                             gnuplot_text(runs_.front().name), 92.0 / options_.width, screen(24));
    else
      script_ += "unset label 2\n";
    script_ += last ? fmt::format("set format x '%g'\nset xlabel {} textcolor rgb '#222222'\n",
                                  gnuplot_text(x_name_ + " [" + x_shown_.unit + "]"))
                    : "set format x ''\nunset xlabel\n";
  }

  const std::vector<NamedSeries>& runs_;
  const std::string x_name_;
  const std::vector<std::string>& columns_;
  const PlotOptions& options_;
  Range x_range_;
  Shown x_shown_;
  int top_ = 0, height_ = 0;
  bool any_rough_ = false;
  std::string script_;
};

}  // namespace

void plot(const std::vector<std::filesystem::path>& directories, const std::filesystem::path& out,
          const PlotOptions& options) {
  const auto runs = read_runs(directories);
  const auto columns = choose_columns(runs, options.columns);
  for (const NamedSeries& run : runs)
    if (run.series.find(options.over) < 0) refuse_column("--over", options.over, {run});
  plot_series(runs, options.over, columns, out, options);
}

void plot_series(const std::vector<NamedSeries>& runs, const std::string& x, const std::vector<std::string>& columns,
                 const std::filesystem::path& out, const PlotOptions& options) {
  run_gnuplot(Sheet(runs, x, columns, options, out.extension().string()).script(), out);
}

}  // namespace subsoil::sim
