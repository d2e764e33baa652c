#pragma once

#include <array>
#include <string>

#include "libmbd/base/body.hpp"

namespace subsoil::mbd {

/// A point with axes, fixed to a body or to the ground: what measures look at and from.
///   r = r_body + A_body p,  axes at angle_body + angle from the world's
/// p [m] and angle [rad] in the body's own axes. A body's own marker is its centre of gravity with its axes; the
/// ground's is the world's origin.
struct Marker {
  std::string name{};  ///< of the marker, or of the body; empty where a measure may go without
  int body = ground;
  std::array<double, 2> p{0, 0};
  double angle = 0;

  template <class V>
  void describe(V& v) {
    v.optional_body("body", body, "the body that carries it; left out: the ground");
    v.point("at", body, p, "its point; left out: the body's centre of mass, of the ground the world's origin");
    v.quantity("angle", angle, "rad", "(-inf, inf)", "of its axes against the body's, counter-clockwise");
  }
};

}  // namespace subsoil::mbd
