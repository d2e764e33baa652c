#pragma once
#include <optional>

#include "libsim/studies/laboratory/findings.hpp"
#include "libsim/studies/laboratory/specimen.hpp"

namespace subsoil::sim {

/// A cone or a flat round plate goes down into a bed at constant speed.
///     depth  of the cone's base, or of the plate, below the mean surface; resistance q = F/(pi diameter^2/4)
///     index  mean of q from `from` to the end of the path: the cone index (ASABE S313.3, EP542) over that window
///     k, n   of q = k (z/z0)^n with z0 = 1 m by least squares of ln q over the same window: Bekker's sinkage of a
///     plate slope  of q over depth by least squares over the same window
/// The shaft is left out: nothing but the cone touches.
struct Penetrate {
  enum class Tool { cone, plate };
  Tool tool = Tool::cone;
  std::optional<double> diameter, length, depth, speed, from, path;
  double angle = 0.523598775598298873;  // 30 deg, ASABE S313.3

  template <class V>
  void describe(V& v) {
    v.choice("tool", tool, {{"cone", Tool::cone}, {"plate", Tool::plate}}, "what is pushed in");
    v.quantity("diameter", diameter, "m", "(0, inf)", "of cone base or plate; left out: 4 diameters of the grains");
    v.quantity("angle", angle, "rad", "(0, 3.14)", "of the whole cone");
    v.quantity("length", length, "m", "(0, inf)", "of the square box; left out: 4 tool diameters");
    v.quantity("depth", depth, "m", "(0, inf)", "of the bed; left out: 4 tool diameters");
    v.quantity("speed", speed, "m/s", "(0, inf)", "of the tool; left out: sqrt(g d)/2");
    v.quantity("path", path, "m", "(0, inf)", "depth that the base reaches; left out: 1.5 tool diameters");
    v.quantity("from", from, "m", "[0, inf)", "depth at which the mean begins; left out: a third of the path");
  }

  static std::vector<Number> numbers() {
    return {{"index", "Pa", {}}, {"slope", "Pa/m", {}}, {"k", "Pa", {}}, {"n", "1", {}}};
  }
  std::size_t specimens(std::size_t packings) const { return packings; }
  Outcome run(const Sample& sample, std::size_t packing) const;
  Findings findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const;
};

}  // namespace subsoil::sim
