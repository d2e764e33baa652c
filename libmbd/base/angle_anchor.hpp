#pragma once

#include <cmath>

namespace subsoil::mbd {

/// Sine and cosine of an angle (rad) that mostly stays near where it was asked for last: from those of the nearest
/// multiple a of 1/64 rad, which are kept, and the series of the rest x, |x| <= 1/128:
///   cos(a + x) = cos a + (cos a (cos x - 1) - sin a sin x),   sin likewise
/// Within 1.5 units in the last place of 1. A function of the angle alone, independent of earlier calls: a and x are
/// exact. The library's sine and cosine cost four times as much, and a step of a machine asks for them four times per
/// body.
class AngleAnchor {
 public:
  void of(double angle, double& cosine, double& sine) {
    double x = angle - at_;
    if (!(std::abs(x) < half_spacing)) {
      at_ = std::round(angle * per_radian) / per_radian;
      cosine_ = std::cos(at_), sine_ = std::sin(at_);
      x = angle - at_;
    }
    // The terms left out, x^8/8! and x^9/9!, are below 4e-22.
    const double y = x * x;
    const double less = y * (-1. / 2 + y * (1. / 24 - y / 720));
    const double sine_x = x + x * y * (-1. / 6 + y * (1. / 120 - y / 5040));
    cosine = cosine_ + (cosine_ * less - sine_ * sine_x);
    sine = sine_ + (sine_ * less + cosine_ * sine_x);
  }

 private:
  static constexpr double per_radian = 64, half_spacing = 1. / 128;
  double at_ = 0, cosine_ = 1, sine_ = 0;
};

}  // namespace subsoil::mbd
