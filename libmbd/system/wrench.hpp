#pragma once

#include <string>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// Force and moment about a world point, world axes (N, N m; m).
struct Wrench {
  Vec2 force;
  double moment = 0;
  Vec2 about;

  /// The same wrench with its moment about another point.
  Wrench moved_to(Vec2 point) const { return {force, moment - cross(point - about, force), point}; }
};

/// What joint number `joint` puts on one of its bodies at the system's state, from the multipliers of all constraints:
/// -Phi_q^T lambda of its rows, about the point at which the joint reports its reaction. A body that it does not join
/// gets nothing.
Wrench joint_wrench(const System& system, std::size_t joint, const Eigen::VectorXd& lambda, int body);

/// What force number `force` puts on a body at the system's state, about the body's centre of gravity.
Wrench force_wrench(const System& system, std::size_t force, const Eigen::VectorXd& lambda, int body);

/// The bodies that joint or force number i names, in its own order.
std::vector<int> bodies_of_joint(const System& system, std::size_t i);
std::vector<int> bodies_of_force(const System& system, std::size_t i);

/// Place of a joint, driver or force in the model's list; throws std::invalid_argument with the names there are.
template <class List>
std::size_t find_named(const List& list, const char* kind, const std::string& name) {
  std::string known;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].name == name) return i;
    known += (known.empty() ? "" : ", ") + list[i].name;
  }
  throw std::invalid_argument("no " + std::string(kind) + " '" + name + "'; there are " +
                              (known.empty() ? "none" : known));
}

}  // namespace subsoil::mbd
