// Springs, dampers and forces in closed form: free, damped, forced, coupled and torsional oscillations, masses on
// turning arms, and free flight.

#include <cmath>

#include "tests/verification/mechanisms/cases/case.hpp"
#include "tests/verification/mechanisms/cases/oscillation.hpp"

namespace subsoil::cases {
namespace {

/// Three masses of 2 kg on springs of 200 N/m along x (w = 10 rad/s), free length 1 m, from 0.1 m beyond it with
/// -0.5 m/s; dampers of 4, 40 and 100 N s/m: ratios 0.1, 1 and 2.5.
Reference damped_masses() {
  return [](double t) {
    Expected out;
    const std::pair<const char*, double> masses[] = {{"under", 4}, {"critical", 40}, {"over", 100}};
    for (const auto& [name, c] : masses) {
      const State s = free_oscillation(2, c, 200, 0.1, -0.5, t);
      add(out, name, "x", 1, s);
      const std::string spring = std::string(name) + " spring";
      out.push_back({spring + ".force", -200 * s[0] - c * s[1]});
      out.push_back({spring + ".length", 1 + s[0]});
      out.push_back({std::string(name) + " rail.fy", -2 * g});
    }
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// Undamped masses under a sine: one driven at its own frequency grows as t, one at 0.9 of it beats.
///   u = F/(2 m w) (sin(w t)/w - t cos(w t));   u = F/(m (w^2 - p^2)) (sin(p t) - p/w sin(w t))
/// and a damped one under a constant force that settles.
Reference forced_masses() {
  return [](double t) {
    const double m = 2, w = 10, f = 5, p = 9, c = 6;
    Expected out;
    const double a = f / (2 * m * w);
    const State grows{a * (std::sin(w * t) / w - t * std::cos(w * t)), a * w * t * std::sin(w * t),
                      a * w * (std::sin(w * t) + w * t * std::cos(w * t))};
    const double b = f / (m * (w * w - p * p));
    const State beats{b * (std::sin(p * t) - p / w * std::sin(w * t)), b * p * (std::cos(p * t) - std::cos(w * t)),
                      b * p * (w * std::sin(w * t) - p * std::sin(p * t))};
    const double rest = f / (m * w * w);
    const State about = free_oscillation(m, c, m * w * w, -rest, 0, t);
    add(out, "resonant", "x", 1, grows);
    add(out, "beating", "x", 1, beats);
    add(out, "pushed", "x", 1, {rest + about[0], about[1], about[2]});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// Wall - k - m - k - m - k - wall: modes in phase at sqrt(k/m), out of phase at sqrt(3 k/m).
Reference coupled_masses() {
  return [](double t) {
    const double m = 1.5, k = 150, w1 = std::sqrt(k / m), w2 = std::sqrt(3 * k / m);
    const double sum = 0.05 / 2, c1 = std::cos(w1 * t), s1 = std::sin(w1 * t), c2 = std::cos(w2 * t),
                 s2 = std::sin(w2 * t);
    Expected out;
    add(out, "first", "x", 1, {sum * (c1 + c2), -sum * (w1 * s1 + w2 * s2), -sum * (w1 * w1 * c1 + w2 * w2 * c2)});
    add(out, "second", "x", 2, {sum * (c1 - c2), -sum * (w1 * s1 - w2 * s2), -sum * (w1 * w1 * c1 - w2 * w2 * c2)});
    out.push_back(
        {"energy.kinetic", 0.5 * m * sum * sum * (std::pow(w1 * s1 + w2 * s2, 2) + std::pow(w1 * s1 - w2 * s2, 2))});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// A disc on a torsion spring to the ground with a damper, and two discs on a shaft that twists against each other.
Reference torsion() {
  return [](double t) {
    Expected out;
    const State wheel = free_oscillation(0.2, 0.3, 30, 0, 4, t);
    add(out, "wheel", "angle", 0, wheel);
    out.push_back({"hub spring.torque", -30 * wheel[0] - 0.3 * wheel[1]});
    // Relative angle: I_eff = I1 I2/(I1 + I2); the pair as a whole turns at a constant rate.
    const double i1 = 0.1, i2 = 0.3, k = 12, v1 = 5, v2 = 1, mean = (i1 * v1 + i2 * v2) / (i1 + i2);
    const State twist = free_oscillation(i1 * i2 / (i1 + i2), 0, k, 0, v2 - v1, t);
    State a, b;
    for (std::size_t n = 0; n < 3; ++n) {
      const double common = n == 0 ? mean * t : n == 1 ? mean : 0;
      a[n] = common - i2 / (i1 + i2) * twist[n];
      b[n] = common + i1 / (i1 + i2) * twist[n];
    }
    add(out, "disc a", "angle", 0, a);
    add(out, "disc b", "angle", 0, b);
    out.push_back({"shaft.torque", -k * twist[0]});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// Masses that slide on arms turned at w = 6 rad/s, no gravity: r'' = (w^2 - k/m) r + k L_0/m. Without a spring
/// r = r_0 cosh(w t); with one r swings about k L_0/(k - m w^2). Across the arm the mass takes 2 m w r', which loads
/// the motor with the moment 2 m w r r'.
Reference turning_arms() {
  return [](double t) {
    const double w = 6, m = 0.5, k = 50, free = 0.4, r0 = 0.5;
    const auto place = [&](Expected& out, const std::string& body, const State& r, double turn) {
      const double c = std::cos(turn), s = std::sin(turn);
      const double along = r[2] - w * w * r[0], across = 2 * w * r[1];
      out.insert(out.end(), {{body + ".x", r[0] * c},
                             {body + ".y", r[0] * s},
                             {body + ".angle", w * t},
                             {body + ".vx", r[1] * c - w * r[0] * s},
                             {body + ".vy", r[1] * s + w * r[0] * c},
                             {body + ".spin", w},
                             {body + ".ax", along * c - across * s},
                             {body + ".ay", along * s + across * c},
                             {body + ".alpha", 0}});
    };
    Expected out;
    const State flung{0.01 * std::cosh(w * t), 0.01 * w * std::sinh(w * t), 0.01 * w * w * std::cosh(w * t)};
    const double centre = k * free / (k - m * w * w);
    State held = free_oscillation(m, 0, k - m * w * w, r0 - centre, 0, t);
    held[0] += centre;
    place(out, "flung", flung, w * t);
    place(out, "held", held, w * t + pi / 2);
    out.push_back({"motor.torque", 2 * m * w * (flung[0] * flung[1] + held[0] * held[1])});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// A bar thrown with spin, and one pulled by a constant follower force along its axis while a moment turns it evenly:
/// angle = s t, a = F/m (cos(s t), sin(s t)), no weight on the second by an equal force upward.
Reference free_flight() {
  return [](double t) {
    Expected out;
    add(out, "thrown", "x", 0, {3 * t, 3, 0});
    add(out, "thrown", "y", 1, {4 * t - g / 2 * t * t, 4 - g * t, -g});
    add(out, "thrown", "angle", 0, {5 * t, 5, 0});
    const double a = 8.0 / 2, s = 2;
    add(out, "rocket", "x", 0, {a / (s * s) * (1 - std::cos(s * t)), a / s * std::sin(s * t), a * std::cos(s * t)});
    add(out, "rocket", "y", 0,
        {a / s * t - a / (s * s) * std::sin(s * t), a / s * (1 - std::cos(s * t)), a * std::sin(s * t)});
    add(out, "rocket", "angle", 0, {s * t, s, 0});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

}  // namespace

std::vector<Case> oscillators() {
  return {
      {"damped-masses", "closed form: damping ratio 0.1, 1 and 2.5", {1e-11, 1e-10, 1e-9, 1e-8, 1e-10}, damped_masses},
      {"forced-masses", "closed form: resonance, beats, step", {1e-10, 1e-9, 1e-8, 1e-8, 1e-9}, forced_masses},
      {"coupled-masses", "closed form: two modes", {1e-11, 1e-10, 1e-9, 1e-9, 1e-10}, coupled_masses},
      {"torsion", "closed form", {1e-10, 1e-9, 1e-8, 1e-8, 1e-9}, torsion},
      {"turning-arms", "closed form: cosh and cos", {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, turning_arms},
      {"free-flight", "closed form", {1e-10, 1e-10, 1e-10, 1e-10, 1e-9}, free_flight},
  };
}

}  // namespace subsoil::cases
