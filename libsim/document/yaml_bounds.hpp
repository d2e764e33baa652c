#pragma once
#include <string>

namespace subsoil::sim {

/// Reads YAML once without keeping it, and refuses what would cost too much to keep: more values, anchors or depth than
/// input_limits() allows, mappings with too many keys, names and values that are too long. `file` is for messages.
/// Throws ScenarioError with line, number found and limit, and YAML::Exception for what is no YAML.
void check_yaml_bounds(const std::string& text, const std::string& file);

}  // namespace subsoil::sim
