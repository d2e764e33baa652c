#pragma once

#include "libmbd/base/function.hpp"
#include "libmbd/element/force.hpp"

namespace subsoil::mbd {

/// The axes in which a given force stands.
enum class Axes { world, body };
/// The component to which a controller's output is added.
enum class Controls { x, y, moment };

/// Given force and moment on a material point of a body:
///   F = (f_x(t), f_y(t)) in world or body axes at r + A p,  M = m(t)              (N, N m)
/// A controller's output is added to one of f_x, f_y, m.
/// In world axes a dead load, in body axes a follower load. Energy: work rate = F . v_point + M omega.
struct AppliedForce {
  static constexpr ForceMembers has{.controlled = true};
  static constexpr std::array<ForceColumn, 3> columns{{{"fx", "N"}, {"fy", "N"}, {"moment", "N m"}}};
  int body = -1;
  std::array<double, 2> point{0, 0};
  Axes axes = Axes::world;
  Function fx = 0.0, fy = 0.0, moment = 0.0;
  std::string controller{};
  Controls controls = Controls::x;
  int signal = -1;  ///< set by the system

  template <class V>
  void describe(V& v) {
    v.card("force", "a given force and moment on a point of a body");
    v.body("force", body, "the body on which it acts");
    v.point("at", body, point, "where it acts; left out: the centre of gravity");
    v.choice("axes", axes, {{"world", Axes::world}, {"body", Axes::body}},
             "whether its direction stays in the world or turns with the body");
    v.function("along x", fx, "N", "component along x");
    v.function("along y", fy, "N", "component along y");
    v.function("moment", moment, "N m", "moment about z, counter-clockwise positive");
    v.text("controller", controller,
           "name of the controller whose output is added to one of them; left "
           "out: none");
    v.choice("controls", controls, {{"x", Controls::x}, {"y", Controls::y}, {"moment", Controls::moment}},
             "the component that the controller's output is added to");
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const BodyState& b = scene.bodies[static_cast<std::size_t>(body)];
    double x = fx.value(scene.t), y = fy.value(scene.t), m = moment.value(scene.t);
    if (signal >= 0)
      (controls == Controls::x   ? x
       : controls == Controls::y ? y
                                 : m) += scene.signals[static_cast<std::size_t>(signal)];
    const Vec2 arm = b.vector_in_world(point), f = axes == Axes::world ? Vec2{x, y} : b.vector_in_world({x, y});
    loads.add(body, arm, f);
    loads.add_wrench(body, 0, 0, m);
    values = {f.x, f.y, m, 0};
    return {0, 0, dot(f, b.velocity_at(arm)) + m * b.omega};
  }
};

}  // namespace subsoil::mbd
