#include "libsim/run/motion_search.hpp"

#include <algorithm>

namespace subsoil::sim {
namespace {

mbd::Evaluation evaluation_of(mbd::Machine& machine) {
  machine.keep_dense_output();
  return machine.evaluation();
}

}  // namespace

MotionSearch::MotionSearch(mbd::Machine& machine, Columns& columns, Crossings* crossings, MotionSummary* summary)
    : machine_(machine),
      columns_(columns),
      crossings_(crossings != nullptr && crossings->any() ? crossings : nullptr),
      summary_(summary),
      evaluation_(evaluation_of(machine)),
      search_(*this, evaluation_),
      parts_(machine.integrator().ends_anywhere() ? 2 : 1) {}

bool MotionSearch::begin(double t, std::vector<double>& row) {
  sample(t, instant_at(t), row);
  return take_jump(t, row);
}

bool MotionSearch::search(double from, double until, std::vector<double>& row) {
  if (until > from && search_.search(machine_.dense_output(), from, until, parts_, row)) return true;
  return begin(until, row);
}

mbd::Instant MotionSearch::instant_at(double t, double close) {
  if (machine_.time() > t + close) return evaluation_.evaluate(machine_.dense_output(), t);
  return machine_.now();
}

mbd::Instant MotionSearch::instant_behind(double t) {
  const mbd::DenseOutput& step = machine_.dense_output();
  std::size_t segment = step.segment_at(t);
  while (segment + 1 < step.count() && step.span(segment + 1).begin <= t) ++segment;
  return evaluation_.evaluate(step, t, segment);
}

void MotionSearch::sample(double t, const mbd::Instant& at, std::vector<double>& row) {
  columns_.take_instant(t, at, row);
}

void MotionSearch::rounding(const mbd::Instant& at, std::span<const double> row, std::vector<double>& out) {
  columns_.rounding_of(at, row, out);
}

void MotionSearch::request(double until, std::vector<mbd::Request>& out) {
  if (crossings_ != nullptr) crossings_->request(out);
  columns_.request(out);
  if (summary_ != nullptr) summary_->request(until, out);
}

bool MotionSearch::take_jump(double t, std::vector<double>& row) {
  if (columns_.has_history()) columns_.follow(t, row);
  if (summary_ != nullptr) summary_->begin(t, row);
  return crossings_ != nullptr && crossings_->look(t, row, Crossings::on_a_line);
}

bool MotionSearch::take_part(const mbd::StepPart& part) {
  // What is followed over time is known at the end once it is followed to there, which cannot be undone: a passage of
  // it inside the part, and all that is followed where the run ends, are followed again from the part's begin.
  const bool rewinds = crossings_ != nullptr && crossings_->of_history();
  const Columns::Followed begun = rewinds ? columns_.followed() : Columns::Followed{};
  const auto follow = [&](double end, std::vector<double>& half, std::vector<double>& row) {
    if (columns_.has_history()) columns_.follow(end, row, half);
  };
  if (rewinds) follow(part.until, part.middle, part.end);
  between_ = part.begin;
  const bool stops = crossings_ != nullptr && crossings_->look(part.until, part.end, [&](const Crossings::Passage& p) {
    const auto gap = [&](double share) {
      const double t = part.from + share * (part.until - part.from);
      part.sample(t, between_);
      if (columns_.of_history(p.column)) {
        half_ = between_;
        part.sample(0.5 * (part.from + t), half_);
        columns_.set_followed(begun);
        follow(t, half_, between_);
      }
      return between_[p.column] - p.level;
    };
    return mbd::locate_crossing(gap, p.side, p.at_start, p.at_end);
  });
  const double end = stops ? std::min(part.until, crossings_->stopped_at()) : part.until;
  if (end < part.until) part.sample(0.5 * (part.from + end), part.middle), part.sample(end, part.end);
  if (rewinds) columns_.set_followed(begun);
  follow(end, part.middle, part.end);
  if (summary_ != nullptr) summary_->add(end, part.middle, part.end);
  return stops;
}

}  // namespace subsoil::sim
