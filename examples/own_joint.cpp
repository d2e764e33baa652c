// A joint of one's own: a bead on the parabola y = k x^2. At the bottom its speed is that of free fall, and the wire
// bears m (g + v^2/R), R = 1/(2 k).
#include "libmbd/joints/own_joint.hpp"

#include <cmath>
#include <cstdio>

#include "libmbd/machine.hpp"

namespace mine {
using namespace subsoil::mbd;

/// The centre of gravity of body b stays on y = k x^2 of the world:
///   Phi = y - k x^2,  Phi_q = (-2 k x, 1, 0),  gamma = -(Phi_q q')_q q' = 2 k x'^2
struct OnParabola {
  static constexpr ConstraintMembers has{};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = ground, body_b = -1;
  double k = 0;

  void evaluate(const BodyState& /*a*/, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const double slope = 2 * k * b.r.x;
    out[0].phi = b.r.y - k * b.r.x * b.r.x;
    out[0].on_b = {-slope, 1, 0};
    out[0].on_a = {slope, -1, -b.r.x - slope * b.r.y};  // of the ground too: what the wire bears
    out[0].gamma = 2 * k * b.v.x * b.v.x;
  }
};
}  // namespace mine

int main() {
  using namespace subsoil::mbd;
  const double k = 0.5, mass = 2, g = 9.81, start = 0.8;
  Model model;
  model.gravity = {0, -g};
  const int bead = model.add({.name = "bead", .mass = mass, .inertia = 0.01, .pose = {start, k * start * start, 0}});
  model.add("wire", OwnJoint(mine::OnParabola{.body_b = bead, .k = k}));
  Machine machine(model, {.integrator = IntegratorKind::cvode});
  machine.start_from_pose();

  double time = 0, speed = 0, load = 0;
  while (machine.body(bead).r.x > 0) machine.advance_to(time += 1e-4);
  speed = std::hypot(machine.body(bead).v.x, machine.body(bead).v.y);
  load = -machine.joint_reaction("wire").fy;  // on the ground
  const double exact_speed = std::sqrt(2 * g * k * start * start);
  const double exact_load = mass * (g + exact_speed * exact_speed * 2 * k);
  std::printf("at the bottom %.5f m/s (exact %.5f), the wire bears %.4f N (exact %.4f)\n", speed, exact_speed, load,
              exact_load);
  // The bottom is passed within 1e-4 s, where the bead is k (v dt)^2 = 4e-8 m above it.
  return std::abs(speed - exact_speed) < 1e-5 && std::abs(load - exact_load) < 1e-3 ? 0 : 1;
}
