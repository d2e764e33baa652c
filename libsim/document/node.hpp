#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libsim/base/problems.hpp"

namespace subsoil::sim {

/// A value of a YAML tree in which every key and value knows where it stands.
struct Node {
  enum class Kind { null, scalar, sequence, mapping };
  struct Entry;

  Kind kind = Kind::null;
  std::string scalar;
  std::vector<Node> items;
  std::vector<Entry> entries;
  Place place;
  std::string comment;  // written before the entry by emit(); the reader ignores it
  bool flow = false;    // emit() on one line

  static Node of(std::string text);  // a scalar
  static Node list(bool flow = false);
  static Node mapping(bool flow = false);

  const Entry* find(std::string_view key) const;
  Entry* find(std::string_view key);
  Node& add(const std::string& key, Node value);  // appends; returns the new value
  std::string one_line() const;                   // short text for messages
};
struct Node::Entry {
  std::string key;
  Place place;
  Node value;
};

/// YAML text of a tree; comments of mapping entries above them.
std::string emit(const Node& node);

}  // namespace subsoil::sim
