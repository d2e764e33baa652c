#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libmbd/search/requests.hpp"
#include "libsim/io/summary.hpp"

namespace subsoil::sim {

class Columns;
struct Loaded;

/// Instants at which columns of the series pass values that the scenario names (output.crossings): counted, written to
/// the summary, and the end of the run where it is asked for. Conditions that end the run (time.stop when) besides.
class Crossings {
 public:
  /// What lies within the interval since the look before: share in (0, 1] of it at which `column` - `level`, there on
  /// `side` and `at_start`, now `at_end`, comes to the other side.
  struct Passage {
    std::size_t column;
    double level;
    int side;
    double at_start, at_end;
  };
  using Locate = std::function<double(const Passage&)>;

  /// Throws ScenarioError for a column that is not there, or a value of another unit.
  Crossings(const Loaded& loaded, const Columns& columns);

  bool any() const { return !list_.empty() || !stops_.empty(); }
  /// Whether one of them is of a sum over all spheres, which steps make only where asked.
  bool needs_sums() const { return needs_sums_; }
  /// Whether one of them is of a column that is followed over time.
  bool of_history() const { return of_history_; }
  /// At every instant, with all columns. True where the run is to end by now.
  bool look(double t, std::span<const double> values, const Locate& locate);
  /// Adds the values that columns have yet to pass, from the look before on.
  void request(std::vector<mbd::Request>& out) const;
  /// On a line between two instants: of second order in the step.
  static double on_a_line(const Passage& p) { return p.at_start / (p.at_start - p.at_end); }

  /// When and by which the run was ended; empty where it was not.
  const std::string& stopped_by() const { return stopped_by_; }
  double stopped_at() const { return stopped_at_; }

  void write(Summary& summary) const;
  void archive(Archive& a) {
    a("list", list_)("looked at", looked_at_)("looked", looked_)("stopped by", stopped_by_)("stopped at", stopped_at_);
    if (!stops_.empty()) a("stops", stops_);
  }

 private:
  struct Crossing {
    std::string name;
    std::size_t column = 0;
    double level = 0;
    bool rising = true, falling = true;
    long stop_after = 0;
    int side = 0;
    double noise = 0;  ///< what is nearer to the level is on it
    double value = 0;  ///< less the level, at the look before
    std::vector<double> times;
    void archive(Archive& a) { a("side", side)("value", value)("times", times); }
  };
  /// A condition: beyond the level for a while.
  struct Stop {
    std::string name;
    std::size_t column = 0;
    double level = 0;
    int sign = 1;  ///< +1: above, -1: below
    double held = 0;
    double noise = 0;  ///< what is nearer to the level is on it
    bool beyond = false;
    double since = 0;
    double value = 0;  ///< less the level, at the look before
    void archive(Archive& a) { a("beyond", beyond)("since", since)("value", value); }
  };
  bool pass(Crossing& c, double t, double value, const Locate& locate);
  void look(Stop& s, double t, double value, const Locate& locate);
  void stop(const std::string& by, double at);

  std::vector<Crossing> list_;
  std::vector<Stop> stops_;
  bool needs_sums_ = false, of_history_ = false, looked_ = false;
  double looked_at_ = 0;
  std::string stopped_by_;
  double stopped_at_ = 0;
};

}  // namespace subsoil::sim
