#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// Whether an event of a joint, or a controller, depends on accelerations, reactions or forces.
bool events_read_reactions(const System& system);
bool controllers_read_reactions(const System& system);

/// Multipliers as events and controllers read them, at the state that the system was set to last. Of `used` independent
/// equations they are given, of redundant ones they are 0: these share then with the others so that the norm is
/// minimum, as in Partition::reactions. Nothing is done where nobody reads them, or where no equation is redundant.
class SharedReactions {
 public:
  SharedReactions(const System& system, std::size_t used, const Eigen::VectorXd& lambda, bool read);
  const Eigen::VectorXd& lambda() const { return shared_.size() > 0 ? shared_ : given_; }

 private:
  const Eigen::VectorXd& given_;
  Eigen::VectorXd shared_;
};

/// The multipliers of minimum norm that load the bodies as `lambda` does; the constraints are those at its state.
Eigen::VectorXd least_norm_reactions(const System& system, const Constraints& constraints,
                                     const Eigen::VectorXd& lambda);

}  // namespace subsoil::mbd
