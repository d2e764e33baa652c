#include "apps/commands/beam_words.hpp"

#include <fmt/format.h>

#include <numbers>

namespace subsoil::app {

std::string beam_words(const BeamSection& beam) {
  const mbd::DividedBeam divided = mbd::divide(beam);
  double mass = 0;
  for (const mbd::Body& node : divided.nodes) mass += node.mass;
  const double first =
      mbd::first_frequency(beam.young, beam.density, divided.section, divided.length) / (2 * std::numbers::pi);
  std::string words = fmt::format("{}: {:.4g} m, {:.4g} kg, {} elements; as a straight cantilever {:.4g} Hz, ",
                                  beam.name, divided.length, mass, beam.elements, first);
  // The k-th frequency is right to 1e-3 from 4 k elements on: docs/multibody.md.
  const long modes = beam.elements / 4;
  if (modes == 0) return words + "too few elements for its frequencies";
  const double root = (static_cast<double>(modes) - 0.5) * std::numbers::pi, ratio = root / 1.8751040687119611;
  return words +
         fmt::format("frequencies right to about 1e-3 up to {:.4g} Hz", modes == 1 ? first : first * ratio * ratio);
}

}  // namespace subsoil::app
