#pragma once
#include <span>
#include <vector>

#include "libsim/io/summary.hpp"
#include "libsim/run/columns.hpp"

namespace subsoil::sim {

/// What the summary takes of a machine alone, from instants so near that its method has resolved the motion between
/// them. Columns are there on the parabola through both and the middle: means by Simpson's rule, of order dt^4.
/// Extremes are those of the instants, which are to be taken at the extrema that `request()` requests: so an extreme is
/// always a value that was there, also where a column jumps or turns sharply.
class MotionSummary {
 public:
  MotionSummary(const Columns& columns, Summary& summary);

  /// All columns at the first instant.
  void begin(double t, std::span<const double> row);
  /// All columns at the next one and halfway to it.
  void add(double t, std::span<const double> middle, std::span<const double> row);
  /// Adds the extremes so far, where `t` lies in the window.
  void request(double t, std::vector<mbd::Request>& out) const;

 private:
  std::vector<double> of(std::span<const double> row) const;

  const Columns& columns_;
  Summary& summary_;
  double t_ = 0;
  std::vector<double> begin_, mean_;
};

}  // namespace subsoil::sim
