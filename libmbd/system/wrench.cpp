#include "libmbd/system/wrench.hpp"

#include "libmbd/elements.hpp"
#include "libmbd/system/bodies_of.hpp"

namespace subsoil::mbd {

namespace {

/// The rows of a joint at the system's state, as the joint itself says them.
template <class Joint>
ConstraintRows<Joint::rows> rows_of(const Joint& j, const System& system) {
  ConstraintRows<Joint::rows> rows;
  const BodyState &a = system.body(j.body_a), &b = system.body(j.body_b);
  if constexpr (Joint::has.third_body) {
    j.evaluate(a, b, system.body(j.body_c), system.time(), rows);
  } else {
    j.evaluate(a, b, system.time(), rows);
  }
  return rows;
}

/// Where a joint's reaction acts: its own point, or its point on the second body.
template <class Joint>
Vec2 reaction_point(const Joint& j, const BodyState& a, const BodyState& b) {
  if constexpr (Joint::has.reaction_point) {
    return j.reaction_point(a, b);
  } else {
    return b.point_in_world(j.p_b);
  }
}

/// The part of a row that belongs to a body; the ground has one too.
template <class Joint>
std::array<double, 3> share_of(const Joint& j, const ConstraintRow& row, int body) {
  if (body == j.body_a) return row.on_a;
  if (body == j.body_b) return row.on_b;
  if constexpr (Joint::has.third_body) {
    if (body == j.body_c) return row.on_c;
  }
  return {};
}

}  // namespace

std::vector<int> bodies_of_joint(const System& system, std::size_t i) {
  return visit([](const auto& joint) { return bodies_of(joint); }, system.model().joints[i].element);
}
std::vector<int> bodies_of_force(const System& system, std::size_t i) {
  return visit([](const auto& force) { return bodies_of(force); }, system.model().forces[i].element);
}

Wrench joint_wrench(const System& system, std::size_t joint, const Eigen::VectorXd& lambda, int body) {
  const int first = system.first_row_of_joint(joint);
  return visit(
      [&](const auto& j) {
        const auto rows = rows_of(j, system);
        double w[3] = {0, 0, 0};  // about the body's centre of gravity
        for (std::size_t i = 0; i < rows.size(); ++i) {
          const auto share = share_of(j, rows[i], body);
          for (std::size_t k = 0; k < 3; ++k) w[k] -= share[k] * lambda[first + static_cast<Eigen::Index>(i)];
        }
        return Wrench{{w[0], w[1]}, w[2], system.body(body).r}.moved_to(
            reaction_point(j, system.body(j.body_a), system.body(j.body_b)));
      },
      system.model().joints[joint].element);
}

Wrench force_wrench(const System& system, std::size_t force, const Eigen::VectorXd& lambda, int body) {
  const auto bodies = static_cast<std::size_t>(system.bodies());
  std::vector<std::array<double, 3>> wrenches(bodies);
  Loads loads(wrenches);
  ForceValues values{};
  const Scene scene{std::span(&system.body(ground), bodies),
                    system.time(),
                    system.ruts(),
                    std::span(lambda.data(), static_cast<std::size_t>(lambda.size())),
                    system.element_states(),
                    system.signals()};
  visit([&](const auto& f) { f.evaluate(scene, loads, values); }, system.model().forces[force].element);
  const auto& w = wrenches[static_cast<std::size_t>(body)];
  return {{w[0], w[1]}, w[2], system.body(body).r};
}

}  // namespace subsoil::mbd
