#include "libmbd/integrators/profiles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libmbd/base/quartic.hpp"
#include "libmbd/elements.hpp"

namespace subsoil::mbd {

namespace {

std::size_t profiles_of(const AnyForce& any) {
  return visit(
      []<class Force>(const Force& force) -> std::size_t {
        if constexpr (Force::has.profiles) return force.profile_count();
        return 0;
      },
      any);
}

}  // namespace

Profiles::Profiles(System& system) : system_(system) {
  const auto& forces = system.model().forces;
  for (std::size_t f = 0; f < forces.size(); ++f)
    for (std::size_t k = 0; k < profiles_of(forces[f].element); ++k) {
      Profile p{.force = f, .index = k, .looked_at = {}, .values = {}};
      const std::vector<double> nodes = visit(
          [k]<class Force>(const Force& force) {
            if constexpr (Force::has.profiles) return force.profile_nodes(k);
            return std::vector<double>{};
          },
          forces[f].element);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        p.looked_at.push_back(nodes[i]);
        if (i + 1 < nodes.size()) p.looked_at.push_back(0.5 * (nodes[i] + nodes[i + 1]));
      }
      for (const double x : p.looked_at) p.values.push_back(value(p, x));
      for (const double y : p.values) p.largest = std::max(p.largest, std::abs(y));
      list_.push_back(std::move(p));
    }
  begin_.resize(list_.size()), middle_ = end_ = begin_;
}

double Profiles::value(const Profile& p, double x) const {
  return visit(
      [&]<class Force>(const Force& force) {
        if constexpr (Force::has.profiles) return force.profile_value(p.index, x);
        return 0.0;
      },
      system_.model().forces[p.force].element);
}

// At the state that m comes to `after` with its accelerations; constraints are met to the third order of that time.
void Profiles::arguments(const MotionState& m, double after, std::vector<double>& out) {
  q_ = m.q + after * (m.velocity + 0.5 * after * m.acceleration);
  velocity_ = m.velocity + after * m.acceleration;
  system_.set_state(m.t + after, q_, velocity_);
  const Scene scene = system_.scene();
  for (std::size_t i = 0; i < list_.size();) {
    const std::size_t f = list_[i].force;
    i += visit(
        [&]<class Force>(const Force& force) -> std::size_t {
          if constexpr (Force::has.profiles) {
            force.profile_arguments(scene, std::span(out).subspan(i, force.profile_count()));
            return force.profile_count();
          }
          return 1;
        },
        system_.model().forces[f].element);
  }
}

double Profiles::stop(const MotionState& m, double planned) {
  constexpr double least = 1e-9;  // s; and a planned step cannot be more than halved so often
  double length = planned;
  arguments(m, 0, begin_);
  while (length > least) {
    arguments(m, 0.5 * length, middle_), arguments(m, length, end_);
    bool resolved = true;
    for (std::size_t i = 0; i < list_.size() && resolved; ++i) {
      const auto [low, high] = std::minmax({begin_[i], middle_[i], end_[i]});
      resolved = resolves(list_[i], low, high);
    }
    if (resolved) break;
    length *= 0.5;
  }
  system_.set_state(m.t, m.q, m.velocity);
  return length < planned ? m.t + length : std::numeric_limits<double>::infinity();
}

bool Profiles::resolves(const Profile& p, double from, double to) const {
  const auto first = std::upper_bound(p.looked_at.begin(), p.looked_at.end(), from);
  const auto last = std::lower_bound(first, p.looked_at.end(), to);
  if (first == last) return true;
  std::array<double, 5> nodes{};
  for (std::size_t k = 0; k < 5; ++k) nodes[k] = value(p, from + 0.25 * static_cast<double>(k) * (to - from));
  const Quartic quartic(nodes);
  constexpr double share_of_bend = 2e-3, share_of_largest = 1e-8;
  double bend = 0, off = 0;
  for (auto x = first; x != last; ++x) {
    const double share = (*x - from) / (to - from), y = p.values[static_cast<std::size_t>(x - p.looked_at.begin())];
    bend = std::max(bend, std::abs(y - (nodes[0] + share * (nodes[4] - nodes[0]))));
    off = std::max(off, std::abs(y - quartic.at(share)));
  }
  return off <= share_of_bend * bend + share_of_largest * p.largest;
}

}  // namespace subsoil::mbd
