#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/integrators/between.hpp"
#include "libmbd/integrators/hidden_contacts.hpp"
#include "libmbd/integrators/integrator.hpp"

/// Steps of methods that do not look for events themselves.
namespace subsoil::mbd {

namespace {
constexpr int most_events_in_a_step = 1000;
}

/// A part of the step begins at the present state, to which try_part() returns.
void Integrator::begin_part() {
  before_ = now_;
  flows_before_ = flows_;
  segments_before_ = dense_.segments.size();
}

/// A step of length h from the state before it, by the method's own start: it needs no past. @param to_event it ends
/// with the first of its parts behind which a switch has changed
void Integrator::try_part(double h, bool to_event) {
  dense_.segments.erase(dense_.segments.begin() + static_cast<std::ptrdiff_t>(segments_before_), dense_.segments.end());
  now_ = before_;
  flows_ = flows_before_;
  partition_.evaluate(now_);
  on_start();
  advance_to_event(h, to_event);
  if (!to_event || before_.t + h - now_.t < 1e-6 * h) now_.t = before_.t + h;
}

void Integrator::advance_to_event(double h, bool to_event) {
  to_event_ = to_event;
  on_advance(h);
  to_event_ = false;
}

// When the value of a joint's event has come and gone in the step from before_ to now_, as it is read between them,
// ends the step where the value is beyond; returns whether it does.
bool Integrator::comes_and_goes() {
  if (!system_.has_joint_events()) return false;
  MotionState at = now_;
  std::vector<double> gaps(switches_.count());
  const auto look_at = [&](double t) {
    interpolate(before_, now_, t, at);
    look(at, gaps);
  };
  const double begin = before_.t, h = now_.t - begin;
  std::vector<TimedValue> samples;
  for (const double t : event_times(begin, h, largest_turn(before_.q, now_.q))) samples.push_back({t, 0});
  std::vector<std::vector<double>> values;
  for (const TimedValue& sample : samples) look_at(sample.t), values.push_back(gaps);
  std::optional<double> first;
  for (std::size_t i = 0; i < switches_.count(); ++i) {
    if (!switches_.of_joint(i) || switches_.side(i) < 0) continue;
    for (std::size_t k = 0; k < samples.size(); ++k) samples[k].value = values[k][i];
    const auto found = find_hidden_dip(samples, [&](double t) {
      look_at(t);
      return gaps[i];
    });
    if (found && (!first || found->below < *first)) first = found->below;
  }
  look(now_, gaps_);
  if (!first) return false;
  const double whole = now_.t - begin;
  try_part(*first - begin);
  if (crossed()) return true;
  try_part(whole);
  return crossed();
}

void Integrator::advance_over_events(double h) {
  begin_part();
  advance_to_event(h, true);
  if (!crossed() && !comes_and_goes()) return;
  const double end = before_.t + h;
  std::vector<double> at_start(gaps_.size()), at_end(gaps_.size());
  for (int found = 0; crossed() || comes_and_goes(); ++found) {
    if (found == most_events_in_a_step)
      throw std::runtime_error("more than " + std::to_string(found) + " events between t = " + std::to_string(end - h) +
                               " s and " + std::to_string(end) + " s: force '" + events_.back().name +
                               "' rattles; shorten the step or add damping");
    at_end = gaps_;
    look(before_, at_start);
    const double rest = now_.t - before_.t;
    std::size_t first = 0;
    double share = 2;
    for (std::size_t i = 0; i < at_end.size(); ++i) {
      if (at_end[i] * switches_.side(i) >= 0) continue;
      const auto gap = [&](double part) {
        try_part(part * rest);
        crossed();
        return gaps_[i];
      };
      const double at = locate_crossing(gap, switches_.side(i), at_start[i], at_end[i]);
      if (at < share) share = at, first = i;
    }
    try_part(share * rest);
    keep_end();
    take_event(first);
    partition_.evaluate(now_);  // friction that has changed over
    if (switches_.of_joint(first)) release_friction();
    keep_begin();
    begin_part();
    if (end - now_.t <= 1e-12 * h) break;
    try_part(end - now_.t, true);
  }
  now_.t = end;
  on_start();
}

}  // namespace subsoil::mbd
