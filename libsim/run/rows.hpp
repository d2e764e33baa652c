#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/io/series_writer.hpp"

namespace subsoil::sim {

class Columns;

/// Rows of series.csv at any time between instants t_n of the step. With w = (t_n - t)/(t_n - t_{n-1}) a row at t is
///   w y_{n-1} + (1 - w) y_n,
/// of second order in the step, as the leapfrog is: the error of a smooth column is up to y'' dt^2/8. Columns of means
/// hold what acts in the step that begins at t_n until t_{n+1}, as the coupling does, and are cut at the row. The
/// machine's columns are known where its windows end: rows inside a window wait for that. Sums over all spheres that
/// jump at t_n, where a block of soil enters and another leaves, are before it those of t_{n-1}. Counts and what is
/// open or sticks are those of the nearer instant; integrals and means over time are those up to the row.
class Rows {
 public:
  /// @param machine_time of the instant that the machine's columns are of: the start of the window that a state lies in
  Rows(const Columns& columns, SeriesWriter& series, double close, double machine_time);

  /// The instant t_n: values of all columns, what acts from then on in columns of means.
  /// @param jumps whether soil has entered or left as a block at t_n
  void begin_instant(double t, std::span<const double> values, bool jumps);
  /// A row at t, t_{n-1} < t <= t_n; within `close` of an instant it is of that.
  void add(double t);
  /// `machine_stands`: its columns are of this instant, and not of the start of a window.
  void end_instant(bool machine_stands);
  /// Whether rows wait for the end of the machine's window.
  bool wait() const { return !waiting_.empty(); }
  /// The row written last.
  const std::vector<double>& last() const { return last_; }

  void archive(Archive& a);

 private:
  struct Point {
    double t = 0;
    std::vector<double> values;
    void archive(Archive& a) { a("t", t)("values", values); }
  };
  double share_before(const Point& before, const Point& now, double t) const;
  double between(std::size_t column, double before, double now, double share) const;

  const Columns& columns_;
  SeriesWriter& series_;
  double close_, machine_time_;
  Point before_, now_, machine_before_, machine_now_;
  std::vector<Point> waiting_;
  IntervalMean means_;
  double held_until_ = 0;
  bool begun_ = false;
  bool jumps_ = false;  ///< at the instant now
  std::vector<double> last_;
};

}  // namespace subsoil::sim
