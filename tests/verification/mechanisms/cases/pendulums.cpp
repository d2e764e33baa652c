// Pendulums: one link against elliptic functions, chains and moving pivots against Lagrange's equations in the angles.

#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>

#include "tests/verification/mechanisms/cases/case.hpp"

namespace subsoil::cases {
namespace {

/// A body swinging about the origin, let go at rest at theta_0 from hanging; theta(t) from Jacobi's functions:
/// sin(theta/2) = k cd(w t, k), k = sin(theta_0/2), w^2 = m g d/(I + m d^2).
struct Swing {
  double mass, inertia, arm, theta_0;
  struct State {
    double angle, spin, alpha;
  };
  State at(double t) const {
    const double w2 = mass * g * arm / (inertia + mass * arm * arm), w = std::sqrt(w2), k = std::sin(theta_0 / 2);
    double cn = 0, dn = 0;
    const double sn = boost::math::jacobi_elliptic(k, w * t, &cn, &dn);
    const double theta = 2 * std::asin(k * cn / dn);
    return {theta, -2 * k * w * (1 - k * k) * sn / (dn * dn * std::cos(theta / 2)), -w2 * std::sin(theta)};
  }
  /// Columns of a body whose angle in the scenario is theta + offset.
  Expected columns(const std::string& body, const std::string& pin, double offset, double t) const {
    const State s = at(t);
    const double c = std::cos(s.angle), n = std::sin(s.angle), speed2 = s.spin * s.spin;
    const double ax = arm * (s.alpha * c - speed2 * n), ay = arm * (s.alpha * n + speed2 * c);
    const double kinetic = 0.5 * (inertia + mass * arm * arm) * speed2;
    return {{body + ".x", arm * n},
            {body + ".y", -arm * c},
            {body + ".angle", s.angle + offset},
            {body + ".vx", arm * c * s.spin},
            {body + ".vy", arm * n * s.spin},
            {body + ".spin", s.spin},
            {body + ".ax", ax},
            {body + ".ay", ay},
            {body + ".alpha", s.alpha},
            {pin + ".fx", -mass * ax},
            {pin + ".fy", -mass * (ay + g)},
            {pin + ".moment", 0},
            {"energy.kinetic", kinetic},
            {"energy.potential", -mass * g * arm * c},
            {"energy.balance", 0}};
  }
};

Reference simple_pendulum() {
  return [](double t) {
    return Swing{.mass = 1, .inertia = 1e-12, .arm = 1, .theta_0 = pi / 2}.columns("mass", "pivot", -pi / 2, t);
  };
}

Reference rod_pendulum() {
  return [](double t) {
    return Swing{.mass = 1.5, .inertia = 0.125, .arm = 0.5, .theta_0 = 170 * pi / 180}.columns("rod", "pin", -pi / 2,
                                                                                               t);
  };
}

struct Link {
  std::string name, pin;
  double mass, length;
};

/// Uniform bars one after the other from the origin, all horizontal and at rest at the start.
Mechanism chain_of(const std::vector<Link>& links) {
  Mechanism m;
  double reach = 0;
  int before = world;
  for (const Link& l : links) {
    m.joints.push_back({.kind = Joint::pin, .name = l.pin, .a = before, .b = before + 1, .at = {reach, 0}});
    m.names.push_back(l.name);
    m.mass.push_back(uniform_bar(l.mass, l.length));
    reach += l.length;
    ++before;
  }
  m.start.assign(2 * links.size(), 0.0);
  m.poses = [links](const std::vector<Jet>& q, Jet) {
    std::vector<Pose> poses;
    Point from;
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Point to = from + polar(links[i].length, q[i]);
      const Point middle = 0.5 * (from + to);
      poses.push_back({middle.x, middle.y, q[i]});
      from = to;
    }
    return poses;
  };
  return m;
}

Reference double_pendulum() {
  return minimal(chain_of({{"upper", "shoulder", 1.5, 0.6}, {"lower", "elbow", 0.9, 0.5}}));
}

Reference triple_pendulum() {
  return minimal(chain_of({{"upper", "pin 1", 2, 0.8}, {"middle", "pin 2", 1.5, 0.6}, {"lower", "pin 3", 1, 0.4}}));
}

Reference chain_of_ten() {
  std::vector<Link> links;
  for (int i = 1; i <= 10; ++i) links.push_back({"link " + std::to_string(i), "pin " + std::to_string(i), 0.5, 0.2});
  return minimal(chain_of(links));
}

/// Cart on a rail, spring and damper to a wall at x = -1, a bar hung from the cart.
Reference cart_pendulum() {
  Mechanism m;
  m.names = {"cart", "bar"};
  m.mass = {{3, 3, 0.1}, uniform_bar(1, 0.8)};
  m.start = {0, 0, 0, 0};
  m.poses = [](const std::vector<Jet>& q, Jet) {
    const Point pin{q[0], 0};
    return std::vector<Pose>{{pin.x, pin.y, 0}, bar(pin, pin + polar(0.8, q[1]))};
  };
  m.joints = {{.kind = Joint::slide, .name = "rail", .b = 0}, {.kind = Joint::pin, .name = "pin", .a = 0, .b = 1}};
  m.springs = {{.name = "buffer", .b = 0, .on_a = {-1, 0}, .stiffness = 40, .free_length = 0.9, .damping = 0.8}};
  return minimal(m);
}

/// Kapitza's pendulum: pivot shaken along y by 20 sin(2 pi 40 t) mm, so fast that a bar nearly upright stays up:
/// (a w)^2 = 25.3 (m/s)^2 is more than 2 g (I + m d^2)/(m d) = 5.2.
Reference kapitza() {
  Mechanism m;
  m.names = {"shaker", "bar"};
  m.mass = {{2, 2, 0.01}, uniform_bar(0.3, 0.4)};
  m.start = {0.2, 0};
  m.poses = [](const std::vector<Jet>& q, Jet t) {
    const Point pin{0, 0.02 * sin(80 * pi * t)};
    const Point tip = pin + Point{-0.4 * sin(q[0]), 0.4 * cos(q[0])};
    return std::vector<Pose>{{pin.x, pin.y, 0}, bar(pin, tip)};
  };
  m.joints = {{.kind = Joint::slide, .name = "guide", .b = 0, .angle = pi / 2},
              {.kind = Joint::pin, .name = "pin", .a = 0, .b = 1},
              {.kind = Joint::ram, .name = "exciter", .a = world, .b = 0, .angle = pi / 2}};
  return minimal(m);
}

/// A mass that slides on a bar hung at the origin, on a spring along it.
Reference elastic_pendulum() {
  Mechanism m;
  m.names = {"guide", "bob"};
  m.mass = {{0.4, 0.4, 0.02}, {1, 1, 0.005}};
  m.start = {0, 0.6, 0, 0};
  m.poses = [](const std::vector<Jet>& q, Jet) {
    const Point middle = polar(0.3, q[0]), bob = polar(q[1], q[0]);
    return std::vector<Pose>{{middle.x, middle.y, q[0]}, {bob.x, bob.y, q[0]}};
  };
  m.joints = {{.kind = Joint::pin, .name = "pin", .b = 0},
              {.kind = Joint::slide, .name = "rod", .a = 0, .b = 1, .at = {0.6, 0}}};
  m.springs = {{.name = "spring", .b = 1, .on_b = {0.6, 0}, .stiffness = 90, .free_length = 0.5}};
  return minimal(m);
}

}  // namespace

std::vector<Case> pendulums() {
  return {
      {"simple-pendulum",
       "IFToMM benchmark A01; Jacobi's elliptic functions",
       {1e-10, 1e-9, 1e-8, 1e-8, 1e-9},
       simple_pendulum},
      {"rod-pendulum", "Jacobi's elliptic functions", {1e-9, 1e-9, 1e-8, 1e-8, 1e-9}, rod_pendulum},
      {"double-pendulum", "minimal coordinates", {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, double_pendulum},
      {"triple-pendulum", "minimal coordinates", {1e-9, 1e-8, 1e-6, 1e-6, 1e-8}, triple_pendulum},
      {"chain-of-ten", "minimal coordinates", {1e-9, 1e-8, 1e-6, 1e-6, 1e-8}, chain_of_ten},
      {"cart-pendulum", "minimal coordinates", {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, cart_pendulum},
      {"kapitza", "Kapitza 1951; minimal coordinates", {1e-9, 1e-7, 1e-6, 1e-6, 1e-8}, kapitza},
      {"elastic-pendulum", "minimal coordinates", {1e-9, 1e-8, 1e-7, 1e-7, 1e-9}, elastic_pendulum},
  };
}

}  // namespace subsoil::cases
