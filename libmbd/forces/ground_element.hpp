#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "libmbd/base/plastic_stiffness.hpp"
#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/hunt_crossley.hpp"

namespace subsoil::mbd {

/// Ground under the impact of a body's point, wheel or stamp: a follower mass on a plastic spring, with a rut.
///   F_s = m_b a + F,  F(z) = K'(z, v, m) z                                                             (N)
///   on ground not yet pressed so deep:  F = F(z) clamp(1 + b z', 0, 1)
///   below the rut's depth z_p:  F = clamp(F_el (1 + b z'), 0, F(z_p)),  F_el = max(0, F(z_p) - q K'(z_p) (z_p - z))
/// z sinkage of the lowest point, z' its rate; v speed of approach at first touch; m mass that strikes. Nothing is
/// recovered but what the unloading stiffness q K' gives back, F^2/(2 q K') at most, and its damping b keeps the body
/// from leaving faster than 1/b: q -> infinity is the source's ground, on which a body could not come to rest.
///
/// The follower, m_b = share of m, is a body of its own that slides along y; it is made beside the force (see
/// add_followers) and rests until struck. Stamp and follower meet in a stiff Hunt-Crossley contact, damped so that they
/// stay together (restitution 1/50 for the source's 0): of (m/2) v^2 the part m_b/(m + m_b) is lost there. The
/// follower's weight is carried by the ground before. Share 0 leaves the spring alone: the choice for wheels that roll,
/// whose ground is new at each place. Acts along y only: rolling resistance is not in this model.
///
/// Rut: along x, the stamp's length or the wheel's circle at its deepest; belongs to the ground, not to time.
///
/// Energy: lost rate = F z' of the ground (what unloading gives back counts against it) and the contact's damping.
///
/// Source: Ye Min-zhen, Ground modeling in machinery-ground interaction system; unloading, contact and rut are ours.
struct GroundElement {
  static constexpr ForceMembers has{.check = true, .trace = true, .rut = true};
  static constexpr std::array<ForceColumn, 4> columns{
      {{"force", "N"}, {"soil force", "N"}, {"depth", "m"}, {"rut", "m"}}};
  int body = -1;
  std::array<double, 2> point{0, 0};
  double radius = 0, length = 0, surface = 0;
  PlasticStiffness stiffness{};
  double share = 0;
  double mass = std::numeric_limits<double>::quiet_NaN();
  double least_speed = 0.01;
  double unloading = 100, leaving_speed = 0.02, contact_time = 2e-3;
  std::string track{};
  // Set and kept by the system:
  int follower = -1;             ///< its body; -1: none
  double weight = 0;             ///< of the follower, carried by the ground (N)
  std::size_t rut = 0;           ///< index of its rut
  double touch = 0;              ///< speed of approach at the last first touch; 0: not touching
  double height = 0, speed = 0;  ///< of the lowest point at the end of the step before, y and upwards (m, m/s)

  template <class V>
  void describe(V& v) {
    v.card("ground element", "ground that is struck or pressed: follower mass on a plastic spring, with a rut");
    v.body("ground element", body, "the body that strikes");
    v.point("at", body, point, "its point, or the wheel's centre; left out: the centre of gravity");
    v.quantity("radius", radius, "m", "[0, inf)", "radius of a wheel; 0: a point or a stamp");
    v.quantity("length", length, "m", "[0, inf)", "length of a stamp along x, for the rut that it leaves");
    v.quantity("surface", surface, "m", "(-inf, inf)", "height y of the ground's surface");
    v.form("stiffness", stiffness, "K' of the plastic spring");
    v.quantity("follower", share, "1", "[0, 10]", "follower mass over the mass that strikes; 0: none, as for wheels");
    v.optional_quantity("mass", mass, "kg", "(0, inf)", "mass that strikes; left out: the body's");
    v.quantity("least speed", least_speed, "m/s", "(0, inf)", "K' of slower touches is that of this speed");
    v.quantity("unloading", unloading, "1", "(1, inf)", "stiffness of unloading over K'");
    v.quantity("leaving speed", leaving_speed, "m/s", "(0, inf)", "the ground throws nothing back faster than this");
    v.quantity("contact time", contact_time, "s", "(0, inf)", "time in which body and follower become one");
    v.text("track", track, "elements of the same track share their rut; left out: its own");
  }
  void check() const {
    std::visit([](const auto& s) { s.check(); }, stiffness);
    if (radius > 0 && length > 0)
      throw std::invalid_argument("has a radius and a length: a wheel or a stamp; give one of them");
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const Foot foot = foot_of(scene);
    const bool direct = follower < 0;
    const BodyState& base = scene.bodies[static_cast<std::size_t>(direct ? body : follower)];
    const double z = direct ? surface - foot.y : surface - base.r.y, rate = direct ? -foot.v : -base.v.y;
    const double rutted = scene.ruts[rut].at(foot.x).z;
    const double soil = ground_force(z, rate, rutted, speed_of(foot.v));
    // What presses deeper at this instant is rut too: the ground remembers it from the step's end on.
    values = {soil, soil, std::max(surface - foot.y, 0.0), std::max(z, rutted)};
    if (direct) {
      loads.add(body, foot.arm, {0, soil});
      return {0, soil * rate, 0};
    }
    const double depth = base.r.y - foot.y, closing = base.v.y - foot.v;
    const HuntCrossleyForce::Push push = contact(speed_of(foot.v)).at(depth, closing);
    loads.add(body, foot.arm, {0, push.force});
    loads.add_wrench(follower, 0, soil - push.force + weight, 0);
    values[0] = push.force;
    return {weight * z + push.stored, soil * rate + push.lost, 0};
  }

  /// Length by which the grid of its rut is chosen (m).
  double rut_size() const { return radius > 0 ? radius : length; }

  /// An accepted step: the ground remembers, and so does the element how fast it was struck.
  double commit(const Scene& scene, std::vector<Rut>& ruts) {
    const Foot foot = foot_of(scene);
    // The bottom of a rut pushes back from a little above it on.
    const double top = follower < 0 ? surface - ruts[rut].at(foot.x).z * (1 - 1 / unloading)
                                    : scene.bodies[static_cast<std::size_t>(follower)].r.y;
    // The next touch is a new impact from so far above the ground on as the rut's grid is wide.
    if (foot.y > top + ruts[rut].spacing()) touch = 0;
    if (foot.y <= top && touch == 0) touch = speed_at(top, foot);
    height = foot.y, speed = foot.v;
    const double z = surface - (follower < 0 ? foot.y : top);
    if (!(z > 0)) return 0;
    if (radius > 0)
      ruts[rut].press_disk(foot.x, z, radius);
    else
      ruts[rut].press_flat(foot.x - length / 2, foot.x + length / 2, z);
    return 0;
  }
  void begin_trace(const Scene& scene) {
    const Foot foot = foot_of(scene);
    touch = foot.y < surface ? speed_of(foot.v) : 0;
    height = foot.y, speed = foot.v;
  }
  std::array<double, 3> memory() const { return {touch, height, speed}; }
  void set_memory(const std::array<double, 3>& m) { touch = m[0], height = m[1], speed = m[2]; }

 private:
  /// Lowest point of the body: x, y, vertical velocity, and its moment arm about the centre of gravity.
  struct Foot {
    double x, y, v;
    Vec2 arm;
  };
  Foot foot_of(const Scene& scene) const {
    const BodyState& b = body_of(scene, body);
    const Vec2 arm = b.vector_in_world(point);
    return {b.r.x + arm.x, b.r.y + arm.y - radius, b.velocity_at(arm).y, arm};
  }
  /// When it came to this height in the step that ends here: v^2 rises evenly with the way, as under a steady load.
  /// Steps that end at the touch need none of it; a fixed one of 1 ms gains 10 mm/s behind it.
  double speed_at(double y, const Foot& end) const {
    const double share = height > y ? (height - y) / (height - end.y) : 1;
    return speed_of(-std::sqrt(std::max(0.0, speed * speed + share * (end.v * end.v - speed * speed))));
  }
  double speed_of(double v) const { return touch > 0 ? touch : std::max(-v, least_speed); }
  /// Between body and follower: as stiff as a swing of the two in the contact time, and damped to a restitution of 1/50
  /// (b v = 50), from a force of 0 on, so that a fixed step sees it come.
  HuntCrossleyForce contact(double v) const {
    const double omega = 6.283185307179586 / contact_time;
    return {.n = 1, .stiffness = mass * share / (1 + share) * omega * omega, .damping = 50 / v};
  }
  double ground_force(double z, double rate, double rutted, double v) const {
    if (!(z > 0)) return 0;
    // What rises from new ground, as a point that moves along x, is not thrown back either.
    if (z >= rutted) return plastic_force(stiffness, z, v, mass) * std::clamp(1 + rate / leaving_speed, 0.0, 1.0);
    const double limit = plastic_force(stiffness, rutted, v, mass);
    const double elastic = std::max(0.0, limit * (1 - unloading * (rutted - z) / rutted));
    return std::clamp(elastic * (1 + rate / leaving_speed), 0.0, limit);
  }
};

struct Model;
/// Gives every ground element of the model its mass and, where it has a share, its follower: a body named
/// "NAME follower" at the surface and a slide "NAME guide" along y. System does it to the model it is given.
void add_followers(Model& model);

}  // namespace subsoil::mbd
