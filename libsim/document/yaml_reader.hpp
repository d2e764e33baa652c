#pragma once
#include <optional>
#include <string>

#include "libsim/document/node.hpp"

/// YAML files as trees. Includes, anchors and merge keys are resolved here. Syntax errors throw ScenarioError, since
/// nothing can be read past them; everything else goes to `problems`.
namespace subsoil::sim {

Node read_yaml(const std::string& file, Problems& problems);
/// The same for text; `name` stands for the file in messages, and its folder is where includes are looked up.
Node parse_yaml(const std::string& text, const std::string& name, Problems& problems);

/// The value of an override `path=value`; empty where it is no YAML, which goes to `problems`.
std::optional<Node> parse_set(const std::string& set, const std::string& path, Problems& problems);

/// Path of `file` as named in the file at `place`: beside it, absolute and normal.
std::string beside(const Place& place, const std::string& file);

}  // namespace subsoil::sim
