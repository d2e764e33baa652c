#include "libmbd/assembly/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "libmbd/base/dense.hpp"
#include "libmbd/system/extent.hpp"
#include "libmbd/system/wrench.hpp"

namespace subsoil::mbd {

namespace {

constexpr int most_iterations = 200;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string list(const std::vector<PartName>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i].text();
  return text;
}

/// Owners of the rows that stand out in a vector over rows, each once, in row order.
std::vector<PartName> owners(const System& system, const Eigen::VectorXd& weight) {
  std::vector<PartName> names;
  const double most = weight.cwiseAbs().maxCoeff();
  for (int row = 0; row < system.equations(); ++row)
    if (std::abs(weight[row]) > 1e-6 * most && std::find(names.begin(), names.end(), system.part(row)) == names.end())
      names.push_back(system.part(row));
  return names;
}

/// Largest first.
std::vector<int> rows_by_residual(const Eigen::VectorXd& phi) {
  std::vector<int> rows(static_cast<std::size_t>(phi.size()));
  std::iota(rows.begin(), rows.end(), 0);
  std::stable_sort(rows.begin(), rows.end(), [&](int a, int b) { return std::abs(phi[a]) > std::abs(phi[b]); });
  return rows;
}

/// "joint 'A' by 0.1 m, joint 'B' by 0.05 rad", largest first.
std::string residual_list(const System& system, const Eigen::VectorXd& phi, bool rates) {
  const std::vector<int> rows = rows_by_residual(phi);
  std::string text;
  const double most = std::abs(phi[rows.front()]);
  for (std::size_t i = 0; i < std::min<std::size_t>(rows.size(), 6) && std::abs(phi[rows[i]]) > 1e-3 * most; ++i) {
    const char* unit = system.angular_row(rows[i]) ? (rates ? " rad/s" : " rad") : (rates ? " m/s" : " m");
    text += (i ? ", " : "") + system.owner(rows[i]) + " by " + number(phi[rows[i]]) + unit;
  }
  return text;
}

/// Largest of |(dx, dy)| and length |dphi| of the bodies for a change of q (m) or for velocities (m/s): the same in
/// every frame, as no single coordinate is. `body`: index of the one that it belongs to; unchanged where nothing moves.
double largest_displacement(const System& system, const Eigen::VectorXd& change, int* body = nullptr) {
  double most = 0;
  for (int i = 0; i < system.coordinates(); i += 3) {
    const double angle = system.length_scale() * std::abs(change[i + 2]);
    const double moved = std::max(std::hypot(change[i], change[i + 1]), angle);
    if (moved <= most) continue;  // NaN counts as far
    most = moved;
    if (body) *body = i / 3 + 1;
  }
  return most;
}

struct Dependencies {
  int rank = 0;
  std::vector<std::string> texts;            ///< one per dependency
  std::vector<std::vector<PartName>> parts;  ///< of each of them
  std::vector<PartName> members;             ///< of all
};

/// Rank of Phi_q by singular values; the left null space says which constraints depend on each other.
Dependencies find_dependencies(const System& system, const Eigen::MatrixXd& whole) {
  Dependencies found;
  // Rows of joints that are open are zero, which is no dependency.
  std::vector<int> kept;
  for (int row = 0; row < system.equations(); ++row)
    if (system.open_rows() == 0 || !whole.row(row).isZero(0)) kept.push_back(row);
  if (kept.empty()) return found;
  const Eigen::MatrixXd jacobian = whole(kept, Eigen::all);
  // Most machines have none, and a QR finds that out in a hundredth of the time that singular values take.
  found.rank = static_cast<int>(rank_of(jacobian.transpose(), rank_share));
  if (found.rank == jacobian.rows()) return found;
  found.rank = 0;
  const SingularValues svd = singular_values(jacobian);
  const Eigen::VectorXd& sigma = svd.values;
  while (found.rank < sigma.size() && sigma[found.rank] > rank_share * sigma[0]) ++found.rank;
  const auto surplus = jacobian.rows() - found.rank;
  if (surplus == 0) return found;
  // Several independent dependencies mix freely in the null space; row reduction separates them where they are
  // separate, so that each sentence names one closed group.
  Eigen::MatrixXd null = svd.left.rightCols(surplus).transpose();
  for (Eigen::Index k = 0; k < surplus; ++k) {
    Eigen::Index row = 0, column = 0;
    null.bottomRows(surplus - k).cwiseAbs().maxCoeff(&row, &column);
    null.row(k).swap(null.row(k + row));
    null.row(k) /= null(k, column);
    for (Eigen::Index i = 0; i < surplus; ++i)
      if (i != k) null.row(i) -= null(i, column) * null.row(k);
  }
  Eigen::VectorXd all = Eigen::VectorXd::Zero(whole.rows());
  for (Eigen::Index k = 0; k < surplus; ++k) {
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(whole.rows());
    weight(kept) = null.row(k).transpose();
    found.parts.push_back(owners(system, weight));
    found.texts.push_back("the constraints of " + list(found.parts.back()) + " depend on each other");
    all = all.cwiseMax(weight.cwiseAbs());
  }
  found.members = owners(system, all);
  return found;
}

/// Whether the constraints depend on each other in this pose alone: out of it, moved by some 1e-2 of the machine's
/// length in no particular direction, they have full rank.
bool dependent_here_only(System& system, double t, const Eigen::VectorXd& q, const Dependencies& dependent) {
  const int equations = system.equations() - system.open_rows();
  if (dependent.rank == equations || equations > system.coordinates()) return false;
  Eigen::VectorXd beside = q;
  for (Eigen::Index i = 0; i < q.size(); ++i)
    beside[i] += 1e-2 * std::sin(1.0 + 2.4 * static_cast<double>(i)) * (i % 3 == 2 ? 1 : system.length_scale());
  Constraints c;
  system.set_position(t, beside);
  system.constraints(c);
  const bool full = find_dependencies(system, scaled_jacobian(system, c)).rank == equations;
  system.set_position(t, q);
  return full;
}

[[noreturn]] void refuse_singular_start(const System& system, const Eigen::VectorXd& left,
                                        const Dependencies& dependent) {
  throw ModelFault(system.part(rows_by_residual(left).front()),
                   "the start pose is a singular configuration: " + residual_list(system, left, true) +
                       " off, since there " + list(dependent.members) +
                       " depend on each other. Start beside it, or drive another coordinate.");
}

[[noreturn]] void refuse_contradiction(const System& system, const Eigen::VectorXd& phi, const Dependencies& dependent,
                                       bool rates) {
  std::string text =
      rates ? "the velocities asked of the machine contradict each other: " : "the machine cannot be assembled: ";
  text += residual_list(system, phi, rates) + (rates ? " off." : " open.");
  if (!dependent.members.empty()) {
    const bool driven = std::any_of(dependent.members.begin(), dependent.members.end(),
                                    [](const PartName& m) { return m.kind == PartName::Kind::driver; });
    text += driven ? " Over-determined by " + list(dependent.members) + ": drop a driver or free a joint."
                   : " Over-determined by " + list(dependent.members) + ": drop one or correct its points.";
  } else {
    text += " Correct the points of these joints or start nearer to a pose that closes them.";
  }
  for (const int row : rows_by_residual(phi)) {
    const PartName& part = system.part(row);
    if (part.kind != PartName::Kind::joint || std::abs(phi[row]) <= 1e-3 * phi.cwiseAbs().maxCoeff()) continue;
    if (!system.may_open(find_named(system.model().joints, "joint", part.name))) continue;
    text += " Where " + part.text() + " is to close on the way only, give an event of it `joint starts: open`.";
    break;
  }
  throw ModelFault(system.part(rows_by_residual(phi).front()), text);
}

}  // namespace

Eigen::VectorXd coordinate_scale(const System& system) {
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(system.coordinates());
  for (int i = 2; i < system.coordinates(); i += 3) scale[i] = system.length_scale();
  return scale;
}

Eigen::VectorXd row_scale(const System& system) {
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(system.equations());
  for (int i = 0; i < system.equations(); ++i)
    if (system.angular_row(i)) scale[i] = system.length_scale();
  return scale;
}

Eigen::MatrixXd scaled_jacobian(const System& system, const Constraints& c) {
  return row_scale(system).asDiagonal() * c.jacobian * coordinate_scale(system).cwiseInverse().asDiagonal();
}

std::vector<PartName> contradicting_parts(const System& system) {
  constexpr double rounding = 1e-6;  // of the velocities that are asked for
  if (system.equations() == 0 || system.coordinates() == 0) return {};
  Constraints c;
  system.constraints(c);
  const Eigen::VectorXd asked = row_scale(system).cwiseProduct(c.phi_t);
  const Eigen::VectorXd off = outside_range(scaled_jacobian(system, c), asked);
  if (!(off.cwiseAbs().maxCoeff() > rounding * asked.cwiseAbs().maxCoeff())) return {};
  return owners(system, off);
}

std::string different_motions(const std::vector<PartName>& parts) {
  return list(parts) + " depend on each other and ask for different motions from here on";
}

void refuse_open_joints(System& system, double t, const Eigen::VectorXd& q) {
  if (system.equations() == 0) return;
  Constraints c;
  system.set_position(t, q);
  system.constraints(c);
  const double limit = 1e-9 * system.length_scale();
  if (row_scale(system).cwiseProduct(c.phi).cwiseAbs().maxCoeff() <= limit) return;
  throw ModelFault(system.part(rows_by_residual(c.phi).front()),
                   "the start pose does not close the joints: " + residual_list(system, c.phi, false) +
                       " open, allowed are " + number(limit) +
                       " m (1e-9 of the machine's length). Correct the pose, or let the program assemble it.");
}

namespace {

using Mask = std::vector<bool>;  // of coordinates: those that stay

/// Coordinates of poses that stay as they are.
Mask held_positions(const System& system) {
  Mask held(static_cast<std::size_t>(system.coordinates()), false);
  const auto& bodies = system.model().bodies;
  for (std::size_t i = 0; i < held.size(); ++i) held[i] = bodies[i / 3].pose_is == StartMark::exact;
  return held;
}

/// Whether the model says anything of velocity k of a body: 0 is what is left out.
bool gives_velocity(const Body& body, std::size_t k) {
  return body.velocity_is == StartMark::exact || (body.velocity_is == StartMark::given && body.velocity[k] != 0);
}

Mask held_velocities(const System& system) {
  Mask held(static_cast<std::size_t>(system.coordinates()), false);
  const auto& bodies = system.model().bodies;
  for (std::size_t i = 0; i < held.size(); ++i) held[i] = gives_velocity(bodies[i / 3], i % 3);
  return held;
}

/// The least change of the coordinates that are not held which makes scaled_jacobian * change = right.
Eigen::VectorXd least_change(const System& system, const Constraints& c, const Mask& held,
                             const Eigen::VectorXd& right) {
  Eigen::MatrixXd jacobian = scaled_jacobian(system, c);
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i]) jacobian.col(static_cast<Eigen::Index>(i)).setZero();
  return coordinate_scale(system).cwiseInverse().cwiseProduct(least_norm_solution(jacobian, right, rank_share));
}

/// Newton with halving: full steps near the solution, and no step that opens the joints further. Returns the largest
/// |Phi| that is left, angles times length; c holds the constraints there.
double close_joints(System& system, double t, Eigen::VectorXd& q, Constraints& c, int& iterations) {
  const Eigen::VectorXd rows = row_scale(system);
  const Mask held = held_positions(system);
  const auto residual = [&](const Eigen::VectorXd& at) {
    system.set_position(t, at);
    system.constraints(c);
    return Eigen::VectorXd(rows.cwiseProduct(c.phi));
  };
  const double length = system.length_scale();
  const auto goal = [&] { return 1e-14 * std::max({length, q.cwiseAbs().maxCoeff()}); };
  Eigen::VectorXd phi = residual(q);
  double worst = phi.cwiseAbs().maxCoeff();
  for (int idle = 0; worst > goal() && idle < 3 && iterations < most_iterations; ++iterations) {
    Eigen::VectorXd step = -least_change(system, c, held, phi);
    step *= std::min(1.0, 0.5 * length / std::max(1e-300, largest_displacement(system, step)));
    double share = 1;
    Eigen::VectorXd next = q + step, phi_next = residual(next);
    while (phi_next.norm() > phi.norm() && share > 1e-4) {
      share /= 2;
      next = q + share * step;
      phi_next = residual(next);
    }
    if (phi_next.norm() > 0.999 * phi.norm()) ++idle;  // at rounding, or stuck
    if (phi_next.norm() <= phi.norm()) q = next;
    phi = residual(q);
    worst = phi.cwiseAbs().maxCoeff();
  }
  return worst;
}

/// Puts velocities on Phi_q q' = -Phi_t, those held as they are; false when that cannot be.
bool put_on_velocities(const System& system, const Constraints& c, const Mask& held, Eigen::VectorXd& velocity,
                       Eigen::VectorXd& left) {
  const Eigen::VectorXd rows = row_scale(system);
  const auto off = [&] { return Eigen::VectorXd(c.jacobian * velocity + c.phi_t); };
  for (int pass = 0; pass < 2; ++pass)  // the second takes the rounding away
    velocity -= least_change(system, c, held, rows.cwiseProduct(off()));
  left = off();
  const double speed = std::max(c.phi_t.cwiseAbs().maxCoeff(), velocity.cwiseAbs().maxCoeff());
  return left.cwiseAbs().maxCoeff() <= 1e-9 * std::max(1e-3, speed);
}

}  // namespace

AssemblyReport assemble(System& system, double t, Eigen::VectorXd& q, Eigen::VectorXd& velocity) {
  AssemblyReport report;
  report.equations = system.equations();
  report.freedom = system.coordinates();
  system.set_state(t, q, velocity);
  if (report.equations == 0) return report;

  Constraints c;
  const Eigen::VectorXd start = q;
  const double worst = close_joints(system, t, q, c, report.iterations);
  const Dependencies dependent = find_dependencies(system, scaled_jacobian(system, c));
  if (worst > 1e-11 * std::max(system.length_scale(), q.cwiseAbs().maxCoeff()))
    refuse_contradiction(system, c.phi, dependent, false);
  const Eigen::VectorXd given = velocity;
  Eigen::VectorXd left;
  if (!put_on_velocities(system, c, held_velocities(system), velocity, left)) {
    velocity = given;
    const Mask none(static_cast<std::size_t>(system.coordinates()), false);
    if (!put_on_velocities(system, c, none, velocity, left)) {
      if (dependent_here_only(system, t, q, dependent)) refuse_singular_start(system, left, dependent);
      refuse_contradiction(system, left, dependent, true);
    }
  }

  report.rank = dependent.rank;
  report.freedom = system.coordinates() - dependent.rank;
  report.redundant = dependent.texts, report.redundant_parts = dependent.parts;
  report.residual = worst;
  int farthest = 1;
  report.moved = largest_displacement(system, q - start, &farthest);
  report.moved_body = system.body_name(farthest);
  system.set_state(t, q, velocity);
  return report;
}

void refuse_changed_start(const System& system, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity) {
  constexpr double pose_share = 0.01, velocity_share = 1e-3;
  constexpr const char* names[2][3] = {{"x", "y", "angle"}, {"velocity x", "velocity y", "spin"}};
  constexpr const char* units[2][3] = {{"m", "m", "rad"}, {"m/s", "m/s", "rad/s"}};
  const auto& bodies = system.model().bodies;
  const double fastest = largest_displacement(system, velocity);
  // A component is named where it is a tenth of the difference: the rest is below what the reader can correct.
  constexpr double share_of_difference = 0.1;
  std::string text;
  PartName first;
  std::vector<std::size_t> changed;
  const auto list_change = [&](std::size_t body, int level, std::size_t k, double given, double assembled) {
    const PartName part{PartName::Kind::body, bodies[body].name};
    if (text.empty()) first = part;
    changed.push_back(body + 1);
    text += (text.empty() ? "" : "; ") + part.text() + " " + names[level][k] + ": given " + number(given) +
            ", assembled " + number(assembled) + ", difference " + number(assembled - given) + " " + units[level][k];
  };
  bool moved = false;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& b = bodies[i];
    const double size = system.body_size(static_cast<int>(i) + 1);
    const auto at = [i](std::size_t k) { return static_cast<Eigen::Index>(3 * i + k); };
    const auto moved_by = [&](std::size_t k) { return q[at(k)] - b.pose[k]; };
    const auto faster_by = [&](std::size_t k) { return gives_velocity(b, k) ? velocity[at(k)] - b.velocity[k] : 0; };
    const double displacement = std::hypot(moved_by(0), moved_by(1)), turn = std::abs(moved_by(2)) * size;
    const double pose_allowed = b.pose_is == StartMark::about   ? std::numeric_limits<double>::infinity()
                                : b.pose_is == StartMark::exact ? 1e-9 * size
                                                                : pose_share * size;
    const double change = std::hypot(faster_by(0), faster_by(1));
    const double spin_change = std::abs(faster_by(2)) * system.length_scale();
    const double share = b.velocity_is == StartMark::exact ? 1e-9 : velocity_share;
    const double speed_allowed = share * std::max(fastest, std::hypot(b.velocity[0], b.velocity[1]));
    const double spin_allowed = share * std::max(fastest, std::abs(b.velocity[2]));
    for (std::size_t k = 0; k < 3; ++k) {
      const bool angular = k == 2;
      const bool named = angular || std::abs(moved_by(k)) >= share_of_difference * displacement;
      if (named && !((angular ? turn : displacement) <= pose_allowed))
        list_change(i, 0, k, b.pose[k], q[at(k)]), moved = true;
      const bool asked = gives_velocity(b, k) && (angular || std::abs(faster_by(k)) >= share_of_difference * change);
      if (asked && !((angular ? spin_change : change) <= (angular ? spin_allowed : speed_allowed)))
        list_change(i, 1, k, b.velocity[k], velocity[at(k)]);
    }
  }
  if (text.empty()) return;
  std::string open;
  const Chains chains = chains_of(system.model());
  const auto is_changed = [&](std::size_t joint) {
    return std::any_of(changed.begin(), changed.end(),
                       [&](std::size_t body) { return chains.of_bodies[body] == chains.of_joints[joint]; });
  };
  for (const auto& e : system.model().events)
    if (e.element.does == JointEvent::Does::closes && !system.open_joints()[e.element.index] &&
        is_changed(e.element.index))
      open =
          ", or let joint '" + e.element.joint + "', which begins closed, be open: `joint starts: open` at its event";
  throw ModelFault(first, "the joints do not allow the start that is given: " + text + ". Correct it, or write `" +
                              (moved ? "pose is: about" : "velocity is: about") +
                              "` at the body to let the program change it" + open);
}

}  // namespace subsoil::mbd
