#pragma once

#include <array>

namespace subsoil::mbd {

/// Quartic through five equidistant values, at a share of their range.
class Quartic {
 public:
  explicit Quartic(const std::array<double, 5>& values) : d_(values) {
    for (std::size_t order = 1; order < 5; ++order)
      for (std::size_t i = 4; i >= order; --i) d_[i] = (d_[i] - d_[i - 1]) / static_cast<double>(order);
  }
  double at(double share) const {
    const double x = 4 * share;
    return d_[0] + x * (d_[1] + (x - 1) * (d_[2] + (x - 2) * (d_[3] + (x - 3) * d_[4])));
  }

 private:
  std::array<double, 5> d_;  // divided differences
};

}  // namespace subsoil::mbd
