#include "libmbd/assembly/shared_reactions.hpp"

#include <algorithm>
#include <cmath>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/base/dense.hpp"
#include "libmbd/controllers.hpp"

namespace subsoil::mbd {

bool events_read_reactions(const System& system) {
  const auto& events = system.model().events;
  return std::any_of(events.begin(), events.end(), [](const auto& e) {
    return !std::isnan(e.element.reaction_above) || (e.element.input && e.element.input->of_solution());
  });
}

bool controllers_read_reactions(const System& system) {
  const auto& controllers = system.model().controllers;
  return std::any_of(controllers.begin(), controllers.end(), [](const auto& c) {
    return visit(
        [](const auto& controller) {
          const ControllerInputs inputs = controller.measured();
          return std::any_of(inputs.begin(), inputs.end(), [](const auto& input) { return input->of_solution(); });
        },
        c.element);
  });
}

SharedReactions::SharedReactions(const System& system, std::size_t used, const Eigen::VectorXd& lambda, bool read)
    : given_(lambda) {
  // The rows of open joints are zero, and none of them is redundant.
  if (!read || static_cast<int>(used) + system.open_rows() >= system.equations()) return;
  Constraints c;
  system.constraints(c);
  shared_ = least_norm_reactions(system, c, lambda);
}

Eigen::VectorXd least_norm_reactions(const System& system, const Constraints& constraints,
                                     const Eigen::VectorXd& lambda) {
  const Eigen::VectorXd force = constraints.jacobian.transpose() * lambda;
  return row_scale(system).cwiseProduct(least_norm_solution(scaled_jacobian(system, constraints).transpose(),
                                                            force.cwiseQuotient(coordinate_scale(system)), rank_share));
}

}  // namespace subsoil::mbd
