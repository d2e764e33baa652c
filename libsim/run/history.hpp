#pragma once
#include <deque>
#include <limits>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libmbd/search/requests.hpp"
#include "libsim/scenario/sections/output.hpp"

namespace subsoil::sim {

/// A quantity over time, followed from the start: its integral, derivative, mean and extremes (of all or of the last
/// `within`), how often it passed a value, how long it was beyond one.
///
/// Between two instants it is a parabola through a third value in the middle, a line where that is not known, or, for
/// forces that act over a step, what it was at the step's start. Errors of an integral are of order dt^4, dt^2 and
/// none. A mean and an integral are of the time in which there is a value (0/0 at rest is none). Extremes are values
/// that were there: of the instants, which `request()` puts at extrema, and of what lies midway.
class History {
 public:
  struct Rule {
    Watch::Kind kind = Watch::Kind::integral;
    double within = std::numeric_limits<double>::infinity();  ///< s
    double level = 0;
    bool rising = true, falling = true;
    bool unbroken = false;
    bool held = false;
    double noise = 0;     ///< what is nearer to the level counts as on it, and on no other side of it
    double shortest = 0;  ///< s; over less no derivative is taken: what comes then counts as of the instant before
  };
  History() = default;
  explicit History(const Rule& rule) : rule_(rule) {}

  /// The next instant, or the same one behind a jump. `middle`: halfway since the one before; NaN: not known.
  void add(double t, double y, double middle);
  double value() const { return value_; }
  /// At a time between the last two instants: integrals and means of the piece up to there, else on a line.
  double at(double t) const;
  /// Adds the value that `column`, which is followed, has yet to pass, the extreme so far, or that it is integrated.
  void request(std::size_t column, std::vector<mbd::Request>& out) const;
  void archive(Archive& a);

 private:
  /// y(s) = y_0 + a s + b s^2, s in [0, 1], over dt from t.
  struct Piece {
    double t = 0, dt = 0, y = 0, a = 0, b = 0;
    double at(double s) const { return y + s * (a + s * b); }
    /// Integral from s to 1.
    double integral_from(double s) const;
    double largest(double s, double sign) const;
    void archive(Archive& to) { to("t", t)("dt", dt)("y", y)("a", a)("b", b); }
  };
  struct Peak {
    Piece piece;
    double largest = 0;  ///< of the piece, times the sign
    void archive(Archive& a) { a("piece", piece)("largest", largest); }
  };
  Piece piece_to(double t, double y, double middle) const;
  void take_mean(const Piece& p);
  void take_extreme(const Piece& p, double sign);
  void take_jump(double y);
  void take_count(double y);
  void take_time(const Piece& p, double sign);

  Rule rule_;
  bool begun_ = false;
  double start_ = 0, t_ = 0, y_ = 0, value_ = 0;
  Piece last_;                    ///< up to t_
  double before_ = 0;             ///< the value where it begins
  double sum_ = 0, counted_ = 0;  ///< of a mean: integral and time of `pieces_`
  int side_ = 0;
  std::deque<Piece> pieces_;  ///< of a mean: what lies within
  std::deque<Peak> peaks_;    ///< of an extreme: falling in size, rising in time
};

/// SI unit of the integral over time and of the derivative of what has the unit: N -> N s, m/s -> m.
std::string unit_times_second(const std::string& unit);
std::string unit_per_second(const std::string& unit);

}  // namespace subsoil::sim
