#pragma once

#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

/// Velocity of a marker P as an observer on the body of marker Q sees it, in the axes of a marker I:          (m/s)
///   A_I^T (v_P - v_Q - spin_Q k x d),  d = r_P - r_Q
/// Q and I are the world unless given. With I = Q it is the time derivative of the position measure with I = Q.
struct VelocityMeasure {
  static constexpr MeasureMembers has{};
  Marker of{}, from{.name = "ground"}, in{.name = "ground"};
  VectorPart part = VectorPart::both;

  template <class V>
  void describe(V& v) {
    v.card("velocity", "how fast a marker moves, seen from a body");
    v.marker("velocity", of, "the marker or body that is looked at");
    v.optional_marker("from", from, "the observer, who moves and turns with its body");
    v.optional_marker("in", in, "whose axes the components are given in");
    describe_part(v, part);
  }
  std::vector<MeasureColumn> columns() const { return columns_of(part, "m/s"); }

  /// The velocity that Q's observer sees, world axes.
  static Vec2 seen_from(const MarkerState& q, const MarkerState& p) { return p.v - q.v - q.omega * turned(p.r - q.r); }
  void evaluate(const Observation& o, std::span<double> out) const {
    put(part, o.at(in).seen(seen_from(o.at(from), o.at(of))), out);
  }
};

}  // namespace subsoil::mbd
