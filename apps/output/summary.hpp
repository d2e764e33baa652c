#pragma once
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "apps/output/moving_mean.hpp"
#include "apps/output/series.hpp"

/// summary.json: what a reader wants to know of a run without opening anything else.
namespace subsoil::app {

/// Extremes of a moving mean and when its interval ended.
struct Extremes {
  double low = std::numeric_limits<double>::infinity(), low_time = 0;
  double high = -std::numeric_limits<double>::infinity(), high_time = 0;
  void take(double time, double value);
};

/// Takes every step of the run (samples would hide peaks) and keeps for each column
///  - mean over the window, weighted with time, and plain extremes in it,
///  - extremes of the 1 ms and 50 ms moving means, over the whole run and over the window.
/// A moving mean counts once its interval is full; for the window, once the interval lies in it.
class Summary {
 public:
  explicit Summary(std::vector<SeriesColumn> columns);

  /// Window of the means; by default it opens never. May be set or moved as long as the run is before `from`.
  void set_window(double from, double until, std::string reason = {});
  double window_from() const { return from_; }
  double window_until() const { return until_; }

  /// Values over the step that ends at `time` and lasted `duration`.
  void sample(double time, double duration, std::span<const double> values);

  /// Share of the draft that a wall carries: peak over the window of |50 ms mean of `wall` - baseline| over |window
  /// mean of `draft`|. The baseline is what the wall carries before the tool comes (mean over [from, until]); the bed's
  /// own weight leans on the end walls. Both are names of columns, forces along the draft.
  void share_of(const std::string& wall, const std::string& draft, double baseline_from, double baseline_until);

  /// Free sections, in the order of first use: summary.section("run")["threads"] = 2.
  nlohmann::ordered_json& section(const std::string& name) { return sections_[name]; }
  void warn(const std::string& text) { warnings_.push_back(text); }

  double mean(const std::string& column) const;  ///< over the window; NaN before it opens
  /// Shares by wall, with a warning for each above `limit`.
  nlohmann::ordered_json to_json(double share_limit = 0.05) const;
  /// Complete or not at all (temporary file and rename).
  void write(const std::filesystem::path& path) const;

 private:
  struct Column {
    SeriesColumn column;
    double integral = 0;
    Extremes steps;
    MovingMean fine{1e-3}, coarse{50e-3};
    Extremes fine_run, fine_window, coarse_run, coarse_window;
  };
  struct Share {
    std::size_t wall, draft;
    double from, until;
    double integral = 0, duration = 0;
    double baseline() const { return duration > 0 ? integral / duration : 0; }
    /// |x - b| peaks where x does, above or below: two extremes give it without a second pass.
    double peak(const Extremes& e) const;
  };
  std::size_t index(const std::string& name) const;
  nlohmann::ordered_json column_json(const Column& c) const;

  std::vector<Column> columns_;
  std::vector<Share> shares_;
  double from_ = std::numeric_limits<double>::infinity(), until_ = from_;
  std::string reason_;
  double duration_ = 0, time_ = 0;
  nlohmann::ordered_json sections_ = nlohmann::ordered_json::object();
  std::vector<std::string> warnings_;
};

}  // namespace subsoil::app
