#include "libmbd/integrators/kinematic.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace subsoil::mbd {

namespace {
constexpr int most_halvings = 12;
/// Gauss's rule on [0, 1]: points 1/2 -+ sqrt(15)/10.
constexpr double gauss_points[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
constexpr double gauss_weights[3] = {5. / 18, 8. / 18, 5. / 18};
}  // namespace

std::string coordinate_name(const System& system, int coordinate) {
  static constexpr const char* axes[] = {".x", ".y", ".angle"};
  return system.body_name(coordinate / 3 + 1) + axes[coordinate % 3];
}

void Kinematic::on_start() {
  clock_.restart();
  if (system_.state_count() > 0)
    throw std::invalid_argument(
        "kinematic analysis: cylinders, motors, controllers and contacts that stick have states of "
        "their own, which it does not integrate; "
        "take `analysis: dynamics`");
  if (partition_.freedom() == 0) return;
  std::string free;
  for (const int i : partition_.independent()) free += (free.empty() ? "" : ", ") + coordinate_name(system_, i);
  throw std::invalid_argument("kinematic analysis: " + std::to_string(partition_.freedom()) +
                              " of the machine's freedoms are driven by nothing (" + free +
                              " for example): drive them, or let the forces move them by `analysis: dynamics`");
}

double distance_of(const System& system, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double most = 0;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(a[i] - b[i]) * (i % 3 == 2 ? system.length_scale() : 1.0));
  return most;
}

void Kinematic::follow(double to, int depth) {
  const MotionState before = now_;
  const double dt = to - now_.t;
  const Eigen::VectorXd expected = now_.q + dt * now_.velocity + 0.5 * dt * dt * now_.acceleration;
  now_.q = expected, now_.t = to;
  const bool last = depth == most_halvings;
  bool found = true;
  try {
    partition_.evaluate(now_);
  } catch (const std::runtime_error&) {
    if (last) {
      now_ = before;
      throw;
    }
    found = false;
  }
  if (found && distance_of(system_, now_.q, expected) <= branch_limit(system_)) return;
  now_ = before;
  if (last) throw MotionFault(to, "the pose jumps; the drivers lead through a dead centre or a lock-up");
  partition_.evaluate(now_);
  follow(before.t + 0.5 * dt, depth + 1);
  follow(to, depth + 1);
}

void Kinematic::advance_smoothly(double until) {
  const double begin = now_.t, dt = until - begin;
  const auto come_to = [&](double t) {
    try {
      follow(t, 0);
    } catch (const std::runtime_error&) {
      keep_end();  // rows up to there are read
      throw;
    }
    if (watches_switches() && finds_events()) update_contacts(), release_friction();
  };
  for (int k = 0; k < 3; ++k) {
    come_to(begin + gauss_points[k] * dt);
    flows_.of_elements += gauss_weights[k] * dt * now_.rates;
  }
  come_to(until);
}

void Kinematic::on_advance(double h) {
  const double end = clock_.end_of_step(now_.t, h, asked_end_);
  while (now_.t < end) advance_smoothly(inputs_.next_corner(now_.t, end));
}

}  // namespace subsoil::mbd
