// Elements beside pins and slides: gears, rolling, a cam, links and slots, a bushing, drag, stops, friction that
// sticks.

#include <Eigen/Dense>
#include <boost/math/special_functions/lambert_w.hpp>
#include <cmath>

#include "tests/verification/mechanisms/cases/case.hpp"
#include "tests/verification/mechanisms/cases/oscillation.hpp"
#include "tests/verification/mechanisms/sledge.hpp"

namespace subsoil::cases {
namespace {

/// The first gear with a quarter of the second's inertia and spring, T = 2 N m: (T/k)(1 - cos(w t)). The rack with
/// I/R^2 of the pinion: (v/w) sin(w t). Tooth forces from the balance of the first gear and of the rack.
Reference gears_and_rack() {
  return [](double t) {
    const double torque = 2, k = 30. / 4, inertia = 0.04 + 0.3 / 4, w = std::sqrt(k / inertia);
    const State first{torque / k * (1 - std::cos(w * t)), torque / k * w * std::sin(w * t),
                      torque / inertia * std::cos(w * t)};
    const double p = std::sqrt(400 / (4 + 0.02 / 0.0025));
    const State rack{0.5 / p * std::sin(p * t), 0.5 * std::cos(p * t), -0.5 * p * std::sin(p * t)};
    Expected out;
    add(out, "first", "angle", 0, first);
    add(out, "second", "angle", 0, {-first[0] / 2, -first[1] / 2, -first[2] / 2});
    add(out, "rack", "x", 0, rack);
    add(out, "pinion", "angle", 0, {rack[0] / 0.05, rack[1] / 0.05, rack[2] / 0.05});
    out.push_back({"mesh.fy", (0.04 * first[2] - torque) / 0.1});
    out.push_back({"teeth.fx", 4 * rack[2] + 400 * rack[0]});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// Down the slope a = g sin/(1 + I/(m R^2)); the ground takes the normal force and m (g sin - a) of friction_force.
Reference rolling_disk() {
  return [](double t) {
    const double m = 2, r = 0.2, a = g * 0.6 / 1.5, s = a * t * t / 2, normal = m * g * 0.8,
                 friction_force = m * (g * 0.6 - a);
    Expected out;
    add(out, "disk", "x", 0.12, {0.8 * s, 0.8 * a * t, 0.8 * a});
    add(out, "disk", "y", 0.16, {-0.6 * s, -0.6 * a * t, -0.6 * a});
    add(out, "disk", "angle", 0, {-s / r, -a * t / r, -a / r});
    out.push_back({"slope.fx", -(0.6 * normal - 0.8 * friction_force)});
    out.push_back({"slope.fy", -(0.8 * normal + 0.6 * friction_force)});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

Reference rolling_in_bowl() {
  Mechanism m;
  m.names = {"disk"};
  m.mass = {{1.5, 1.5, 0.0075}};
  m.start = {0, 0};
  m.poses = [](const Coordinates& q, Jet) { return Poses{{0.5 * cos(q[0]), 0.5 * sin(q[0]), -5 * q[0]}}; };
  return minimal(m);
}

/// The periodic cubic spline through equal steps: its second derivatives solve M_{i-1} + 4 M_i + M_{i+1} = 6 d2y/h^2.
State profile(double angle) {
  constexpr int n = 24;
  const double h = 2 * pi / n;
  const auto radius = [&](int i) { return 0.06 + 0.015 * std::cos(h * i) + 0.004 * std::cos(2 * h * i + 0.5); };
  static const Eigen::VectorXd second = [&] {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b(n);
    for (int i = 0; i < n; ++i) {
      a(i, i) = 4, a(i, (i + 1) % n) += 1, a(i, (i + n - 1) % n) += 1;
      b[i] = 6 * (radius(i + 1) - 2 * radius(i) + radius(i - 1)) / (h * h);
    }
    return Eigen::VectorXd(a.partialPivLu().solve(b));
  }();
  const double turns = angle / (2 * pi), at = (turns - std::floor(turns)) * n;
  const int i = static_cast<int>(at) % n;
  const double u = at - i, v = 1 - u, low = second[i], high = second[(i + 1) % n], rise = radius(i + 1) - radius(i);
  return {v * radius(i) + u * radius(i + 1) + h * h / 6 * ((v * v * v - v) * low + (u * u * u - u) * high),
          rise / h + h / 6 * ((1 - 3 * v * v) * low + (3 * u * u - 1) * high), v * low + u * high};
}

/// Over the cam the follower's height is the radius at pi/2 - w t; the motor gives what lifts it.
Reference cam() {
  return [](double t) {
    const double w = 9, m = 0.8;
    const State p = profile(pi / 2 - w * t);
    Expected out;
    add(out, "follower", "y", 0, {p[0], -w * p[1], w * w * p[2]});
    add(out, "cam", "angle", 0, {w * t, w, 0});
    out.push_back({"motor.torque", -m * (g + w * w * p[2]) * p[1]});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

Reference links_and_slots() {
  Mechanism m;
  m.names = {"rod", "bob"};
  m.mass = {uniform_bar(2, 1), {1.2, 1.2, 0.02}};
  m.start = {std::atan2(0.8, 0.6), 0, 0, 0};
  m.poses = [](const Coordinates& q, Jet t) {
    return Poses{{0.5 * cos(q[0]), 0.5 * sin(q[0]), -q[0]}, {2 + 0.8 * cos(q[1]), 0.8 * sin(q[1]), 3 * t}};
  };
  return minimal(m);
}

Reference bushing() {
  return [](double t) {
    const double m = 2, sag = m * g / 1250;
    const State x = free_oscillation(m, 8, 800, 0, 0.5, t), y = free_oscillation(m, 0, 1250, sag, 0, t),
                turn = free_oscillation(0.05, 0.1, 20, 0, 3, t);
    Expected out;
    add(out, "block", "x", 0, x);
    add(out, "block", "y", -sag, y);
    add(out, "block", "angle", 0, turn);
    out.push_back({"mount.force x", -800 * x[0] - 8 * x[1]});
    out.push_back({"mount.force y", -1250 * (y[0] - sag)});
    out.push_back({"mount.torque", -20 * turn[0] - 0.1 * turn[1]});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// v = -V tanh(g t/V), V = sqrt(m g/c); the spin fades with b/I.
Reference drag() {
  return [](double t) {
    const double end = std::sqrt(3 * g / 0.5), v = std::tanh(g * t / end), rate = 0.03 / 0.02,
                 fade = std::exp(-rate * t);
    Expected out;
    add(out, "body", "y", 0, {-end * end / g * std::log(std::cosh(g * t / end)), -end * v, -g * (1 - v * v)});
    add(out, "body", "angle", 0, {8 / rate * (1 - fade), 8 * fade, -8 * rate * fade});
    out.push_back({"energy.balance", 0});
    return out;
  };
}

/// Speed after an impact at v: with y = 1 + b v, x = 1 - b v_o and x - ln x = y - ln y, so x = -W_0(-y exp(-y)).
double rebound_speed(double b, double v) {
  const double y = 1 + b * v;
  return (1 + boost::math::lambert_w0(-y * std::exp(-y))) / b;
}

/// Before and after the impact, which is over 50 ms after the touch at 1/3 s: half a period of 16 and 20 ms.
Reference rebound() {
  return [](double t) {
    const double v = 1.5, linear = rebound_speed(0.3, v), square = rebound_speed(0.5, v);
    Expected out{{"energy.balance", 0}};
    const bool before = t < 0.5 / v;
    if (!before && t < 0.5 / v + 0.05) return out;
    out.push_back({"linear.vx", before ? v : -linear});
    out.push_back({"square.vx", before ? v : -square});
    out.push_back({"energy.lost", before ? 0 : 2 * v * v - linear * linear - square * square});
    return out;
  };
}

Reference sticking_sledge() {
  return [sledge = std::make_shared<test::Sledge>()](double t) {
    sledge->run(t);
    const double kinetic = 2 * sledge->v * sledge->v;
    return Expected{
        {"block.x", sledge->x}, {"block.vx", sledge->v}, {"energy.kinetic", kinetic}, {"energy.balance", 0}};
  };
}

/// Free fall by h, half a swing and more about the rope's load on m g, up again, and so on.
Reference bungee() {
  return [](double t) {
    constexpr double m = 80, k = 400, h = 9, sag = m * g / k;
    const double fall = std::sqrt(2 * h / g), w = std::sqrt(k / m), v = g * fall, a = std::hypot(sag, v / w),
                 phase = std::asin(sag / a), caught = (pi + 2 * phase) / w;
    const double s = std::fmod(t, 2 * fall + caught);
    Expected out{{"energy.balance", 0}};
    const bool on_rope = s > fall && s < fall + caught;
    const double up = s < fall ? s : s - 2 * fall - caught, angle = w * (s - fall) - phase;
    const double speed = on_rope ? -a * w * std::cos(angle) : -g * up;
    out.push_back({"jumper.y", on_rope ? -h - sag - a * std::sin(angle) : -g * up * up / 2});
    out.push_back({"jumper.vy", speed});
    out.push_back({"energy.kinetic", m * speed * speed / 2});
    return out;
  };
}

/// Sliding: v = v_0 - mu g t, spin = -2 mu g t/r; from t = v_0/(3 mu g) it rolls at 2 v_0/3. Left out: 0.1 s until it
/// lies still on the elastic lane, and the instants at which friction, rounded over 1 mm/s of slip, is not mu N.
Reference slide_to_roll() {
  return [](double t) {
    constexpr double v = 2, mu = 0.2, r = 0.1, rolls = v / (3 * mu * g);
    Expected out{{"energy.balance", 0}};
    const bool slides = t < rolls;
    if (t < 0.1 || std::abs(t - rolls) < 0.02) return out;
    out.push_back({"disk.vx", slides ? v - mu * g * t : 2 * v / 3});
    out.push_back({"disk.spin", slides ? -2 * mu * g * t / r : -2 * v / (3 * r)});
    out.push_back({"disk.ax", slides ? -mu * g : 0});
    return out;
  };
}

}  // namespace

std::vector<Case> elements() {
  return {
      {"gears-and-rack", "closed form: reflected inertia", {1e-10, 1e-9, 1e-8, 1e-8, 1e-9}, gears_and_rack},
      {"rolling-disk", "closed form", {1e-10, 1e-10, 1e-10, 1e-9, 1e-9}, rolling_disk},
      {"rolling-in-bowl", "Lagrange's equation in one angle", {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, rolling_in_bowl},
      // The driver's work is summed across the spline's knots, where the slope of its torque jumps: 9e-8 J at 0.5 ms,
      // 7e-9 and 2e-9 J at a half and a quarter of it.
      {"cam", "periodic cubic spline by dense elimination", {1e-11, 1e-10, 1e-9, 1e-8, 2e-7}, cam},
      {"links-and-slots", "Lagrange's equation in two angles", {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, links_and_slots},
      {"bushing", "closed form: three oscillators", {1e-10, 1e-9, 1e-7, 1e-7, 1e-9}, bushing},
      {"drag", "closed form: tanh and exp", {1e-10, 1e-10, 1e-9, 1e-9, 1e-9}, drag},
      {"rebound", "closed form of Hunt and Crossley's restitution (Lambert's W)", {1e-9, 1e-8, 1, 1, 1e-8}, rebound},
      {"bungee", "closed form from each change to the next", {1e-9, 1e-8, 1, 1, 1e-6}, bungee},
      {"slide-to-roll", "closed form: Coulomb's sliding, then rolling", {1, 1e-9, 1e-6, 1, 1e-8}, slide_to_roll},
      {"sticking-sledge", "closed form from each change to the next", {1e-9, 1e-8, 1, 1, 1e-8}, sticking_sledge},
  };
}

}  // namespace subsoil::cases
