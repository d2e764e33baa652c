#pragma once

// Random planar mechanisms whose freedom is known by construction: an open tree of pins, slides and welds, then dyads
// (two bodies and three joints, which add no freedom) that close loops between bodies of it; springs and dampers.

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::test {

class MechanismDice {
 public:
  explicit MechanismDice(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0); }
  int below(int n) { return static_cast<int>(in(0, n)); }

 private:
  std::mt19937 engine_;
};

struct RandomMechanism {
  mbd::Model model;      ///< in a pose that closes all joints
  int freedom = 0;       ///< 3 bodies - equations (Gruebler)
  double length = 0.25;  ///< of a typical lever (m)
};

namespace detail {

class MechanismBuilder {
 public:
  explicit MechanismBuilder(unsigned seed) : dice_(seed) {}

  RandomMechanism build(int tree, int dyads) {
    for (int i = 0; i < tree; ++i) grow();
    for (int i = 0; i < dyads; ++i) close();
    springs();
    out_.freedom = 3 * static_cast<int>(out_.model.bodies.size()) - equations_;
    return std::move(out_);
  }

 private:
  mbd::Vec2 place(int body) const {
    if (body == mbd::ground) return {0, 0};
    const auto& p = out_.model.bodies[static_cast<std::size_t>(body - 1)].pose;
    return {p[0], p[1]};
  }
  double angle(int body) const {
    return body == mbd::ground ? 0 : out_.model.bodies[static_cast<std::size_t>(body - 1)].pose[2];
  }
  std::array<double, 2> local(int body, mbd::Vec2 world) const {
    return mbd::BodyState(place(body), angle(body), {}, 0).point_in_body(world);
  }
  mbd::Vec2 near(mbd::Vec2 p) { return {p.x + dice_.in(-0.3, 0.3), p.y + dice_.in(-0.3, 0.3)}; }

  int add_body(mbd::Vec2 at) {
    return out_.model.add({.name = "body " + std::to_string(out_.model.bodies.size() + 1),
                           .mass = dice_.in(0.5, 4),
                           .inertia = dice_.in(0.01, 0.2),
                           .pose = {at.x, at.y, dice_.in(-3, 3)},
                           .velocity = {dice_.in(-0.5, 0.5), dice_.in(-0.5, 0.5), dice_.in(-2, 2)}});
  }
  template <class Joint>
  void add_joint(Joint joint) {
    equations_ += static_cast<int>(Joint::rows);
    out_.model.add("joint " + std::to_string(out_.model.joints.size() + 1), joint);
  }
  void pin(int a, int b, mbd::Vec2 at) {
    add_joint(mbd::Revolute{.body_a = a, .body_b = b, .p_a = local(a, at), .p_b = local(b, at)});
  }
  void slide(int a, int b, mbd::Vec2 at) {
    add_joint(mbd::Translational{.body_a = a,
                                 .body_b = b,
                                 .p_a = local(a, at),
                                 .p_b = local(b, at),
                                 .angle_a = dice_.in(0, 3),
                                 .relative_angle = angle(b) - angle(a)});
  }

  void grow() {
    const int parent = dice_.below(static_cast<int>(out_.model.bodies.size()) + 1);
    const mbd::Vec2 joint = near(place(parent));
    const int body = add_body(near(joint));
    const double kind = dice_.in(0, 1);
    if (kind < 0.7) {
      pin(parent, body, joint);
    } else if (kind < 0.9 || parent == mbd::ground) {
      slide(parent, body, joint);
    } else {
      add_joint(mbd::Fixed{.body_a = parent,
                           .body_b = body,
                           .p_a = local(parent, joint),
                           .p_b = local(body, joint),
                           .relative_angle = angle(body) - angle(parent)});
    }
  }

  /// Two bodies from a and b to a common pin well off the line between their ends: not stretched, so of full rank.
  void close() {
    const int n = static_cast<int>(out_.model.bodies.size());
    const int a = dice_.below(n + 1);
    int b = dice_.below(n + 1);
    if (b == a) b = (a + 1) % (n + 1);
    const mbd::Vec2 end_a = near(place(a)), end_b = near(place(b)), way = end_b - end_a;
    const double aside = (0.3 + 0.5 * mbd::length(way)) * (dice_.in(0, 1) < 0.5 ? -1 : 1) / (mbd::length(way) + 1e-9);
    const mbd::Vec2 knee = end_a + 0.5 * way + aside * mbd::turned(way);
    const int c = add_body(end_a + 0.5 * (knee - end_a)), d = add_body(end_b + 0.5 * (knee - end_b));
    pin(a, c, end_a);
    if (dice_.in(0, 1) < 0.7)
      pin(b, d, end_b);
    else
      slide_along(b, d, end_b, knee - end_b);
    pin(c, d, knee);
  }
  /// A slide whose line points to the knee: across it the dyad is stiff, along it the slide gives way.
  void slide_along(int a, int b, mbd::Vec2 at, mbd::Vec2 along) {
    slide(a, b, at);
    out_.model.joints.back().element.get_if<mbd::Translational>()->angle_a = std::atan2(along.y, along.x) - angle(a);
  }

  void springs() {
    const int n = static_cast<int>(out_.model.bodies.size());
    for (int i = 0; i < 2; ++i) {
      const int b = 1 + dice_.below(n);
      out_.model.add("spring " + std::to_string(i), mbd::SpringDamper{.body_a = mbd::ground,
                                                                      .body_b = b,
                                                                      .p_a = {dice_.in(2, 3), dice_.in(-1, 1)},
                                                                      .p_b = {dice_.in(-0.1, 0.1), 0.1},
                                                                      .stiffness = dice_.in(10, 60)});
    }
    out_.model.add("twist", mbd::RotationalSpringDamper{
                                .body_a = mbd::ground, .body_b = 1 + dice_.below(n), .stiffness = dice_.in(0.5, 2)});
  }

  MechanismDice dice_;
  RandomMechanism out_;
  int equations_ = 0;
};

}  // namespace detail

inline RandomMechanism random_mechanism(unsigned seed, int tree, int dyads) {
  return detail::MechanismBuilder(seed).build(tree, dyads);
}

}  // namespace subsoil::test
