#pragma once

#include "libmbd/system/measure.hpp"

namespace subsoil::mbd {

/// Energy of one body:   kinetic  m |v|^2 / 2 + J omega^2 / 2,   potential  -m g . r, zero at the world's origin    (J)
struct EnergyMeasure {
  static constexpr MeasureMembers has{};
  enum class Part { both, kinetic, potential, sum };
  int body = -1;
  Part part = Part::both;

  template <class V>
  void describe(V& v) {
    v.card("energy", "kinetic and potential energy of a body");
    v.body("energy", body, "the body");
    v.choice("component", part,
             {{"both", Part::both}, {"kinetic", Part::kinetic}, {"potential", Part::potential}, {"sum", Part::sum}},
             "both: the columns NAME.kinetic and NAME.potential; else one column NAME");
  }
  std::vector<MeasureColumn> columns() const {
    if (part == Part::both) return {{"kinetic", "J"}, {"potential", "J"}};
    return {{"", "J"}};
  }
  void evaluate(const Observation& o, std::span<double> out) const {
    const Body& data = o.system.model().bodies[static_cast<std::size_t>(body - 1)];
    const BodyState& b = o.system.body(body);
    const auto& g = o.system.model().gravity;
    const double kinetic = 0.5 * (data.mass * dot(b.v, b.v) + data.inertia * b.omega * b.omega),
                 potential = -data.mass * dot({g[0], g[1]}, b.r);
    out[0] = part == Part::potential ? potential : part == Part::sum ? kinetic + potential : kinetic;
    if (part == Part::both) out[1] = potential;
  }
};

}  // namespace subsoil::mbd
