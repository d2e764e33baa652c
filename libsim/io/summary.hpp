#pragma once
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libsim/base/json_fwd.hpp"
#include "libsim/io/block_mean.hpp"
#include "libsim/io/moving_mean.hpp"
#include "libsim/io/series.hpp"

/// summary.json: what a reader wants to know of a run without opening anything else.
namespace subsoil::sim {

/// Extremes of a moving mean and when its interval ended.
struct Extremes {
  double low = std::numeric_limits<double>::infinity(), low_time = 0;
  double high = -std::numeric_limits<double>::infinity(), high_time = 0;
  void take(double time, double value);
  void archive(Archive& a) { a("low", low)("low time", low_time)("high", high)("high time", high_time); }
};

/// Whether a signal is steady; null where too little is known.
Json steady_json(const BlockMean& mean);

/// Takes every step of the run (samples would hide peaks) and keeps for each column
///  - mean over the window, weighted with time, its interval (BlockMean), and plain extremes in it,
///  - extremes of the 1 ms and 50 ms moving means, over the whole run and over the window.
/// A moving mean counts once its interval is full; for the window, once the interval lies in it.
class Summary {
 public:
  explicit Summary(std::vector<SeriesColumn> columns);
  ~Summary();
  Summary(Summary&&) noexcept;

  /// Window of the means; by default it opens never. May be set or moved as long as the run is before `from`, and after
  /// a provisional one.
  void set_window(double from, double until, std::string reason = {});
  /// The whole run, until a window is set: what was taken by then is forgotten.
  void set_provisional_window(double from, double until, std::string reason);
  void drop_window();  ///< means are null
  /// Ends an open window now or later. What was taken stays.
  void close_window(double until);
  /// Intervals of means are those of blocks of this length.
  void take_blocks_of(double period);
  /// Means and what else is of the window end with its last whole period: with the step in which that ended.
  void take_whole_periods(double period) { period_ = period, take_blocks_of(period); }
  bool is_open() const { return time_ >= from_ && time_ < until_; }
  double window_from() const { return from_; }
  double window_until() const;

  /// Values at the begin of the step that ends at `time` and lasted `duration`; for means they stand for the whole
  /// step.
  void sample(double time, double duration, std::span<const double> values);
  /// The same of a motion that is known between: means over the step, and values at any instant, for extremes.
  void sample_mean(double time, double duration, std::span<const double> means);
  void see(double time, std::span<const double> values);
  /// Lowest and highest value of column i in the window so far, where that holds `time`.
  std::optional<std::pair<double, double>> extremes(std::size_t i, double time) const;

  /// Free sections, in the order of first use: summary.section("run")["threads"] = 2.
  Json& section(const std::string& name);
  void warn(const std::string& text);
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Mean of a column over the window, which a whole number of periods of it may shorten.
  const BlockMean& over_window(const std::string& column) const;
  const std::string& unit(const std::string& column) const;
  double mean(const std::string& column) const;  ///< NaN before the window opens
  Json to_json() const;
  /// All that was taken, with the window and the warnings; not the sections.
  void archive(Archive& a);
  /// Complete or not at all (temporary file and rename).
  void write(const std::filesystem::path& path) const;

 private:
  /// What is of the window.
  struct InWindow {
    BlockMean mean;
    Extremes steps, fine, coarse;
    void archive(Archive& a) { a("mean", mean)("steps", steps)("fine", fine)("coarse", coarse); }
  };
  struct Column {
    SeriesColumn column;
    MovingMean fine{1e-3}, coarse{50e-3};
    Extremes fine_run, coarse_run;
    InWindow now, whole;  ///< up to now, and up to the last whole period
    void archive(Archive& a) {
      a("fine", fine)("coarse", coarse)("fine run", fine_run)("coarse run", coarse_run)("now", now)("whole", whole);
    }
  };
  bool holds(double time) const { return time >= from_ && time <= until_; }
  double inside(double time, double duration) const;
  void refuse_other_count(std::size_t values) const;
  void empty_window();
  void take(Column& c, double time, double duration, double inside, double value) const;
  const InWindow& in_window(const Column& c) const { return period_ > 0 ? c.whole : c.now; }
  std::size_t index(const std::string& name) const;
  Json column_json(const Column& c) const;

  std::vector<Column> columns_;
  double from_ = std::numeric_limits<double>::infinity(), until_ = from_;
  std::string reason_;
  double duration_ = 0, whole_duration_ = 0, time_ = 0;
  double block_ = 0, period_ = 0;  ///< 0: none
  bool provisional_ = false;
  std::unique_ptr<Json> sections_;
  std::vector<std::string> warnings_;
};

}  // namespace subsoil::sim
