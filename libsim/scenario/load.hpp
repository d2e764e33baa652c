#pragma once
#include <map>
#include <string>
#include <vector>

#include "libsim/document/document.hpp"
#include "libsim/keys/former_keys.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

/// A scenario and where each of its keys stands, for refusals that come later, when it is built.
struct Loaded {
  Scenario scenario;
  std::map<std::string, Place> places;  // "soil.bed.radius", "contacts[0].K_X", "machine.joints.H8" -> place
  std::vector<FormerKey> former{};      // names of keys that are not theirs any more

  /// "till.yaml:41:9 soil.bed.radius" with the nearest enclosing key that stands in the file.
  std::string where(const std::string& path) const;
};

/// Reads, overrides and checks a scenario; throws ScenarioError with all faults.
Loaded load_scenario(const std::string& file, const std::vector<std::string>& sets = {});
Loaded load_scenario_text(const std::string& text, const std::string& name = "scenario.yaml",
                          const std::vector<std::string>& sets = {});

/// The scenario with every default explicit; reads back to the same structs. Comments at its end hold the checksums of
/// the files that were read with it, so that two texts are equal only where the files were.
std::string write_scenario(const Scenario& scenario);
/// The checksums in such a text, by path.
std::map<std::string, std::string> contents_in(const std::string& text);

/// A commented scenario to start from.
std::string new_scenario();

/// Unit, default, range and meaning of the key(s) at a path: `soil.contacts.wet.K_X`, `machine.bodies.shovel`, `K_X`.
/// Throws std::invalid_argument with the nearest known path.
std::string explain(const std::string& path);

/// docs/reference/keys.md: every key with unit, default, range and meaning.
std::string reference_markdown();

/// A JSON Schema for editors, of one of the files below.
std::string schema_text(const std::string& name);
/// "scenario", "part" (a file that scenarios include), and those of the commands.
std::vector<std::string> schema_names();

}  // namespace subsoil::sim
