#pragma once

#include <array>
#include <concepts>
#include <cstddef>

#include "libmbd/base/body.hpp"
#include "libmbd/element/any_element.hpp"

namespace subsoil::mbd {

/// One scalar constraint Phi(q, t) = 0 between body a, body b and, for elements with a `body_c`, body c, as a joint or
/// driver hands it over.
///   on_a, on_b, on_c  dPhi/d(x, y, angle) of the bodies: its row of Phi_q
///   gamma       right side of Phi_q q'' = gamma: -(Phi_q q')_q q' - 2 Phi_qt q' - Phi_tt
///   phi_t       dPhi/dt at fixed q; zero but for drivers
/// Multipliers follow M q'' + Phi_q^T lambda = F: the constraint puts -on_a * lambda on a, -on_b * lambda on b, -on_c *
/// lambda on c.
struct ConstraintRow {
  double phi = 0;
  std::array<double, 3> on_a{}, on_b{};
  double gamma = 0;
  double phi_t = 0;
  std::array<double, 3> on_c{};
};

/// What becomes of constraints that depend on each other: their reactions are the ones of minimum norm among all that
/// balance, or the machine is refused.
enum class Redundancy { minimum_norm, refuse };

template <std::size_t n>
using ConstraintRows = std::array<ConstraintRow, n>;

/// What a joint or driver has beside evaluate(), as its `static constexpr ConstraintMembers has{...}`. The system calls
/// what stands here and nothing else. IsJoint and IsDriver compare it with the members that there are, so that a
/// misspelt one is no silent loss: the element does not convert to AnyJoint.
struct ConstraintMembers {
  bool check = false;                  ///< check(): refuses parameters, by std::invalid_argument
  bool initialise_from_pose = false;   ///< initialise_from_pose(a, b, t), with a third body (a, b, c, t)
  bool points = false;                 ///< p_a, p_b: its points in the axes of bodies a and b
  bool third_body = false;             ///< body_c: evaluate() gets it, ConstraintRow::on_c is its share
  bool reaction_point = false;         ///< reaction_point(a, b): world point at which the reaction is reported
  bool characteristic_length = false;  ///< characteristic_length(): a length of its own, for the machine's scale (m)
  bool pin = false;    ///< two rows, of which the first depends on no y and the second on no x: solvers leave these out
  bool latch = false;  ///< latch(a, b): closes where the bodies are; latched(), set_latched(m): what that has decided
};

namespace detail {
template <class E>
concept EvaluatesTwo = requires(const E e, const BodyState body, ConstraintRows<E::rows> out) {
  e.evaluate(body, body, 0.0, out);
};
template <class E>
concept EvaluatesThree = requires(const E e, const BodyState body, ConstraintRows<E::rows> out) {
  e.evaluate(body, body, body, 0.0, out);
};
template <class E>
concept Initialises = requires(E e, const BodyState body) {
  e.initialise_from_pose(body, body, 0.0);
}
|| requires(E e, const BodyState body) { e.initialise_from_pose(body, body, body, 0.0); };
/// E::has is what E has.
template <class E>
concept ConstraintHas = E::has.check == requires(const E e) {
  e.check();
}
&&E::has.initialise_from_pose == Initialises<E>&& E::has.points == requires(E e) { e.p_a[0], e.p_b[0]; }
&&E::has.third_body == requires(E e) { e.body_c; }
&&E::has.reaction_point == requires(const E e, const BodyState body) { e.reaction_point(body, body); }
&&E::has.characteristic_length == requires(const E e) { e.characteristic_length(); }
&&(!E::has.pin || E::rows == 2) && E::has.latch == requires(E e, const BodyState body) {
  e.latch(body, body);
  e.set_latched(e.latched());
};
}  // namespace detail

/// A joint: rows of Phi between the bodies that it names.
template <class E>
concept IsJoint = requires(E e) {
  { E::has } -> std::same_as<const ConstraintMembers&>;
  { e.angular.size() } -> std::same_as<std::size_t>;
  { e.body_a } -> std::same_as<int&>;
  { e.body_b } -> std::same_as<int&>;
}
&&detail::ConstraintHas<E> && (E::has.third_body ? detail::EvaluatesThree<E> : detail::EvaluatesTwo<E>);

/// A driver: one row of Phi whose value follows a motion f(t).
template <class E>
concept IsDriver = requires(const E e) {
  { E::has } -> std::same_as<const ConstraintMembers&>;
  { e.angular() } -> std::same_as<bool>;
  { e.body_a() } -> std::same_as<int>;
  { e.body_b() } -> std::same_as<int>;
  e.motion;
}
&&detail::ConstraintHas<E>&& detail::EvaluatesTwo<E>;

struct JointFamily {
  template <class E>
  static constexpr bool takes = IsJoint<E>;
};
struct DriverFamily {
  template <class E>
  static constexpr bool takes = IsDriver<E>;
};
using AnyJoint = AnyElement<JointFamily>;
using AnyDriver = AnyElement<DriverFamily>;

}  // namespace subsoil::mbd
