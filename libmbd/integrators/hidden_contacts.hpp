#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "libmbd/integrators/events.hpp"

namespace subsoil::mbd {

/// Contacts that close and open again within one step of a method with dense output: a ball that flies past a peg in a
/// step of free flight, which no error test and no root finder sees, since nothing acts at either end.
///
/// With V a bound on how fast a gap g changes, it cannot close between two times a < b while
///   g(a) + g(b) > V (b - a)
/// Where this does not hold the middle is looked at, and both halves likewise, down to pieces in which the bodies move
/// against each other by a share of the machine's length: what is passed over touches for less.
class HiddenContacts {
 public:
  static constexpr double least_way = 1e-4;  ///< of a piece, over the machine's length
  static constexpr int most_halvings = 10;

  /// Gaps and their speeds at a time.
  struct Sample {
    double t = 0;
    std::vector<double> gaps{}, speeds{};
  };
  using Look = std::function<void(Sample&)>;  ///< fills gaps and speeds at the sample's time

  struct Found {
    std::size_t which;    ///< of the switching functions
    double open, closed;  ///< times, between which it closed first
  };
  /// The first that is open at both ends and closed between them.
  std::optional<Found> find(const Switches& switches, double length_scale, const Sample& begin, const Sample& end,
                            const Look& look);

 private:
  bool may_close(const Sample& a, const Sample& b) const;
  std::optional<Found> search(const Sample& a, const Sample& b, int halvings);

  const Switches* switches_ = nullptr;
  const Look* look_ = nullptr;
  double least_ = 0;
};

}  // namespace subsoil::mbd
