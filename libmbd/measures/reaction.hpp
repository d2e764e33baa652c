#pragma once

#include "libmbd/measures/wrench_of.hpp"

namespace subsoil::mbd {

/// What a joint puts on one of its bodies:   A_I^T F  (N),   M about a marker's point  (N m)
/// F, M: -Phi_q^T lambda of the joint's rows (see ConstraintRow). Left out: on the first body, world axes, moment about
/// the point at which the joint reports its reaction. A redundant joint's is the one of minimum norm.
struct ReactionMeasure : WrenchOf {
  static constexpr MeasureMembers has{.attach = true, .of_solution = true};
  template <class V>
  void describe(V& v) {
    v.card("reaction", "force and moment that a joint puts on one of its bodies");
    v.joint("reaction", element, "the joint");
    describe_rest(v, "one of the joint's bodies, or ground; left out: its first",
                  "point of the moment; left out: the joint's own");
  }
  void attach(const System& system) {
    index = find_named(system.model().joints, "joint", element);
    const std::vector<int> bodies = bodies_of_joint(system, index);
    find("joint", system, bodies, bodies.front());
  }
  void evaluate(const Observation& o, std::span<double> out) const {
    report(o, joint_wrench(o.system, index, o.lambda, on), out);
  }
};

}  // namespace subsoil::mbd
