#pragma once

#include "libmbd/measures/wrench_of.hpp"

namespace subsoil::mbd {

/// What comes from outside on a body (the soil's force as the machine feels it,
/// constant over a machine step):
///   A_I^T F  (N),   M about a marker's point  (N m)
/// Left out: world axes, moment about the body's centre of mass. A controller
/// may measure it without a sensor lag.
struct SoilForceMeasure {
  static constexpr MeasureMembers has{};
  int body = -1;
  Marker in{.name = "ground"};
  Marker about{};
  WrenchPart part = WrenchPart::all;

  template <class V>
  void describe(V& v) {
    v.card("soil force",
           "force and moment of the soil on a body, as the "
           "machine feels them over a step");
    v.body("soil force", body, "the body");
    v.optional_marker("in", in, "whose axes the components are given in");
    v.optional_marker("about", about, "point of the moment; left out: the centre of mass");
    describe_part(v, part);
  }
  std::vector<MeasureColumn> columns() const { return columns_of(part); }
  void evaluate(const Observation& o, std::span<double> out) const {
    const auto& w = o.system.external_wrench(body);
    const Wrench own{{w[0], w[1]}, w[2], o.system.body(body).r};
    const Wrench moved = about.name.empty() ? own : own.moved_to(o.at(about).r);
    put(part, o.at(in).seen(moved.force), moved.moment, out);
  }
};

}  // namespace subsoil::mbd
