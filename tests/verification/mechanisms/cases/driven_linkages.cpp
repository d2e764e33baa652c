// Linkages whose motion is given: positions by intersecting circles and lines, joint and driving forces from free-body
// diagrams.

#include <cmath>

#include "tests/verification/mechanisms/cases/case.hpp"

namespace subsoil::cases {
namespace {

/// Crank 0.1 m at 20 rad/s, rod 0.4 m, piston with a force of 300 sin(2 pi 5 t) N along x.
Reference slider_crank() {
  Mechanism m;
  m.names = {"crank", "rod", "piston"};
  m.mass = {uniform_bar(1.2, 0.1), uniform_bar(0.8, 0.4), {2, 2, 0.01}};
  m.poses = [](const Coordinates&, Jet t) {
    const Point crank = polar(0.1, 20 * t), piston{crank.x + sqrt(0.16 - crank.y * crank.y), 0};
    return Poses{bar({}, crank), bar(crank, piston), {piston.x, piston.y, 0}};
  };
  m.joints = {{.kind = Joint::pin, .name = "main bearing", .b = 0},
              {.kind = Joint::pin, .name = "crank pin", .a = 0, .b = 1, .at = {0.1, 0}},
              {.kind = Joint::pin, .name = "wrist pin", .a = 1, .b = 2, .at = {0.5, 0}},
              {.kind = Joint::slide, .name = "cylinder", .b = 2, .at = {0.5, 0}},
              {.kind = Joint::motor, .name = "motor", .b = 0}};
  m.loads = [](double t, const Motion&, Triples& f) { f[2][0] += 300 * std::sin(10 * pi * t); };
  return minimal(m);
}

/// Crank-rocker: 0.2, 0.5, 0.45 m on a base of 0.4 m, crank at 7 rad/s.
Reference four_bar() {
  Mechanism m;
  m.names = {"crank", "coupler", "rocker"};
  m.mass = {uniform_bar(1, 0.15), uniform_bar(2.5, 0.5), uniform_bar(1.8, 0.45)};
  m.poses = [](const Coordinates&, Jet t) {
    const Point a = polar(0.15, 7 * t + pi / 2), d{0.4, 0}, b = meet(a, 0.5, d, 0.45, 1);
    return Poses{bar({}, a), bar(a, b), bar(d, b)};
  };
  m.joints = {{.kind = Joint::pin, .name = "A0", .b = 0},
              {.kind = Joint::pin, .name = "A", .a = 0, .b = 1, .at = {0, 0.15}},
              {.kind = Joint::pin, .name = "B", .a = 1, .b = 2, .at = {0.4, 0.45}},
              {.kind = Joint::pin, .name = "B0", .b = 2, .at = {0.4, 0}},
              {.kind = Joint::motor, .name = "motor", .b = 0}};
  return minimal(m);
}

/// Whitworth's quick return: the crank's block slides in a lever, whose tip draws a ram by a link.
Reference quick_return() {
  Mechanism m;
  m.names = {"crank", "block", "lever", "link", "ram"};
  m.mass = {uniform_bar(1, 0.1), {0.3, 0.3, 0.0004}, uniform_bar(2, 0.55), uniform_bar(0.6, 0.3), {3, 3, 0.05}};
  m.poses = [](const Coordinates&, Jet t) {
    const Point pin = polar(0.1, 10 * t + pi / 2), pivot{0, -0.25};
    const Jet turn = direction(pivot, pin);
    const Point tip = pivot + polar(0.55, turn);
    const Jet rise = 0.3 - tip.y;
    const Point ram{tip.x + sqrt(0.09 - rise * rise), 0.3};
    return Poses{bar({}, pin), {pin.x, pin.y, turn}, bar(pivot, tip), bar(tip, ram), {ram.x, ram.y, 0}};
  };
  m.joints = {{.kind = Joint::pin, .name = "bearing", .b = 0},
              {.kind = Joint::pin, .name = "crank pin", .a = 0, .b = 1, .at = {0, 0.1}},
              {.kind = Joint::slide, .name = "slot", .a = 2, .b = 1, .at = {0, 0.1}, .angle = pi / 2},
              {.kind = Joint::pin, .name = "lever pivot", .b = 2, .at = {0, -0.25}},
              {.kind = Joint::pin, .name = "lever tip", .a = 2, .b = 3, .at = {0, 0.3}},
              {.kind = Joint::pin, .name = "ram pin", .a = 3, .b = 4, .at = {0.3, 0.3}},
              {.kind = Joint::slide, .name = "guide", .b = 4, .at = {0.3, 0.3}},
              {.kind = Joint::motor, .name = "motor", .b = 0}};
  return minimal(m);
}

/// Scotch yoke: x = 0.08 cos(12 t).
Reference scotch_yoke() {
  Mechanism m;
  m.names = {"crank", "block", "yoke"};
  m.mass = {uniform_bar(0.5, 0.08), {0.2, 0.2, 0.0001}, {2, 2, 0.02}};
  m.poses = [](const Coordinates&, Jet t) {
    const Point pin = polar(0.08, 12 * t);
    return Poses{bar({}, pin), {pin.x, pin.y, 0}, {pin.x + 0.1, 0, 0}};
  };
  m.joints = {{.kind = Joint::pin, .name = "bearing", .b = 0},
              {.kind = Joint::pin, .name = "crank pin", .a = 0, .b = 1, .at = {0.08, 0}},
              {.kind = Joint::slide, .name = "slot", .a = 2, .b = 1, .at = {0.08, 0}, .angle = pi / 2},
              {.kind = Joint::slide, .name = "guide", .b = 2, .at = {0.18, 0}},
              {.kind = Joint::motor, .name = "motor", .b = 0}};
  return minimal(m);
}

/// Toggle press: a crank pulls the knee of two links of 0.3 m; the ram works against a spring.
Reference toggle_press() {
  Mechanism m;
  m.names = {"crank", "rod", "upper link", "lower link", "ram"};
  m.mass = {uniform_bar(1.5, 0.06), uniform_bar(1, 0.32), uniform_bar(2, 0.3), uniform_bar(2, 0.3), {8, 8, 0.1}};
  m.poses = [](const Coordinates&, Jet t) {
    const Point pin = Point{0.44, -0.24} + polar(0.06, 4 * t), knee = meet({}, 0.3, pin, 0.32, -1);
    const Point ram{0, knee.y - sqrt(0.09 - knee.x * knee.x)};
    return Poses{bar({0.44, -0.24}, pin), bar(pin, knee), bar({}, knee), bar(knee, ram), {ram.x, ram.y, 0}};
  };
  m.joints = {{.kind = Joint::pin, .name = "bearing", .b = 0, .at = {0.44, -0.24}},
              {.kind = Joint::pin, .name = "crank pin", .a = 0, .b = 1, .at = {0.5, -0.24}},
              {.kind = Joint::pin, .name = "knee 1", .a = 1, .b = 2, .at = {0.18, -0.24}},
              {.kind = Joint::pin, .name = "knee 2", .a = 2, .b = 3, .at = {0.18, -0.24}},
              {.kind = Joint::pin, .name = "head", .b = 2},
              {.kind = Joint::pin, .name = "ram pin", .a = 3, .b = 4, .at = {0, -0.48}},
              {.kind = Joint::slide, .name = "guide", .b = 4, .at = {0, -0.48}, .angle = pi / 2},
              {.kind = Joint::motor, .name = "motor", .b = 0}};
  m.springs = {{.name = "work",
                .b = 4,
                .on_a = {0, -0.8},
                .on_b = {0, -0.48},
                .stiffness = 50000,
                .free_length = 0.32,
                .damping = 100}};
  return minimal(m);
}

/// Peaucellier and Lipkin's inversor: the crank of 0.165 m swings by 0.9 rad, the pen draws the line x = 0.63 m, since
/// OA OP = L^2 - s^2 for arms L = 0.52 m and rhombus sides s = 0.25 m.
Reference peaucellier() {
  Mechanism m;
  m.names = {"crank", "upper arm", "lower arm", "inner upper", "inner lower", "outer upper", "outer lower", "pen"};
  m.mass = {uniform_bar(0.3, 0.165)};
  for (int i = 0; i < 2; ++i) m.mass.push_back(uniform_bar(0.8, 0.52));
  for (int i = 0; i < 4; ++i) m.mass.push_back(uniform_bar(0.4, 0.25));
  m.mass.push_back({0.1, 0.1, 0.0001});
  m.poses = [](const Coordinates&, Jet t) {
    const Point centre{0.165, 0}, a = centre + polar(0.165, 0.9 * sin(pi * t));
    const Jet stretch = 0.2079 / (a.x * a.x + a.y * a.y);
    const Point p = stretch * a, up = meet({}, 0.52, p, 0.25, 1), down = meet({}, 0.52, p, 0.25, -1);
    return Poses{bar(centre, a), bar({}, up), bar({}, down), bar(a, up),
                 bar(a, down),   bar(up, p),  bar(down, p),  {p.x, p.y, direction(up, p)}};
  };
  const auto pin = [&](const char* name, int a, int b, double x, double y) {
    m.joints.push_back({.kind = Joint::pin, .name = name, .a = a, .b = b, .at = {x, y}});
  };
  pin("C", world, 0, 0.165, 0), pin("O upper", world, 1, 0, 0), pin("O lower", world, 2, 0, 0);
  pin("A upper", 0, 3, 0.33, 0), pin("A lower", 0, 4, 0.33, 0);
  pin("B inner", 1, 3, 0.48, 0.2), pin("B outer", 1, 5, 0.48, 0.2);
  pin("D inner", 2, 4, 0.48, -0.2), pin("D outer", 2, 6, 0.48, -0.2), pin("P", 5, 6, 0.63, 0);
  m.joints.push_back({.kind = Joint::weld, .name = "pen holder", .a = 5, .b = 7, .at = {0.63, 0}});
  m.joints.push_back({.kind = Joint::motor, .name = "motor", .b = 0});
  const Reference whole = minimal(m);
  return [whole](double t) {
    Expected out = whole(t);
    out.insert(out.end(), {{"pen.x", 0.63}, {"pen.vx", 0}});  // the straight line, beside the closed form
    return out;
  };
}

/// Watt's six-bar: a crank-rocker whose rocker drives a second one.
Reference watt() {
  Mechanism m;
  m.names = {"crank", "coupler", "rocker", "second coupler", "output"};
  m.mass = {uniform_bar(1, 0.15), uniform_bar(2, 0.5), {3, 3, 0.08}, uniform_bar(1.5, 0.5), uniform_bar(2, 0.6)};
  m.poses = [](const Coordinates&, Jet t) {
    const Point a = polar(0.15, 6 * t + pi / 2), pivot{0.4, 0}, b = meet(a, 0.5, pivot, 0.45, 1);
    const Jet turn = direction(pivot, b) - pi / 2;
    // The ternary rocker is upright at the start: its corners are (0, 0.45) and (0.3, 0.4), its centre (0.1, 0.25).
    const Point c = pivot + Point{0.3 * cos(turn) - 0.4 * sin(turn), 0.3 * sin(turn) + 0.4 * cos(turn)};
    const Point base{1.1, 0.1}, d = meet(c, 0.5, base, 0.6, 1);
    return Poses{bar({}, a), bar(a, b), body_at(pivot, turn, 0.1, 0.25), bar(c, d), bar(base, d)};
  };
  m.joints = {{.kind = Joint::pin, .name = "A0", .b = 0},
              {.kind = Joint::pin, .name = "A", .a = 0, .b = 1, .at = {0, 0.15}},
              {.kind = Joint::pin, .name = "B", .a = 1, .b = 2, .at = {0.4, 0.45}},
              {.kind = Joint::pin, .name = "B0", .b = 2, .at = {0.4, 0}},
              {.kind = Joint::pin, .name = "C", .a = 2, .b = 3, .at = {0.7, 0.4}},
              {.kind = Joint::pin, .name = "D", .a = 3, .b = 4, .at = {1.1, 0.7}},
              {.kind = Joint::pin, .name = "D0", .b = 4, .at = {1.1, 0.1}},
              {.kind = Joint::motor, .name = "motor", .b = 0}};
  return minimal(m);
}

/// Theo Jansen's leg: eleven bars, two of them triangles, on one crank; four dyads one after the other.
Reference jansen_leg() {
  Mechanism m;
  m.names = {"crank", "upper rod", "lower rod", "shoulder", "inner link", "outer link", "foot"};
  m.mass = {uniform_bar(0.6, 0.15),  uniform_bar(1, 0.5),     uniform_bar(1.2, 0.619), {2, 2, 0.04},
            uniform_bar(0.8, 0.393), uniform_bar(0.8, 0.394), {2.5, 2.5, 0.06}};
  m.poses = [](const Coordinates&, Jet t) {
    const Point x = polar(0.15, 5 * t), y{-0.38, -0.078};
    const Point v = meet(x, 0.5, y, 0.415, -1), w = meet(x, 0.619, y, 0.393, 1), u = meet(v, 0.558, y, 0.401, -1);
    const Point foot_t = meet(u, 0.394, w, 0.367, -1), tip = meet(foot_t, 0.657, w, 0.49, -1);
    const Point upper = Jet(1.0 / 3) * (y + v + u), lower = Jet(1.0 / 3) * (w + foot_t + tip);
    return Poses{bar({}, x),
                 bar(x, v),
                 bar(x, w),
                 {upper.x, upper.y, direction(y, v)},
                 bar(y, w),
                 bar(u, foot_t),
                 {lower.x, lower.y, direction(w, foot_t)}};
  };
  const Place x{0.15, 0}, y{-0.38, -0.078}, v{-0.24013535097127791, 0.31272097454842681},
      w{-0.2695210703157296, -0.45515170170081168}, u{-0.74794365380936053, 0.081431702058961433},
      t{-0.59231514961415004, -0.28052930230747767};
  const auto pin = [&](const char* name, int a, int b, Place at) {
    m.joints.push_back({.kind = Joint::pin, .name = name, .a = a, .b = b, .at = at});
  };
  pin("bearing", world, 0, {}), pin("crank upper", 0, 1, x), pin("crank lower", 0, 2, x), pin("V", 1, 3, v);
  pin("Y upper", world, 3, y), pin("Y lower", world, 4, y), pin("W rod", 2, 4, w), pin("W foot", 4, 6, w);
  pin("U", 3, 5, u), pin("T", 5, 6, t);
  m.joints.push_back({.kind = Joint::motor, .name = "motor", .b = 0});
  return minimal(m);
}

/// Pantograph of scale 2: the tracer follows a Lissajous figure, the pen draws it twice as large.
Reference pantograph() {
  Mechanism m;
  m.names = {"first arm", "second arm", "left bar", "right bar", "tracer", "pen"};
  m.mass = {uniform_bar(1, 1),     uniform_bar(1, 1),  uniform_bar(0.5, 0.5),
            uniform_bar(0.5, 0.5), {0.2, 0.2, 0.0002}, {0.3, 0.3, 0.0003}};
  m.poses = [](const Coordinates&, Jet t) {
    const Point tracer{0.8 + 0.1 * sin(2 * pi * t), 0.15 * sin(4 * pi * t)}, pen = 2 * tracer;
    const Point top = meet({}, 1, pen, 1, 1), left = 0.5 * top, right = 0.5 * (top + pen);
    return Poses{bar({}, top),
                 bar(top, pen),
                 bar(left, tracer),
                 bar(tracer, right),
                 {tracer.x, tracer.y, direction(left, tracer)},
                 {pen.x, pen.y, direction(top, pen)}};
  };
  m.joints = {{.kind = Joint::pin, .name = "O", .b = 0},
              {.kind = Joint::pin, .name = "top", .a = 0, .b = 1, .at = {0.8, 0.6}},
              {.kind = Joint::pin, .name = "left", .a = 0, .b = 2, .at = {0.4, 0.3}},
              {.kind = Joint::pin, .name = "right", .a = 1, .b = 3, .at = {1.2, 0.3}},
              {.kind = Joint::pin, .name = "middle", .a = 2, .b = 3, .at = {0.8, 0}},
              {.kind = Joint::weld, .name = "tracer holder", .a = 2, .b = 4, .at = {0.8, 0}},
              {.kind = Joint::weld, .name = "pen holder", .a = 1, .b = 5, .at = {1.6, 0}},
              {.kind = Joint::ram, .name = "drive x", .b = 4, .at = {0.8, 0}},
              {.kind = Joint::ram, .name = "drive y", .b = 4, .at = {0.8, 0}, .angle = pi / 2}};
  return minimal(m);
}

/// 10 x^3 - 15 x^4 + 6 x^5 between two times.
Jet smooth(const Jet& t, double begin, double end) {
  const Jet x = (t - begin) / (end - begin);
  if (x.v <= 0) return 0;
  if (x.v >= 1) return 1;
  return x * x * x * (10 - x * (15 - 6 * x));
}

/// A boom raised by a cylinder whose length grows from 0.8 m to 1.2 m by a smooth ramp; law of cosines.
Reference cylinder_boom() {
  Mechanism m;
  m.names = {"boom", "barrel", "piston"};
  m.mass = {{120, 120, 45}, {20, 20, 1.5}, {12, 12, 1}};
  m.poses = [](const Coordinates&, Jet t) {
    const Jet length = 0.8 + 0.4 * smooth(t, 0.25, 1.75), cosine = (0.36 + 1 - length * length) / 1.2;
    const Point foot{0.6, -0.8};
    const Jet turn = direction({}, foot) + atan2(sqrt(1 - cosine * cosine), cosine);
    const Point eye = polar(0.6, turn);
    const Jet along = direction(foot, eye);
    return Poses{body_at({}, turn, 0.9), body_at(foot, along, 0.25), body_at(eye, along, -0.25)};
  };
  m.joints = {{.kind = Joint::pin, .name = "pivot", .b = 0},
              {.kind = Joint::pin, .name = "foot", .b = 1, .at = {0.6, -0.8}},
              {.kind = Joint::pin, .name = "eye", .a = 0, .b = 2, .at = {0.6, 0}},
              {.kind = Joint::slide, .name = "bore", .a = 1, .b = 2, .at = {0.6, -0.4}, .angle = pi / 2},
              {.kind = Joint::ram, .name = "cylinder", .a = 1, .b = 2, .at = {0.6, -0.4}, .angle = pi / 2}};
  return minimal(m);
}

}  // namespace

std::vector<Case> driven_linkages() {
  // Positions are solved to 1e-13 of the length in every step; singular values of a linkage magnify that by up to 1e2,
  // and each derivative by the rates of its links, up to 20 rad/s. The energy balance has the driver's work of order 6.
  const Bounds kinematic{1e-11, 1e-10, 1e-9, 1e-8, 1e-7};
  const std::string closed = "closed-form positions, free-body diagrams";
  return {
      {"slider-crank", closed, kinematic, slider_crank},
      {"four-bar", "Freudenstein's linkage; " + closed, kinematic, four_bar},
      {"quick-return", "Whitworth; " + closed, kinematic, quick_return},
      {"scotch-yoke", closed, kinematic, scotch_yoke},
      {"toggle-press", closed, kinematic, toggle_press},
      {"peaucellier", "Peaucellier-Lipkin inversor; " + closed, kinematic, peaucellier},
      {"watt-six-bar", closed, kinematic, watt},
      {"jansen-leg", "T. Jansen's leg; " + closed, kinematic, jansen_leg},
      {"pantograph", closed, kinematic, pantograph},
      {"cylinder-boom", "law of cosines; " + closed, kinematic, cylinder_boom},
  };
}

}  // namespace subsoil::cases
