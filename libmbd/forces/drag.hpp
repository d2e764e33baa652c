#pragma once

#include <stdexcept>

#include "libmbd/base/function.hpp"
#include "libmbd/element/force_geometry.hpp"

namespace subsoil::mbd {

/// Drag of a medium on a body, at a point of it:
///   F = -(c_1 + c_2 |u|) u,  u = v_point - wind(t)                                    (N)
///   T = -(b_1 + b_2 |omega|) omega                                                      (N m)
/// c_1 [N s/m], c_2 [N s^2/m^2] (rho A C_d / 2 of a bluff body), b_1 [N m s/rad], b_2 [N m s^2/rad^2], all >= 0; wind:
/// velocity of the medium in world axes [m/s], zero unless given. Of one point: a field that varies over the body, lift
/// and added mass are not in it.
/// Energy: lost rate = (c_1 + c_2 |u|) u^2 + (b_1 + b_2 |omega|) omega^2, work rate = F . wind.
struct Drag {
  static constexpr ForceMembers has{.check = true};
  static constexpr std::array<ForceColumn, 3> columns{{{"fx", "N"}, {"fy", "N"}, {"moment", "N m"}}};
  int body = -1;
  std::array<double, 2> point{0, 0};
  double linear = 0, quadratic = 0, linear_turn = 0, quadratic_turn = 0;
  Function wind_x = 0.0, wind_y = 0.0;

  template <class V>
  void describe(V& v) {
    v.card("drag", "linear and quadratic drag of still air, wind or water on a point of a body, and on its turning");
    v.body("drag", body, "the body on which it acts");
    v.point("at", body, point, "where it acts and whose velocity counts; left out: the centre of gravity");
    v.quantity("linear", linear, "N s/m", "[0, inf)", "force per speed");
    v.quantity("quadratic", quadratic, "N s^2/m^2", "[0, inf)", "force per speed squared");
    v.quantity("linear rotational", linear_turn, "N m s/rad", "[0, inf)", "moment per angular velocity");
    v.quantity("quadratic rotational", quadratic_turn, "N m s^2/rad^2", "[0, inf)",
               "moment per angular velocity squared");
    v.function("wind along x", wind_x, "m/s", "velocity of the air along the world's x");
    v.function("wind along y", wind_y, "m/s", "velocity of the air along the world's y");
  }

  void check() const {
    for (const double c : {linear, quadratic, linear_turn, quadratic_turn})
      if (!(c >= 0))
        throw std::invalid_argument("drag coefficients must not be negative; for a push along the motion use a force");
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const BodyState& b = body_of(scene, body);
    const Vec2 arm = b.vector_in_world(point), wind{wind_x.value(scene.t), wind_y.value(scene.t)},
               u = b.velocity_at(arm) - wind;
    const Vec2 f = -(linear + quadratic * length(u)) * u;
    const double moment = -(linear_turn + quadratic_turn * std::abs(b.omega)) * b.omega;
    loads.add(body, arm, f);
    loads.add_wrench(body, 0, 0, moment);
    values = {f.x, f.y, moment, 0};
    return {0, -dot(f, u) - moment * b.omega, dot(f, wind)};
  }
};

}  // namespace subsoil::mbd
