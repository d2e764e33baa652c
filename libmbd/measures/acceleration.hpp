#pragma once

#include "libmbd/measures/velocity.hpp"

namespace subsoil::mbd {

/// Acceleration of a marker P as an observer on the body of marker Q sees it, in the axes of a marker I:    (m/s^2)
///   A_I^T (a_P - a_Q - alpha_Q k x d + spin_Q^2 d - 2 spin_Q k x v),  d = r_P - r_Q,  v the velocity that he sees
/// Q and I are the world unless given. With I = Q it is the time derivative of the velocity measure with I = Q.
struct AccelerationMeasure {
  static constexpr MeasureMembers has{.of_solution = true};
  Marker of{}, from{.name = "ground"}, in{.name = "ground"};
  VectorPart part = VectorPart::both;

  template <class V>
  void describe(V& v) {
    v.card("acceleration", "how a marker accelerates, seen from a body");
    v.marker("acceleration", of, "the marker or body that is looked at");
    v.optional_marker("from", from, "the observer, who moves and turns with its body");
    v.optional_marker("in", in, "whose axes the components are given in");
    describe_part(v, part);
  }
  std::vector<MeasureColumn> columns() const { return columns_of(part, "m/s^2"); }
  void evaluate(const Observation& o, std::span<double> out) const {
    const MarkerState p = o.at(of), q = o.at(from);
    const Vec2 d = p.r - q.r, v = VelocityMeasure::seen_from(q, p);
    const Vec2 a = p.a - q.a - q.alpha * turned(d) + q.omega * q.omega * d - 2 * q.omega * turned(v);
    put(part, o.at(in).seen(a), out);
  }
};

}  // namespace subsoil::mbd
