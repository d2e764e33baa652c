#pragma once
#include <optional>

#include "libsim/studies/laboratory/findings.hpp"
#include "libsim/studies/laboratory/specimen.hpp"

namespace subsoil::sim {

/// Uniaxial compression: a lid goes down into a box with smooth walls until its stress is reached, then up again.
///     stress   of the grains on the lid, over the box' area;  strain  way of the lid over the height at which the
///              seating stress, 2 % of the maximum, was reached (as an oedometer is read, ASTM D2435)
///     modulus  slope of stress over strain by least squares, loading, from half of the maximum stress up
///     unloading the same on the way back, down to half of it
///     K0       mean stress on the four walls over the mean of lid and floor, at the maximum stress
///     kept     strain that stays when the stress is back at the seating stress, over the maximum strain
struct Compress {
  std::optional<double> length, depth, speed;
  double stress = 20e3;

  template <class V>
  void describe(V& v) {
    v.quantity("length", length, "m", "(0, inf)", "of the square box; left out: 10 diameters");
    v.quantity("depth", depth, "m", "(0, inf)", "of the packing; left out: 10 diameters");
    v.quantity("stress", stress, "Pa", "(0, inf)", "at which the lid turns round");
    v.quantity("speed", speed, "m/s", "(0, inf)", "of the lid; left out: sqrt(g d)/20");
  }

  static std::vector<Number> numbers() {
    return {{"modulus", "Pa", {}}, {"unloading modulus", "Pa", {}}, {"K0", "1", {}}, {"kept strain", "1", {}}};
  }
  std::size_t specimens(std::size_t packings) const { return packings; }
  Outcome run(const Sample& sample, std::size_t packing) const;
  Findings findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const;

  /// Presses what lies in a box of this area and height.
  Outcome press(Specimen& specimen, const Specimen::BoxWalls& walls, double area) const;
};

}  // namespace subsoil::sim
