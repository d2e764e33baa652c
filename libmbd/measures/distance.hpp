#pragma once

#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

/// Distance of two markers:   L = |d|,  d = r_2 - r_1                                                            (m)
struct DistanceMeasure {
  static constexpr MeasureMembers has{};
  std::array<Marker, 2> between{};

  template <class V>
  void describe(V& v) {
    v.card("distance", "how far two markers are apart");
    v.markers("distance", between, "the two markers or bodies");
  }
  std::vector<MeasureColumn> columns() const { return {{"", "m"}}; }
  void evaluate(const Observation& o, std::span<double> out) const {
    out[0] = length(o.at(between[1]).r - o.at(between[0]).r);
  }
};

/// Rate at which two markers part:   L' = d . d' / L,  d = r_2 - r_1                                           (m/s)
/// On each other, L = 0, they part at |d'|.
struct DistanceRateMeasure {
  static constexpr MeasureMembers has{};
  std::array<Marker, 2> between{};

  template <class V>
  void describe(V& v) {
    v.card("distance rate", "how fast two markers part; below 0 they close");
    v.markers("distance rate", between, "the two markers or bodies");
  }
  std::vector<MeasureColumn> columns() const { return {{"", "m/s"}}; }
  void evaluate(const Observation& o, std::span<double> out) const {
    const MarkerState a = o.at(between[0]), b = o.at(between[1]);
    const Vec2 d = b.r - a.r, rate = b.v - a.v;
    const double apart = length(d);
    out[0] = apart > 0 ? dot(d, rate) / apart : length(rate);
  }
};

}  // namespace subsoil::mbd
