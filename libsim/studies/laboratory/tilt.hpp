#pragma once
#include <optional>

#include "libsim/studies/laboratory/findings.hpp"
#include "libsim/studies/laboratory/specimen.hpp"

namespace subsoil::sim {

/// A box with rough floor and smooth sides is tilted about z until what lies in it slides or rolls.
///     angle  at which the grains' mean place has moved along the floor by `slip`
/// The box stands and gravity turns. The angle lies above that at which motion begins by what is tilted while `slip` is
/// passed, about (6 slip rate^2/g)^(1/3), 0.4 degrees with the defaults and 8 mm grains. Farther than d/20 what slides
/// stems against the lower wall, and one box stops where another continues.
struct Tilt {
  std::optional<double> length, width, depth, slip;
  double rate = 0.0349065850398866;  // 2 deg/s
  double from = 0.174532925199433;   // 10 deg
  double until = 1.0471975511966;    // 60 deg

  template <class V>
  void describe(V& v) {
    v.quantity("length", length, "m", "(0, inf)", "of the box down the slope; left out: 16 diameters");
    v.quantity("width", width, "m", "(0, inf)", "across; left out: 6 diameters");
    v.quantity("depth", depth, "m", "(0, inf)", "of the packing; left out: 4 diameters");
    v.quantity("rate", rate, "rad/s", "(0, inf)", "of the tilting");
    v.quantity("from", from, "rad", "[0, 1.57)", "tilted quickly up to here, in a tenth of the time");
    v.quantity("until", until, "rad", "(0, 1.5708]", "a packing that still lies there stops the test");
    v.quantity("slip", slip, "m", "(0, inf)", "of the grains' mean place; left out: a twentieth of a diameter");
  }

  static std::vector<Number> numbers() { return {{"angle", "rad", {}}}; }
  std::size_t specimens(std::size_t packings) const { return packings; }
  Outcome run(const Sample& sample, std::size_t packing) const;
  Findings findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const;
  /// Tilts what lies in the specimen.
  Outcome tilt(Specimen& specimen) const;
};

}  // namespace subsoil::sim
