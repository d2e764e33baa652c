#include "libmbd/search/step_search.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::mbd {

namespace {
// Requests that a part between two instants is divided at, the earliest first; what lies before one is searched half as
// long.
constexpr int most_splits = 6;
constexpr int most_halvings = 7;  // of a part, for what is integrated
// What a part's integral may be off by, of the sizes in it: a jump of 1 % somewhere in it is.
constexpr double share_of_size = 3e-3;
}  // namespace

bool StepSearch::search(const DenseOutput& step, double from, double until, int parts, std::vector<double>& row) {
  step_ = &step, row_ = &row;
  const double begin = from;
  for (segment_ = 0; segment_ < step.count(); ++segment_) {
    const DenseOutput::Span segment = step.span(segment_);
    const double first = std::max(begin, segment.begin), last = std::min(until, segment.end);
    if (!(last > first)) continue;
    // What jumps at the begin itself may be in the step that begins there.
    if (segment.jumps && (segment_ > 0 || first > begin)) {
      sample(first, row);
      if (signals_.take_jump(first, row)) return true;
    }
    for (int part = 1; part <= parts; ++part) {
      const auto end_of = [&](int k) { return k == parts ? last : first + (last - first) * k / parts; };
      if (search_part(end_of(part - 1), end_of(part), {most_splits, most_halvings})) return true;
    }
  }
  return false;
}

void StepSearch::sample(double t, std::vector<double>& row) {
  signals_.sample(t, evaluation_.evaluate(*step_, t, segment_), row);
}

bool StepSearch::search_part(double from, double until, Splits left) {
  begin_ = middle_ = between_ = *row_;
  sample(0.5 * (from + until), middle_), sample(until, *row_);
  requests_.clear();
  signals_.request(until, requests_);
  signals_.rounding(evaluation_.instant(), *row_, rounding_);
  const auto at = [&](double t) {
    sample(t, between_);
    return std::span<const double>(between_);
  };
  const MotionPart part{from, until, begin_, middle_, *row_, rounding_, at};
  const auto split = [&](double t, Splits first, Splits second) {
    *row_ = begin_;
    return search_part(from, t, first) || search_part(t, until, second);
  };
  const auto met = left.at_requests > 0 ? find_first(requests_, part) : std::nullopt;
  if (met) return split(*met, {left.at_requests / 2, left.in_halves}, {left.at_requests - 1, left.in_halves});
  const Splits halved{left.at_requests, left.in_halves - 1};
  const double allowed = share_of_size * std::exp2(most_halvings - left.in_halves);  // of the part before it was halved
  if (left.in_halves > 0 && needs_halving(requests_, part, allowed)) return split(0.5 * (from + until), halved, halved);
  const std::function<void(double, std::vector<double>&)> again = [&](double t, std::vector<double>& row) {
    sample(t, row);
  };
  return signals_.take_part({from, until, begin_, middle_, *row_, again});
}

}  // namespace subsoil::mbd
