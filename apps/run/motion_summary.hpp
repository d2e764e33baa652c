#pragma once
#include <functional>
#include <span>
#include <vector>

#include "apps/output/summary.hpp"
#include "apps/run/columns.hpp"

namespace subsoil::app {

/// What the summary takes of a machine alone, from instants so near that its method has resolved the motion between
/// them. Columns are there on the parabola through both and the middle: means by Simpson's rule, of order dt^4. Where
/// its vertex would be a new extreme, the motion itself is looked at, so that an extreme is always a value that was
/// there, also where a column jumps. The vertex is off by some dt^2, which takes some dt^4 from the extreme.
class MotionSummary {
 public:
  MotionSummary(const Columns& columns, Summary& summary);

  /// All columns at the first instant.
  void begin(double t, std::span<const double> row);
  /// All columns at the next one and halfway to it. `at`: what gives them at a time between.
  using At = std::function<std::span<const double>(double t)>;
  void add(double t, std::span<const double> middle, std::span<const double> row, const At& at);

 private:
  std::vector<double> of(std::span<const double> row) const;
  void look_at_vertices(double t, const std::vector<double>& middle, const std::vector<double>& end, const At& at);

  const Columns& columns_;
  Summary& summary_;
  double t_ = 0;
  std::vector<double> begin_, mean_;
};

}  // namespace subsoil::app
