#include "apps/run/motion_summary.hpp"

#include <cmath>

namespace subsoil::app {

MotionSummary::MotionSummary(const Columns& columns, Summary& summary)
    : columns_(columns), summary_(summary), mean_(columns.summarised().size()) {}

std::vector<double> MotionSummary::of(std::span<const double> row) const {
  std::vector<double> out;
  for (const std::size_t c : columns_.summarised()) out.push_back(row[c]);
  return out;
}

void MotionSummary::begin(double t, std::span<const double> row) {
  t_ = t, begin_ = of(row);
  summary_.see(t_, begin_);
}

void MotionSummary::add(double t, std::span<const double> middle, std::span<const double> row, const At& at) {
  std::vector<double> half = of(middle);
  const std::vector<double> end = of(row);
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    if (columns_.of_history(columns_.summarised()[i])) half[i] = 0.5 * (begin_[i] + end[i]);
    const double simpson = (begin_[i] + 4 * half[i] + end[i]) / 6;
    mean_[i] = std::isfinite(simpson) ? simpson : half[i];  // as 0/0 at rest
  }
  summary_.see(0.5 * (t_ + t), half);
  summary_.see(t, end);
  look_at_vertices(t, half, end, at);
  summary_.sample_mean(t, t - t_, mean_);
  t_ = t, begin_ = end;
}

void MotionSummary::look_at_vertices(double t, const std::vector<double>& middle, const std::vector<double>& end,
                                     const At& at) {
  for (std::size_t i = 0; i < end.size(); ++i) {
    if (columns_.of_history(columns_.summarised()[i])) continue;
    const double a = -3 * begin_[i] + 4 * middle[i] - end[i], b = 2 * (begin_[i] - 2 * middle[i] + end[i]);
    const double share = -a / (2 * b), vertex = begin_[i] + 0.5 * share * a;
    if (!(share > 0 && share < 1) || !summary_.is_extreme(i, t, vertex)) continue;
    const double time = t_ + share * (t - t_);
    summary_.see(time, of(at(time)));
  }
}

}  // namespace subsoil::app
