#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "libmbd/integrators/events.hpp"

namespace subsoil::mbd {

/// Gaps and bounds on how fast they change, at a time.
struct GapSample {
  double t = 0;
  std::vector<double> gaps{}, speeds{};
};

/// By which bodies move against each other in the shortest pieces of a step that are bisected (m): of many pieces,
/// and of few, which is above the rounding of places.
struct WaysOfPieces {
  double minimum, finest;
};

struct HiddenContact {
  std::size_t which;    ///< of the switching functions
  double open, closed;  ///< times, between which it closed first
};

/// The first contact that is open at both ends of a step of a method with dense output and closed between them: a ball
/// that flies past a peg in a step of free flight, which no error test and no root finder sees, since nothing acts at
/// either end.
///
/// With V a bound on how fast a gap g changes, it cannot close between two times a < b while
///   g(a) + g(b) > V (b - a)
/// Where this does not hold the middle is evaluated, and both halves likewise, all pieces of a level before the next
/// level. About an isolated minimum of a gap only few pieces remain: these are halved down to the finest way, however
/// long the step is. Where many remain (surfaces that pass each other closely for long) the search ends at pieces of
/// the minimum way, or after 1024 evaluations: what is passed over touches for less. One that closes earlier than the
/// one found may be left, where both close in the same level.
/// @param look fills gaps and speeds at the sample's time
std::optional<HiddenContact> find_hidden_contact(const Switches& switches, const WaysOfPieces& ways,
                                                 const GapSample& begin, const GapSample& end,
                                                 const std::function<void(GapSample&)>& look);

struct Minimum {
  double at, value;
};

/// The minimum of a function that has one between `low` and `high`, to `width` by golden section, or the first value
/// below `enough` that is met on the way to it. No bracket is narrowed beyond the rounding of its ends.
Minimum find_minimum(const std::function<double(double)>& g, double low, double high, double width, double enough);

struct TimedValue {
  double t, value;
};
/// Times between which a function passes zero downwards.
struct HiddenPassage {
  double above, below;
};

/// Instants of a step from `begin` at which the values of joints' events are evaluated: its ends, one close beside each
/// of them, and at least three between, no more than a quarter of a radian apart where the fastest body turns by
/// `turn`.
std::vector<double> event_times(double begin, double h, double turn);
/// Maximum rotation of a body between two states, rad.
double largest_turn(const Eigen::VectorXd& q_before, const Eigen::VectorXd& q);

/// Whether one of the samples of a function that is positive at the first lies below zero, or below its neighbours and
/// on a way to zero as steep as between two of the three.
bool may_dip(std::span<const TimedValue> samples);

/// The first passage of zero of a function g that is positive at the first sample and at the last, of a step in which
/// it turns as often as the samples show. Where one of them lies below its neighbours, g has a minimum between these;
/// it is looked for if a way as steep as between two of the three could lead to zero, and the search ends at the
/// first value below. Samples close beside both ends show the slopes there.
std::optional<HiddenPassage> find_hidden_dip(std::span<const TimedValue> samples,
                                             const std::function<double(double)>& g);

}  // namespace subsoil::mbd
