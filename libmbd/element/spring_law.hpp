#pragma once

#include "libmbd/base/characteristic.hpp"
#include "libmbd/element/force.hpp"

namespace subsoil::mbd {

/// What a spring-damper-actuator does along its coordinate (N and m, or N m and rad), d shortening, d' its rate:
///   F = preload + k d + f_s(d)  +  c d' + f_d(d')  +  f(t) + u         u:
///   output of a controller
struct SpringLaw {
  double elastic = 0, viscous = 0, actuator = 0;
  ForcePower power{};
  double total() const { return elastic + viscous + actuator; }
};

/// The law of a struct S with the fields stiffness, preload, damping, spring_curve, damper_curve, actuator and signal,
/// shared by the springs in line and about a pin. Stored is the exact integral of the elastic part over d; the
/// actuator's work leaves the balance through `work`.
template <class S>
SpringLaw spring_law(const S& s, double shortening, double rate, const Scene& scene) {
  SpringLaw law;
  law.elastic = s.preload + s.stiffness * shortening;
  law.viscous = s.damping * rate;
  law.power = {0.5 * s.stiffness * shortening * shortening + s.preload * shortening, 0, 0};
  if (s.spring_curve.is_set()) {
    law.elastic += s.spring_curve.value(shortening);
    law.power.stored += s.spring_curve.integral(shortening);
  }
  if (s.damper_curve.is_set()) law.viscous += s.damper_curve.value(rate);
  if (s.actuator.is_set()) law.actuator = s.actuator.value(scene.t);
  if (s.signal >= 0) law.actuator += scene.signals[static_cast<std::size_t>(s.signal)];
  law.power.lost = law.viscous * rate;
  law.power.work = -law.actuator * rate;
  return law;
}

/// Which curves of such a struct are profiles of its force: those with nodes, the spring curve first.
template <class S>
std::size_t spring_profile_count(const S& s) {
  return static_cast<std::size_t>(!s.spring_curve.nodes().empty()) +
         static_cast<std::size_t>(!s.damper_curve.nodes().empty());
}
template <class S>
const Characteristic& spring_profile(const S& s, std::size_t k) {
  return k == 0 && !s.spring_curve.nodes().empty() ? s.spring_curve : s.damper_curve;
}

/// Their arguments: shortening d and its rate d'.
template <class S>
void spring_profile_arguments(const S& s, double shortening, double rate, std::span<double> out) {
  std::size_t k = 0;
  if (!s.spring_curve.nodes().empty()) out[k++] = shortening;
  if (!s.damper_curve.nodes().empty()) out[k++] = rate;
}

/// The rule of such a struct; throws std::invalid_argument.
template <class S>
void check_spring(const S& s) {
  if (!(s.stiffness >= 0 || (std::isnan(s.stiffness) && s.spring_curve.is_set())) || !(s.damping >= 0))
    throw std::invalid_argument("stiffness and damping must be given and not negative; stiffness 0 is a damper alone");
}

}  // namespace subsoil::mbd
