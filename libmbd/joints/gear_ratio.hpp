#pragma once

#include <stdexcept>

#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Gear ratio: the turns of two bodies against a third one, the carrier, are in a fixed ratio, as through a gear train,
/// a belt or a chain that is not drawn.
///   Phi = (angle_b - angle_c) - i (angle_a - angle_c) - offset = 0              (rad)
/// i = (omega_b - omega_c) / (omega_a - omega_c), not 0: -R_a/R_b for outer gears, R_a/R_b for a ring gear or an open
/// belt; offset is Phi of the start pose. Without a carrier c is the ground. Reaction: torques lambda i on a, -lambda
/// on b and what balances them on the carrier; no forces (a gear pair has the tooth force). Source: Willis' equation;
/// Norton, Design of Machinery, 9.
struct GearRatio {
  static constexpr ConstraintMembers has{
      .check = true, .initialise_from_pose = true, .third_body = true, .reaction_point = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{true};
  int body_a = -1, body_b = -1, body_c = ground;
  double ratio = std::numeric_limits<double>::quiet_NaN();
  double offset = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("gear ratio", "the turns of two bodies are in a fixed ratio, as through gears or a belt that are not drawn");
    v.bodies("gear ratio", body_a, body_b, "the driving and the driven body; the torque is reported on the first");
    v.quantity("ratio", ratio, "1", "(-inf, inf)",
               "turn of the second body over that of the first, both against the carrier; negative: opposite turns");
    v.optional_body("carrier", body_c, "the body that carries both axes; left out: the ground");
  }
  void check() const {
    if (!std::isfinite(ratio) || ratio == 0)
      throw std::invalid_argument("ratio must be given and not 0; to hold the second body's angle use an angle driver");
  }

  void initialise_from_pose(const BodyState& a, const BodyState& b, const BodyState& c, double /*t*/) {
    if (std::isnan(offset)) offset = b.angle - c.angle - ratio * (a.angle - c.angle);
  }
  void evaluate(const BodyState& a, const BodyState& b, const BodyState& c, double /*t*/,
                ConstraintRows<rows>& out) const {
    out[0] = {
        b.angle - c.angle - ratio * (a.angle - c.angle) - offset, {0, 0, -ratio}, {0, 0, 1}, 0, 0, {0, 0, ratio - 1}};
  }
  Vec2 reaction_point(const BodyState& a, const BodyState&) const { return a.r; }
};

}  // namespace subsoil::mbd
