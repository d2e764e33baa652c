#pragma once

// What closed forms of one coordinate share: its three columns, and the free damped oscillation.

#include <cmath>
#include <string>

#include "tests/verification/mechanisms/cases/minimal_coordinates.hpp"

namespace subsoil::cases {

using test::Expected;

/// Value, rate and acceleration of one coordinate.
using State = test::Triple;

inline void add(Expected& out, const std::string& body, const char* axis, double offset, const State& s) {
  const std::string letter = axis;
  const bool turns = letter == "angle";
  out.push_back({body + "." + letter, offset + s[0]});
  out.push_back({body + (turns ? ".spin" : ".v" + letter), s[1]});
  out.push_back({body + (turns ? ".alpha" : ".a" + letter), s[2]});
}

/// m u'' + c u' + k u = 0 from (u, v): the three cases of the characteristic roots.
inline State free_oscillation(double m, double c, double k, double u, double v, double t) {
  const double decay = c / (2 * m), square = k / m - decay * decay;
  const double e = std::exp(-decay * t), b = v + decay * u;
  double value, rate;
  if (std::abs(square) < 1e-12) {
    value = e * (u + b * t);
    rate = e * (v - decay * b * t);
  } else {
    const double w = std::sqrt(std::abs(square));
    const double co = square > 0 ? std::cos(w * t) : std::cosh(w * t);
    const double si = (square > 0 ? std::sin(w * t) : std::sinh(w * t)) / w;
    value = e * (u * co + b * si);
    rate = e * (v * co - (decay * b + (square > 0 ? w * w : -w * w) * u) * si);
  }
  return {value, rate, -(c * rate + k * value) / m};
}

}  // namespace subsoil::cases
