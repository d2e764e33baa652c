#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace subsoil::test {

/// A block on a level slide between a spring and dry friction, let go at 0.3 m.
/// The block by its linear equations from one change to the next, m x'' + d x' + K (x - x_0) = 0 in each, and the times
/// of the changes: it sticks where v = 0, with the sticking spring's force that holds it or all of mu m g but 1e-4; it
/// slides where that spring's k (x - s) + d v = mu m g.
struct Sledge {
  static constexpr double mass = 4, g = 9.81, spring = 200, stick_stiffness = 2e4, stick_damping = 170, mu = 0.15;
  double t = 0, x = 0.3, v = 0, stuck_at = x + hold() / stick_stiffness;
  int sliding = 0;
  std::vector<double> changes{};

  /// x and v after a time in the present phase.
  std::array<double, 2> after(double dt) const {
    const bool sticks = sliding == 0;
    const double stiffness = spring + (sticks ? stick_stiffness : 0), decay = sticks ? stick_damping / (2 * mass) : 0;
    const double rest = ((sticks ? stick_stiffness * stuck_at : -sliding * mu * mass * g)) / stiffness;
    const double w = std::sqrt(stiffness / mass - decay * decay), a = x - rest, b = (v + decay * a) / w;
    const double c = std::cos(w * dt), s = std::sin(w * dt), fade = std::exp(-decay * dt);
    const double now = fade * (a * c + b * s);
    return {rest + now, fade * w * (b * c - a * s) - decay * now};
  }
  /// Positive within the phase; at its very beginning a sliding block has no speed.
  double left(double dt) const {
    const auto [y, u] = after(dt);
    return sliding ? sliding * u : mu * mass * g - std::abs(stick_stiffness * (y - stuck_at) + stick_damping * u);
  }
  /// Force of the sticking spring as it begins.
  double hold() const { return std::clamp(spring * x, -(1 - 1e-4) * mu * mass * g, (1 - 1e-4) * mu * mass * g); }
  void run(double end) {
    constexpr double look = 1e-3;
    for (double dt = look; t + dt < end; dt += look) {
      if (left(dt) > 0) continue;
      double low = dt - look, high = dt;
      for (int i = 0; i < 60; ++i) (left((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
      const auto [y, u] = after(high);
      t += high, x = y, v = u;
      stuck_at = x + hold() / stick_stiffness;
      sliding = sliding ? 0 : v > 0 ? 1 : -1;
      changes.push_back(t);
      dt = 0;
    }
    const auto [y, u] = after(end - t);
    x = y, v = u, t = end;
  }
};

}  // namespace subsoil::test
