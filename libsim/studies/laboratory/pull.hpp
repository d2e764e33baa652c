#pragma once
#include <optional>

#include "libsim/studies/laboratory/findings.hpp"
#include "libsim/studies/laboratory/specimen.hpp"

namespace subsoil::sim {

/// Direct tension in a mould of two halves that widen away from the plane between them (the eight-shaped mould of soil
/// and mortar briquettes), so that each half holds its soil by its shape. Filled, pressed by a lid, the lid taken away,
/// then the upper half is drawn up.
///     sigma_t = -(weight above the plane + F_y on the upper half)/A     tension on the neck A, by equilibrium
///     strength  maximum mean of sigma_t over a fiftieth of the path, 0 where none is above
///     work      integral of max(0, sigma_t) over the path, J/m^2: what tears the neck. Where sigma_t is below 0 grains
///               that stay behind press on the plane, which is no work of tension
struct Pull {
  std::optional<double> neck, width, depth, path, speed;
  double load = 5e3;

  template <class V>
  void describe(V& v) {
    v.quantity("neck", neck, "m", "(0, inf)", "length of the plane between the halves; left out: 8 diameters");
    v.quantity("width", width, "m", "(0, inf)", "across, between smooth sides; left out: 6 diameters");
    v.quantity("depth", depth, "m", "(0, inf)", "of the packing, both halves; left out: 10 diameters");
    v.quantity("load", load, "Pa", "(0, inf)", "that the lid presses with before");
    v.quantity("path", path, "m", "(0, inf)", "of the upper half; left out: 2 diameters");
    v.quantity("speed", speed, "m/s", "(0, inf)", "of the upper half; left out: sqrt(g d)/20");
  }

  static std::vector<Number> numbers() {
    return {{"strength", "Pa", {}}, {"path at strength", "m", {}}, {"work", "J/m^2", {}}};
  }
  std::size_t specimens(std::size_t packings) const { return packings; }
  Outcome run(const Sample& sample, std::size_t packing) const;
  Findings findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const;
};

}  // namespace subsoil::sim
