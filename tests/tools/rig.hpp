#pragma once

// The rig 1S-300 of rig-1s300.md as a libmbd model, for tests.

#include <array>
#include <string>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::test {

struct RigOptions {
  double raise = 0;      ///< vertical shift of shovel, H8, S1, S7 (m): 0 as printed, 0.125 for 0.18 m of working depth
  double damping = 611;  ///< of H9 (N s/m)
  double rearward = 0;   ///< dead load H on the shovel (N)
  double downward = 0;   ///< dead load V on the shovel (N)
  double speed = 0.5;    ///< of the trolley (m/s)
};

struct Rig {
  mbd::Model model;
  int shovel, left_wheel, right_wheel, lower_link, trolley, upper_link, frame;
};

/// A pin at a world point of bodies that all stand at angle 0.
inline mbd::Revolute pin(const mbd::Model& model, int a, int b, double x, double y) {
  const auto local = [&](int body) -> std::array<double, 2> {
    if (body == mbd::ground) return {x, y};
    const auto& pose = model.bodies[static_cast<std::size_t>(body - 1)].pose;
    return {x - pose[0], y - pose[1]};
  };
  return {.body_a = a, .body_b = b, .p_a = local(a), .p_b = local(b)};
}

inline Rig make_rig(const RigOptions& o = {}) {
  Rig rig;
  auto& m = rig.model;
  const std::array<double, 3> v{o.speed, 0, 0}, rolling{o.speed, 0, -o.speed / 0.20};
  rig.shovel =
      m.add({.name = "shovel", .mass = 35.2, .inertia = 2.662, .pose = {-1.224, 0.240 + o.raise, 0}, .velocity = v});
  rig.left_wheel =
      m.add({.name = "left wheel", .mass = 25, .inertia = 0.5585, .pose = {-0.430, 0.200, 0}, .velocity = rolling});
  rig.right_wheel =
      m.add({.name = "right wheel", .mass = 25, .inertia = 0.5585, .pose = {-0.430, 0.200, 0}, .velocity = rolling});
  rig.lower_link =
      m.add({.name = "lower link", .mass = 7.8, .inertia = 3.104, .pose = {-0.345, 0.400, 0}, .velocity = v});
  rig.trolley = m.add({.name = "trolley", .mass = 100, .inertia = 8e4, .pose = {0.200, 0.600, 0}, .velocity = v});
  rig.upper_link =
      m.add({.name = "upper link", .mass = 10, .inertia = 0.1896, .pose = {-0.3875, 0.790, 0}, .velocity = v});
  rig.frame = m.add({.name = "frame", .mass = 68, .inertia = 7.022, .pose = {-0.930, 0.520, 0}, .velocity = v});

  m.add("H1", mbd::Translational{
                  .body_a = rig.trolley, .body_b = mbd::ground, .p_a = {0, 0}, .p_b = {0.200, 0.600}, .angle_a = 0});
  m.add("H2", pin(m, rig.trolley, rig.lower_link, 0, 0.400));
  m.add("H3", pin(m, rig.trolley, rig.upper_link, -0.150, 0.780));
  m.add("H4", pin(m, rig.lower_link, rig.frame, -0.690, 0.400));
  m.add("H5", pin(m, rig.upper_link, rig.frame, -0.625, 0.800));
  m.add("H6", pin(m, rig.right_wheel, rig.frame, -0.430, 0.200));
  m.add("H7", pin(m, rig.left_wheel, rig.frame, -0.430, 0.200));
  m.add("H8", pin(m, rig.frame, rig.shovel, -1.240, 0.445 + o.raise));

  const auto s1 = pin(m, rig.shovel, rig.frame, -1.240, 0.715 + o.raise).p_a;
  const auto s7 = pin(m, rig.shovel, rig.frame, -0.900, 0.715 + o.raise).p_b;
  m.add("H9", mbd::SpringDamper{.body_a = rig.shovel,
                                .body_b = rig.frame,
                                .p_a = s1,
                                .p_b = s7,
                                .stiffness = 164e3,
                                .free_length = 0.326396,
                                .damping = o.damping});
  m.add("H10",
        mbd::CoordinateDriver{.body = rig.trolley, .coordinate = mbd::Coordinate::x, .motion = {.velocity = o.speed}});
  for (const auto& [name, body] :
       {std::pair{"left wheel on soil", rig.left_wheel}, {"right wheel on soil", rig.right_wheel}})
    m.add(name, mbd::WheelOnSoil{
                    .body = body, .radius = 0.20, .width = 0.12, .n = 1.3126, .k_c = 1434.81e3, .k_phi = 165.79e3});
  if (o.rearward != 0 || o.downward != 0)
    m.add("soil load",
          mbd::AppliedForce{
              .body = rig.shovel, .point = {-1.100 + 1.224, -0.155 - 0.240}, .fx = -o.rearward, .fy = -o.downward});
  return rig;
}

}  // namespace subsoil::test
