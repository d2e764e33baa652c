#include "libmbd/integrators/events.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libmbd/elements.hpp"

namespace subsoil::mbd {

namespace {

template <class Force>
std::size_t gaps_of(const Force& force) {
  if constexpr (Force::has.gaps) return force.gap_count();
  return Force::has.gap;
}
template <class Force>
std::size_t sticks_of(const Force& force) {
  if constexpr (Force::has.stick) return remembering(force).stick_count();
  return 0;
}

}  // namespace

bool needs_events(const AnyForce& any) {
  return visit(
      []<class Force>(const Force& force) {
        if constexpr (Force::has.stick || Force::has.touch) return remembering(force).remembers();
        return false;
      },
      any);
}

bool needs_events(const Model& model) {
  return std::any_of(model.forces.begin(), model.forces.end(), [](const auto& f) { return needs_events(f.element); });
}

bool can_stick(const Model& model) {
  return std::any_of(model.forces.begin(), model.forces.end(), [](const auto& f) {
    return visit([](const auto& force) { return sticks_of(force) > 0; }, f.element);
  });
}

Switches::Switches(const System& system) : system_(system) {
  const auto& forces = system.model().forces;
  for (std::size_t i = 0; i < forces.size(); ++i)
    visit(
        [&](const auto& force) {
          const std::size_t gaps = gaps_of(force), sticks = sticks_of(force);
          for (std::size_t k = 0; k < gaps; ++k) of_forces_.push_back({i, k, false});
          for (std::size_t k = 0; k < sticks; ++k) of_forces_.push_back({i, k, true});
          has_gaps_ = has_gaps_ || gaps > 0;
        },
        forces[i].element);
  sides_.assign(count(), 1);
  work_.assign(count(), 0);
}

const std::string& Switches::name(std::size_t i) const {
  if (of_joint(i)) return system_.model().events[event(i)].element.joint;
  return system_.model().forces[force(i)].name;
}

void Switches::gaps(std::span<double> out, const Eigen::VectorXd* acceleration, const Eigen::VectorXd* lambda) const {
  const Scene scene = system_.scene();
  for (std::size_t i = of_forces_.size(); i < count(); ++i)
    out[i] = acceleration && lambda ? system_.event_gap(event(i), *acceleration, *lambda) -
                                          (sides_[i] < 0 ? system_.model().events[event(i)].element.hysteresis() : 0)
                                    : 1;
  for (std::size_t i = 0; i < of_forces_.size();)
    i += visit(
        [&]<class Force>(const Force& force) -> std::size_t {
          const std::size_t gaps = gaps_of(force), sticks = sticks_of(force);
          if constexpr (Force::has.gap) out[i] = force.gap(scene);
          if constexpr (Force::has.gaps) force.gaps(scene, out.subspan(i, gaps));
          if constexpr (Force::has.stick)
            for (std::size_t k = 0; k < sticks; ++k) out[i + gaps + k] = remembering(force).hold(scene, k);
          return gaps + sticks;
        },
        system_.model().forces[force(i)].element);
  const double margin = rounding();
  for (std::size_t i = 0; has_gaps_ && i < of_forces_.size(); ++i)
    if (of_gap(i)) out[i] += sides_[i] > 0 ? margin : -margin;
}

double Switches::rounding() const {
  constexpr double roundings = 8;  // of a gap: of two poses, two outlines and what is made of them
  double farthest = 0, turned = 1;
  for (const BodyState& b : system_.scene().bodies) {
    farthest = std::max({farthest, std::abs(b.r.x), std::abs(b.r.y)});
    turned = std::max(turned, std::abs(b.angle));
  }
  return roundings * std::numeric_limits<double>::epsilon() * (farthest + turned * system_.length_scale());
}

void Switches::gap_speeds(std::span<double> out) const {
  const Scene scene = system_.scene();
  for (std::size_t i = 0; i < count(); ++i) {
    const auto bound = [&]<class Force>(const Force& force) {
      if constexpr (Force::has.gap || Force::has.gaps) return force.gap_speed(scene);
      return 0.0;
    };
    const bool next = of_gap(i) && place(i) > 0;  // one bound for all gaps of a force
    out[i] = !of_gap(i) ? 0 : next ? out[i - 1] : visit(bound, system_.model().forces[force(i)].element);
  }
}

void Switches::take_sides() {
  sides_.assign(count(), 1);
  gaps(work_);
  for (std::size_t i = 0; i < count(); ++i) sides_[i] = work_[i] < 0 && !of_friction(i) ? -1 : 1;
}

bool remembers(const Model& model) {
  const auto leaves_ruts = []<class Force>(const Force&) { return Force::has.rut; };
  return std::any_of(model.forces.begin(), model.forces.end(),
                     [&](const auto& force) { return visit(leaves_ruts, force.element); });
}

double locate_crossing(const std::function<double(double)>& gap, int side, double gap_at_start, double gap_at_end) {
  double low = 0, high = 1, at_low = side * gap_at_start, at_high = side * gap_at_end;
  constexpr double width = 1e-12;
  int kept = 0;  // which end stayed in the last turn, for the Illinois halving
  for (int turn = 0; turn < 200 && high - low > width; ++turn) {
    // Just after an event the gap at the left end is rounding: a secant through it would find the same event again.
    const bool secant = low > 0 || at_low > 1e-3 * std::abs(at_high);
    double share = secant ? (low * -at_high + high * at_low) / (at_low - at_high) : 0.5 * (low + high);
    // A root within rounding of an end: one step of the width asked for closes the bracket from the other side.
    share = std::clamp(share, low + 0.5 * width, high - 0.5 * width);
    const double value = side * gap(share);
    if (value > 0) {
      low = share, at_low = value;
      if (kept > 0) at_high /= 2;
      kept = 1;
    } else {
      high = share, at_high = value;
      if (kept < 0) at_low /= 2;
      kept = -1;
    }
    if (at_high == 0) break;
  }
  return high;
}

}  // namespace subsoil::mbd
