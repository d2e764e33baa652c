#pragma once
#include <array>
#include <optional>

#include "libsim/studies/laboratory/findings.hpp"
#include "libsim/studies/laboratory/specimen.hpp"

namespace subsoil::sim {

/// A ball of soil, a clod, strikes a floor. It is cut out of a settled packing, lies without gravity and walls for
/// `rest`, then the floor comes at `speed`; after the floor has passed three of its diameters the pieces are counted.
/// Grains belong together when they are within reach of their law; where it has bonds, which form before the cutting,
/// when a bond joins them.
///     `largest`  share of the mass in the biggest piece
///     pieces     number of pieces of more than one grain
///     loose      share of the mass in single grains
///     before     maximum share before the strike: 1 for a clod that holds together
///     broken     share of the clod's bonds that the strike breaks; 0 without bonds
struct Shatter {
  std::optional<double> radius;
  double speed = 1, rest = 0.1;

  template <class V>
  void describe(V& v) {
    v.quantity("radius", radius, "m", "(0, inf)", "of the clod; left out: 4 diameters");
    v.quantity("speed", speed, "m/s", "(0, inf)", "of the strike; a fall from h has sqrt(2 g h)");
    v.quantity("rest", rest, "s", "[0, inf)", "between the cutting and the strike");
  }

  static std::vector<Number> numbers() {
    return {{"largest", "1", {}}, {"pieces", "1", {}}, {"loose", "1", {}}, {"before", "1", {}}, {"broken", "1", {}}};
  }
  std::size_t specimens(std::size_t packings) const { return packings; }
  Outcome run(const Sample& sample, std::size_t packing) const;
  Findings findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const;
};

/// Masses of the sets of spheres whose gaps are at most `reach`, biggest first; sizes the numbers of their spheres.
struct Pieces {
  std::vector<double> mass;
  std::vector<std::size_t> size;
};
Pieces pieces_of(std::span<const dem::Sphere> spheres, double reach);
/// The same where spheres are joined by pairs of their ids.
Pieces pieces_of(std::span<const dem::Sphere> spheres, std::span<const std::array<std::uint32_t, 2>> joined);

}  // namespace subsoil::sim
