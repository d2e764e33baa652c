#include "libsim/run/motion_summary.hpp"

#include <cmath>

namespace subsoil::sim {

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

void MotionSummary::add(double t, std::span<const double> middle, std::span<const double> row) {
  std::vector<double> half = of(middle);
  const std::vector<double> end = of(row);
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    // A derivative has no value before its first line, whose slope it has at the end.
    if (columns_.of_history(columns_.summarised()[i]))
      half[i] = std::isnan(begin_[i]) ? end[i] : 0.5 * (begin_[i] + end[i]);
    const double simpson = (begin_[i] + 4 * half[i] + end[i]) / 6;
    mean_[i] = std::isfinite(simpson) ? simpson : half[i];  // as 0/0 at rest
  }
  summary_.see(0.5 * (t_ + t), half);
  summary_.see(t, end);
  summary_.sample_mean(t, t - t_, mean_);
  t_ = t, begin_ = end;
}

void MotionSummary::request(double t, std::vector<mbd::Request>& out) const {
  for (std::size_t i = 0; i < columns_.summarised().size(); ++i) {
    const std::size_t column = columns_.summarised()[i];
    const auto extremes = summary_.extremes(i, t);
    if (!extremes || columns_.of_history(column)) continue;
    out.push_back({column, 1, extremes->first, mbd::Request::Kind::extremum});
    out.push_back({column, -1, extremes->second, mbd::Request::Kind::extremum});
  }
}

}  // namespace subsoil::sim
