#pragma once
#include <optional>

#include "libsim/studies/laboratory/findings.hpp"
#include "libsim/studies/laboratory/specimen.hpp"

namespace subsoil::sim {

/// Direct shear: a box of two halves, the upper one held, the lower one drawn along +x; a lid carries the load. End
/// walls and sides are smooth, floor and lid rough; flanges cover the gaps that open, as the thick walls of a real box.
///     A = width (length - path)   area that still shears
///     tau = sum F_x/A,  sigma = sum F_y/A   F: force of a grain with its centre below the plane on one above
/// What presses on a flange, outside A, counts in neither: walls and lid would count it, and of the plane's edges what
/// is squeezed between grains and a half's rim. sigma is at most (load + weight above the plane)/A.
/// Peak: maximum tau/sigma of means over a twentieth of the path; final: mean over its last fifth. Per packing a line
/// tau = c + sigma tan(phi) through the loads' points, for peak and final; the final stress ratio is the mean of
/// tau/sigma over the loads, which for a material without cohesion is the better number.
struct Shear {
  std::optional<double> length, width, depth, path, speed;
  std::vector<double> loads{5e3, 10e3, 20e3};

  template <class V>
  void describe(V& v) {
    v.quantity("length", length, "m", "(0, inf)", "of the box along the path; left out: 20 diameters");
    v.quantity("width", width, "m", "(0, inf)", "across; left out: 8 diameters");
    v.quantity("depth", depth, "m", "(0, inf)", "of the packing; left out: 10 diameters");
    v.quantities("loads", loads, "Pa", "(0, inf)", "normal stresses on the lid, two at least");
    v.quantity("path", path, "m", "(0, inf)", "of the lower half; left out: 0.15 lengths");
    v.quantity("speed", speed, "m/s", "(0, inf)", "of the lower half; left out: sqrt(g d)/10");
  }

  static std::vector<Number> numbers() {
    return {{"friction angle", "rad", {}},
            {"cohesion", "Pa", {}},
            {"final friction angle", "rad", {}},
            {"final cohesion", "Pa", {}},
            {"final stress ratio", "1", {}}};
  }
  std::size_t specimens(std::size_t packings) const { return packings * loads.size(); }
  /// Loads vary faster than packings.
  Outcome run(const Sample& sample, std::size_t index) const;
  Findings findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const;
};

}  // namespace subsoil::sim
