// Linkages of one freedom that move by themselves: Lagrange's equation in one angle, positions in closed form.

#include <cmath>

#include "tests/verification/mechanisms/cases/case.hpp"

namespace subsoil::cases {
namespace {

/// Trammel of Archimedes: a rod of 1 m between blocks on the axes, let go from the 3-4-5 triangle.
Reference trammel() {
  Mechanism m;
  m.names = {"rod", "floor block", "wall block"};
  m.mass = {uniform_bar(2, 1), {0.5, 0.5, 0.001}, {0.7, 0.7, 0.001}};
  m.start = {std::atan2(0.8, 0.6), 0};
  m.poses = [](const Coordinates& q, Jet) {
    const Jet x = cos(q[0]), y = sin(q[0]);
    return Poses{{0.5 * x, 0.5 * y, -q[0]}, {x, 0, 0}, {0, y, 0}};
  };
  m.joints = {{.kind = Joint::slide, .name = "floor", .b = 1, .at = {0.6, 0}},
              {.kind = Joint::slide, .name = "wall", .b = 2, .at = {0, 0.8}, .angle = pi / 2},
              {.kind = Joint::pin, .name = "floor pin", .a = 0, .b = 1, .at = {0.6, 0}},
              {.kind = Joint::pin, .name = "wall pin", .a = 0, .b = 2, .at = {0, 0.8}}};
  return minimal(m);
}

/// Crank-rocker on springs: one from the coupler's middle to the ground, one torsional with damping at the rocker.
Reference sprung_four_bar() {
  Mechanism m;
  m.names = {"crank", "coupler", "rocker"};
  m.mass = {uniform_bar(1, 0.15), uniform_bar(2.5, 0.5), uniform_bar(1.8, 0.45)};
  m.start = {pi / 2, 0};
  m.poses = [](const Coordinates& q, Jet) {
    const Point a = polar(0.15, q[0]), d{0.4, 0}, b = meet(a, 0.5, d, 0.45, 1);
    return Poses{bar({}, a), bar(a, b), bar(d, b)};
  };
  m.joints = {{.kind = Joint::pin, .name = "A0", .b = 0},
              {.kind = Joint::pin, .name = "A", .a = 0, .b = 1, .at = {0, 0.15}},
              {.kind = Joint::pin, .name = "B", .a = 1, .b = 2, .at = {0.4, 0.45}},
              {.kind = Joint::pin, .name = "B0", .b = 2, .at = {0.4, 0}}};
  m.springs = {{.name = "spring",
                .b = 1,
                .on_a = {-0.4, 0.3},
                .on_b = {0.2, 0.3},
                .stiffness = 300,
                .free_length = 0.5,
                .damping = 2}};
  m.loads = [](double, const Motion& now, Triples& f) {
    f[2][2] -= 20 * (now.pose[2][2] - pi / 2) + 0.2 * now.velocity[2][2];
  };
  return minimal(m);
}

/// Stephenson's six-bar (type III): a coupler point of a four-bar drives a dyad; 2 N m on the crank.
Reference stephenson() {
  Mechanism m;
  m.names = {"crank", "coupler", "rocker", "link", "output"};
  m.mass = {uniform_bar(1, 0.2), {3, 3, 0.2}, uniform_bar(2, 0.65), uniform_bar(1.2, 0.6), uniform_bar(1.4, 0.6)};
  m.start = {pi / 2, 0};
  m.poses = [](const Coordinates& q, Jet) {
    const Point a = polar(0.2, q[0]), pivot{0.6, 0}, b = meet(a, 0.75, pivot, 0.65, 1);
    // In the start pose the coupler goes from (0, 0.2) to (0.6, 0.65); its point P is at (0.2, 0.6), its centre at
    // (0.25, 0.5).
    const Jet turn = direction(a, b) - std::atan2(0.45, 0.6);
    const Point p = a + Point{0.2 * cos(turn) - 0.4 * sin(turn), 0.2 * sin(turn) + 0.4 * cos(turn)};
    const Point base{0.68, 0.36}, d = meet(p, 0.6, base, 0.6, 1);
    return Poses{bar({}, a), body_at(a, turn, 0.25, 0.3), bar(pivot, b), bar(p, d), bar(base, d)};
  };
  m.joints = {{.kind = Joint::pin, .name = "A0", .b = 0},
              {.kind = Joint::pin, .name = "A", .a = 0, .b = 1, .at = {0, 0.2}},
              {.kind = Joint::pin, .name = "B", .a = 1, .b = 2, .at = {0.6, 0.65}},
              {.kind = Joint::pin, .name = "B0", .b = 2, .at = {0.6, 0}},
              {.kind = Joint::pin, .name = "P", .a = 1, .b = 3, .at = {0.2, 0.6}},
              {.kind = Joint::pin, .name = "Q", .a = 3, .b = 4, .at = {0.68, 0.96}},
              {.kind = Joint::pin, .name = "Q0", .b = 4, .at = {0.68, 0.36}}};
  m.loads = [](double, const Motion&, Triples& f) { f[0][2] += 2; };
  return minimal(m);
}

/// N four-bar windows in a row, N = 2: cranks upright at the start, their tips at 1 m/s. The cranks stay parallel.
Reference windows() {
  Mechanism m;
  m.names = {"crank 0", "crank 1", "crank 2", "coupler 1", "coupler 2"};
  m.mass.assign(5, uniform_bar(1, 1));
  m.start = {pi / 2, -1};
  m.poses = [](const Coordinates& q, Jet) {
    const Point tip = polar(1, q[0]);
    Poses poses;
    for (int i = 0; i < 3; ++i) {
      const Point foot{static_cast<double>(i), 0};
      poses.push_back(bar(foot, foot + tip));
    }
    for (int i = 0; i < 2; ++i) poses.push_back({tip.x + (i + 0.5), tip.y, 0});
    return poses;
  };
  return minimal(m);
}

}  // namespace

std::vector<Case> free_linkages() {
  const std::string lagrange = "Lagrange's equation in one angle";
  // Beside each flat pose, at 1e-3 rad for a step of 0.25 ms, rounding of 1e-16 is 1e-7 rad/s^2 of an acceleration
  // that does no work on the motion; twenty passes leave their share in the phase.
  const Bounds flat_poses{1e-8, 1e-7, 1e-6, 1e-6, 1e-8};
  return {
      {"trammel", lagrange, {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, trammel},
      {"sprung-four-bar", lagrange, {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, sprung_four_bar},
      {"stephenson-six-bar", lagrange, {1e-9, 1e-7, 1e-5, 1e-5, 1e-7}, stephenson},
      {"windows", "IFToMM benchmark A02 with N = 2; " + lagrange, flat_poses, windows, true},
  };
}

}  // namespace subsoil::cases
