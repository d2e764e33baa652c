#include "apps/commands/beam_words.hpp"

#include <fmt/format.h>

#include <numbers>

namespace subsoil::sim {

std::string beam_words(const BeamSection& beam) {
  const mbd::DividedBeam divided = mbd::divide(beam);
  double mass = 0;
  for (const mbd::Body& node : divided.nodes) mass += node.mass;
  const double first =
      mbd::first_frequency(beam.young, beam.density, divided.section, divided.length) / (2 * std::numbers::pi);
  std::string words = fmt::format("{}: {:.4g} m, {:.4g} kg, {} elements; as a straight cantilever {:.4g} Hz, ",
                                  beam.name, divided.length, mass, beam.elements, first);
  // Whatever holds the beam, waves of beta l = 0.4 to an element of length l are right to 1e-3:
  // docs/reference/beams.md.
  const double ratio = 0.4 * static_cast<double>(beam.elements) / 1.8751040687119611;
  if (ratio < 1) return words + "too few elements for its frequencies";
  return words + fmt::format("frequencies right to about 1e-3 up to {:.4g} Hz", first * ratio * ratio);
}

}  // namespace subsoil::sim
