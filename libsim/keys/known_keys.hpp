#pragma once
#include <string>
#include <vector>

namespace subsoil::sim {

/// One key of the reference.
struct KnownKey {
  std::string path;      // "machine.bodies.<name>.mass"
  std::string unit;      // of the value; for others what it is: "word", "yes/no", "text", "name of a body"
  std::string fallback;  // default; "required"; "left out"
  std::string range;     // interval or words to choose from
  std::string meaning;
};

/// Every key of a scenario, in the order of the declarations.
const std::vector<KnownKey>& known_keys();

/// The first path that ends with a key; empty when no scenario has it. Of an unknown key at `from` in the section
/// `test` only paths there, of any other only paths outside of it: the command takes nothing else.
std::string path_of_key(const std::string& key, const std::string& from);

}  // namespace subsoil::sim
