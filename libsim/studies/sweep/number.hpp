#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libsim/document/node.hpp"

namespace subsoil::sim {

struct RunFolder;

/// A number of every run of a study.
struct SweepNumber {
  enum class Take { mean, least, largest, span, deviation, last, rms, integral };
  enum class Match { nearest, order };
  std::string name, column, summary, off_text, path_text;
  Take take = Take::mean;
  Match match = Match::nearest;
  std::vector<double> points;
  std::optional<double> from, until;

  template <class V>
  void describe(V& v) {
    v.text("column", column, "of series.csv, such as draft or soil.draft");
    v.text("summary", summary, "in place of a column: path in summary.json with / between, such as run/wall time [s]");
    v.joined_text("path", path_text,
                  "in place of a column: the two columns of a path in the plane, [tip.x, tip.y]; the number is how far "
                  "it passes from `points`");
    v.quantities("points", points, "m", "(-inf, inf)", "x and y of each point that `path` shall pass: 0 0 10 5 mm");
    v.choice("match", match, {{"nearest", Match::nearest}, {"order", Match::order}},
             "what of the path is held against a point: its nearest place, on lines between rows, or the row of the "
             "point's number (output.series at)");
    v.choice(
        "take", take,
        {{"mean", Take::mean},
         {"least", Take::least},
         {"largest", Take::largest},
         {"span", Take::span},
         {"deviation", Take::deviation},
         {"last", Take::last},
         {"rms", Take::rms},
         {"integral", Take::integral}},
        "what is taken of the column in the window, or of the distances from the points; mean, integral, least, "
        "largest and span over the run's own window are those of summary.json, of every step, if it holds the "
        "column, as it does of every monitor; others are those of rows, which have to be close enough for them; means "
        "are over "
        "time: columns of means count with their "
        "intervals, others by the trapezium rule; integral: likewise, of instants by parabolas through rows; last: "
        "at the window's end, on a line between rows");
    v.text("off", off_text,
           "a formula in t (s), in the unit of the column: what is taken is |column - formula|, whose mean, largest or "
           "rms `take` "
           "chooses");
    v.quantity("from", from, "s", "[0, inf)", "window of this number; left out: the run's own, else its whole record");
    v.quantity("until", until, "s", "(0, inf)", "end of it");
  }
  /// What is wrong with it beyond single keys: key and rule; empty where nothing is.
  std::pair<std::string, std::string> fault() const;
};

struct NumberOfRun {
  double value, half_width;  ///< half of the 95 % interval of a mean; NaN where it could not be taken
};
/// Paths in a plan (`numbers.NAME.KEY`) and the rules that its numbers break in runs of the scenario, where what varies
/// does not move their end.
std::vector<std::pair<std::string, std::string>> faults_of(const std::vector<SweepNumber>& numbers,
                                                           const Node& scenario,
                                                           const std::vector<std::string>& varied);

NumberOfRun take_number(const RunFolder& run, const SweepNumber& number);
/// Of the number: its column's, that in brackets in the summary's path, or empty where none is known.
std::string unit_of(const RunFolder& run, const SweepNumber& number);

/// Integral over time of a record by parabolas through three rows each, equally far apart or not (Simpson's rule; the
/// last interval of an even number of rows by the parabola of the last three).
double integral_over(const std::vector<double>& time, const std::vector<double>& values);

}  // namespace subsoil::sim
