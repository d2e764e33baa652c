#pragma once

#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

/// Position of a marker P from a marker Q, in the axes of a marker I:   A_I^T (r_P - r_Q)                       (m)
/// Q and I are the world unless given. With I = Q it is where an observer on Q's body sees P.
struct PositionMeasure {
  static constexpr MeasureMembers has{};
  Marker of{}, from{.name = "ground"}, in{.name = "ground"};
  VectorPart part = VectorPart::both;

  template <class V>
  void describe(V& v) {
    v.card("position", "where a marker is");
    v.marker("position", of, "the marker or body that is looked at");
    v.optional_marker("from", from, "from where it is measured");
    v.optional_marker("in", in, "whose axes the components are given in");
    describe_part(v, part);
  }
  std::vector<MeasureColumn> columns() const { return columns_of(part, "m"); }
  void evaluate(const Observation& o, std::span<double> out) const {
    put(part, o.at(in).seen(o.at(of).r - o.at(from).r), out);
  }
};

}  // namespace subsoil::mbd
