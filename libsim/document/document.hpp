#pragma once
#include <string>
#include <vector>

#include "libsim/document/yaml_reader.hpp"

/// A scenario file as a tree. Includes, anchors, merge keys, `--set` and materials of the library are resolved here;
/// what the keys mean is the reader's business. Faults are collected, not thrown one by one.
namespace subsoil::sim {

/// Reads a file with its includes, then applies `path=value` overrides. Syntax errors throw (nothing can be read past
/// them); everything else goes to `problems`.
Node read_document(const std::string& file, const std::vector<std::string>& sets, Problems& problems);
/// The same for text; `name` stands for the file in messages and its folder is where includes are looked up.
Node parse_document(const std::string& text, const std::string& name, const std::vector<std::string>& sets,
                    Problems& problems);

/// The value that `path` of `--set` means, such as machine.bodies.stamp.mass, contacts[0].mu or contacts.soil-steel.mu;
/// nullptr where there is none.
const Node* find_path(const Node& root, const std::string& path);

/// Whether two paths of `--set` mean one value, or one the section that holds the other: `contacts[0].mu` and
/// `contacts.soil-steel.mu`, `machine.bodies.stamp` and `machine.bodies.stamp.mass`.
bool paths_meet(const Node& root, const std::string& one, const std::string& other);

}  // namespace subsoil::sim
