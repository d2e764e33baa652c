#pragma once

#include <stdexcept>

#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/spring_law.hpp"

namespace subsoil::mbd {

/// Translational spring-damper-actuator between a point of body a and a point of body b, distance L:
///   F = preload + k d + f_s(d) + c d' + f_d(d') + f(t) + u,  d = L_0 - L     compression positive: pushes apart   (N)
/// k stiffness [N/m] >= 0, L_0 free length [m], c damping [N s/m] >= 0, preload [N]; f_s spring curve over the
/// shortening d, f_d damper curve over its rate (polynomial or table), f actuator force, u output of a controller: none
/// of them unless given. Without a free length L_0 is the length in the start pose, and the preload then is the force
/// there. Valid for L > 0: at L = 0 the line of action is not defined and the force refuses. Energy: stored = preload d
/// + k d^2 / 2 + integral of f_s from 0 to d, lost rate = (c d' + f_d(d')) d' (a damper curve whose sign is not that of
/// the rate gives energy, and the balance reports it), work rate = -(f + u) d'. Source: Haug 1989, chapter 6,
/// translational spring-damper-actuator.
struct SpringDamper {
  static constexpr ForceMembers has{.check = true, .initialise_from_pose = true, .profiles = true, .controlled = true};
  static constexpr std::array<ForceColumn, 3> columns{{{"force", "N"}, {"length", "m"}, {"damper force", "N"}}};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double stiffness = std::numeric_limits<double>::quiet_NaN();
  double free_length = std::numeric_limits<double>::quiet_NaN();
  double preload = 0;
  double damping = 0;
  Characteristic spring_curve{}, damper_curve{};
  Function actuator{};
  std::string controller{};
  int signal = -1;  ///< set by the system

  template <class V>
  void describe(V& v) {
    v.card("spring-damper", "a spring and a damper in line between a point of each body; compression is positive");
    v.bodies("spring-damper", body_a, body_b, "the two bodies that it joins");
    v.end_points(body_a, p_a, body_b, p_b, "its two ends");
    v.optional_quantity("stiffness", stiffness, "N/m", "[0, inf)",
                        "force per shortening; may only be left out where a spring curve is given");
    v.optional_quantity("free length", free_length, "m", "[0, inf)",
                        "length without spring force; left out: the length in the start pose");
    v.quantity("preload", preload, "N", "(-inf, inf)", "constant force on top, compression positive");
    v.quantity("damping", damping, "N s/m", "[0, inf)", "force per rate of shortening");
    v.optional_characteristic("spring curve", spring_curve, "m", "N",
                              "force over shortening from the free length, on top of the stiffness");
    v.optional_characteristic("damper curve", damper_curve, "m/s", "N",
                              "force over rate of shortening, on top of the damping");
    v.optional_function("actuator force", actuator, "N", "given force in line, pushing the ends apart when positive");
    v.text("controller", controller,
           "name of the controller whose output, in N, is added to it; left "
           "out: none");
  }

  void check() const { check_spring(*this); }

  void initialise_from_pose(const Scene& scene) {
    if (std::isnan(free_length)) free_length = line(scene).length;
    if (std::isnan(stiffness)) stiffness = 0;
  }

  std::size_t profile_count() const { return spring_profile_count(*this); }
  void profile_arguments(const Scene& scene, std::span<double> out) const {
    const LineOfAction l = line(scene);
    spring_profile_arguments(*this, free_length - l.length, -l.rate, out);
  }
  double profile_value(std::size_t k, double x) const { return spring_profile(*this, k).value(x); }
  std::vector<double> profile_nodes(std::size_t k) const {
    const std::span<const double> nodes = spring_profile(*this, k).nodes();
    return {nodes.begin(), nodes.end()};
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const LineOfAction l = line(scene);
    if (!(l.length > 0)) throw std::runtime_error("spring-damper has length 0, so no direction; move its ends apart");
    const SpringLaw law = spring_law(*this, free_length - l.length, -l.rate, scene);
    const Vec2 on_b = law.total() * l.e;
    loads.add(body_b, l.arm_b, on_b);
    loads.add(body_a, l.arm_a, -1.0 * on_b);
    values = {law.total(), l.length, law.viscous, 0};
    return law.power;
  }

 private:
  LineOfAction line(const Scene& scene) const { return {body_of(scene, body_a), p_a, body_of(scene, body_b), p_b}; }
};

}  // namespace subsoil::mbd
