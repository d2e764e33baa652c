#pragma once

#include "libmbd/measures/wrench_of.hpp"

namespace subsoil::mbd {

/// What a spring, contact, load ... puts on one of its bodies:   A_I^T F  (N),   M about a marker's point  (N m)
/// Left out: on its second (or only) body, world axes, moment about that body's centre of gravity.
struct ForceMeasure : WrenchOf {
  static constexpr MeasureMembers has{.attach = true, .of_solution = true};
  template <class V>
  void describe(V& v) {
    v.card("force", "force and moment that a force of the machine puts on one of its bodies");
    v.force("force", element, "the force");
    describe_rest(v, "one of its bodies, or ground; left out: its second, or only one",
                  "point of the moment; left out: the centre of mass of `on`");
  }
  void attach(const System& system) {
    index = find_named(system.model().forces, "force", element);
    const std::vector<int> bodies = bodies_of_force(system, index);
    find("force", system, bodies, bodies.back());
  }
  void evaluate(const Observation& o, std::span<double> out) const {
    report(o, force_wrench(o.system, index, o.lambda, on), out);
  }
};

}  // namespace subsoil::mbd
