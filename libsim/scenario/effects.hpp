#pragma once
#include <span>
#include <string>

#include "libsim/document/document.hpp"
#include "libsim/keys/reading.hpp"

/// Keys that act in some contexts only. One list serves the checker, which refuses a key where it has no effect, and
/// the writer, which leaves it out there.
namespace subsoil::sim {

struct Scenario;

struct ConditionalKey {
  const char* path;  ///< of the key: "soil.bed.seed"
  /// Whether a change of its value may change the run.
  bool (*acts)(const Scenario& s);
  const char* otherwise;  ///< why it has no effect: "the fill draws no random number"
  /// Without effect on the integrator chosen: taken where a command line chooses it.
  bool of_method = false;
};
std::span<const ConditionalKey> conditional_keys();

void check_effects(const Scenario& s, const Places& places, Problems& problems);
/// Takes the keys without effect out of a printed scenario.
void drop_without_effect(Node& document, const Scenario& s);

}  // namespace subsoil::sim
