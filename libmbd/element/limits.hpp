#pragma once

#include "libmbd/element/force.hpp"
#include "libmbd/element/hunt_crossley.hpp"

namespace subsoil::mbd {

/// Two unilateral stops on a relative measure x (m or rad): x is free between `least` and `largest`, and a
/// Hunt-Crossley force pushes it back where it is beyond either. A limit that is not given (NaN) is not there.
struct Limits {
  double least = std::numeric_limits<double>::quiet_NaN();
  double largest = std::numeric_limits<double>::quiet_NaN();
  HuntCrossleyForce law{};

  /// Units of the measure and its force: "m" and "N", or "rad" and "N m".
  template <class V>
  void describe(V& v, const std::string& measure, const std::string& force) {
    v.optional_quantity("minimum", least, measure.c_str(), "(-inf, inf)",
                        "stop at the lower end; left out: none there");
    v.optional_quantity("maximum", largest, measure.c_str(), "(-inf, inf)",
                        "stop at the upper end; left out: none there");
    law.describe(v, measure, force);
  }
  void check() const {
    law.check();
    if (std::isnan(least) && std::isnan(largest))
      throw std::invalid_argument("needs a stop: give minimum, maximum or both");
    if (least >= largest)
      throw std::invalid_argument("minimum must be below maximum; for a fixed value use a joint or a driver");
  }

  /// Room to the nearer stop, negative in contact.
  double gap(double x) const { return std::fmin(x - least, largest - x); }  // fmin passes over a limit that is NaN

  /// Force on the measure, positive where it makes x grow, with the b that the impact has begun with.
  struct Push {
    double force = 0;
    ForcePower power{};
  };
  Push at(double x, double rate, double damping) const {
    const HuntCrossleyForce::Push low = law.at(least - x, -rate, damping), high = law.at(x - largest, rate, damping);
    return {low.force - high.force, {low.stored + high.stored, low.lost + high.lost, 0}};
  }
};

}  // namespace subsoil::mbd
