#include "libsim/document/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "libsim/document/library.hpp"

namespace subsoil::sim {
namespace {

// ---- --set path=value ----------------------------------------------------------------------------------------------

void place_everywhere(Node& node, const Place& place) {
  node.place = place;
  for (Node& item : node.items) place_everywhere(item, place);
  for (Node::Entry& e : node.entries) {
    e.place = place;
    place_everywhere(e.value, place);
  }
}

/// `soil.bed.radius`, `contacts[1].mu` or `contacts.1.mu` -> its parts.
std::vector<std::string> path_parts(const std::string& path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == '.' || c == '[') {
      if (!parts.back().empty()) parts.emplace_back();
    } else if (c != ']') {
      parts.back() += c;
    }
  }
  return parts;
}

/// The item of a list that a path means: its number, its `name`, or its pair of materials `soil-steel`.
const Node* list_item(const Node& list, const std::string& part) {
  std::size_t index = 0;
  const auto [end, code] = std::from_chars(part.data(), part.data() + part.size(), index);
  if (code == std::errc{} && end == part.data() + part.size()) {
    return index < list.items.size() ? &list.items[index] : nullptr;
  }
  for (const Node& item : list.items) {
    const Node::Entry* name = item.find("name");
    if (name != nullptr && name->value.scalar == part) return &item;
    const Node::Entry* between = item.find("between");
    if (between != nullptr && between->value.items.size() == 2) {
      const std::string &a = between->value.items[0].scalar, &b = between->value.items[1].scalar;
      if (part == a + "-" + b || part == b + "-" + a) return &item;
    }
  }
  return nullptr;
}

/// What a part of a path means in a list or mapping; null: there is none.
const Node* below(const Node& node, const std::string& part) {
  if (node.kind == Node::Kind::sequence) return list_item(node, part);
  const Node::Entry* const entry = node.find(part);
  return entry == nullptr ? nullptr : &entry->value;
}

void apply_set(Node& root, const std::string& set, Problems& problems) {
  const Place place{Place::command_line, 0, 0};
  const std::size_t equals = set.find('=');
  if (equals == std::string::npos || equals == 0) {
    problems.add(place, set, "must be path=value, such as soil.bed.radius=\"12 mm\"");
    return;
  }
  const std::string path = set.substr(0, equals);
  if (const std::size_t dash = set.find_first_not_of(' ', equals + 1);
      dash != std::string::npos && set[dash] == '-' && dash + 1 < set.size() && set[dash + 1] == ' ') {
    problems.add(place, path, "a dash and a blank begin a list: write -1 m for a negative value, [1 m] for a list");
    return;
  }
  std::optional<Node> given = parse_set(set, path, problems);
  if (!given) return;
  Node& value = *given;
  place_everywhere(value, place);
  Node* node = &root;
  for (const std::string& part : path_parts(path)) {
    if (node->kind == Node::Kind::sequence) {
      Node* const item = const_cast<Node*>(list_item(*node, part));
      if (item == nullptr) {
        problems.add(place, path,
                     fmt::format("the list has no item `{}`; it has {}, counted from 0", part, node->items.size()));
        return;
      }
      node = item;
      continue;
    }
    if (node->kind == Node::Kind::scalar) {
      problems.add(place, path, fmt::format("`{}` is a value without parts here", node->scalar));
      return;
    }
    Node::Entry* entry = node->find(part);
    if (entry == nullptr) {
      node->kind = Node::Kind::mapping;
      node->entries.push_back({part, place, Node{}});
      node->entries.back().value.place = place;
      entry = &node->entries.back();
    }
    node = &entry->value;
  }
  *node = std::move(value);
}

/// Of a path such as `materials.soil` or `materials.soil.library`, which decide what the library brings.
bool chooses_material(const std::string& set) {
  const std::vector<std::string> parts = path_parts(set.substr(0, set.find('=')));
  return !parts.empty() && parts[0] == "materials" &&
         (parts.size() <= 2 || (parts.size() == 3 && parts[2] == "library"));
}

/// The short form `soil: library clay-10mm` has no key `library`: the set then means the whole value.
std::string of_short_form(const Node& root, const std::string& set) {
  const std::size_t equals = set.find('=');
  const std::vector<std::string> parts = path_parts(set.substr(0, equals));
  if (parts.size() != 3 || equals == std::string::npos) return set;
  const Node::Entry* materials = root.find("materials");
  const Node::Entry* of = materials == nullptr ? nullptr : materials->value.find(parts[1]);
  if (of == nullptr || of->value.kind != Node::Kind::scalar) return set;
  return "materials." + parts[1] + "=library " + set.substr(equals + 1);
}

Node finish(Node root, const std::string& name, const std::vector<std::string>& sets, Problems& problems) {
  if (root.kind == Node::Kind::null) root.kind = Node::Kind::mapping;
  if (root.kind != Node::Kind::mapping) {
    throw ScenarioError(fmt::format("{}: is no scenario; a scenario is a mapping that starts with `subsoil: 1`", name));
  }
  if (root.place.line == 0) root.place = {name, 1, 1};
  // First what decides which materials the library gives, so that its laws are those of the material chosen; the rest
  // after, since a path may lead to what was taken; and once more, for materials that such a path brings.
  for (const std::string& set : sets)
    if (chooses_material(set)) apply_set(root, of_short_form(root, set), problems);
  take_from_library(root, problems);
  for (const std::string& set : sets)
    if (!chooses_material(set)) apply_set(root, set, problems);
  if (!sets.empty()) take_from_library(root, problems);
  return root;
}

}  // namespace

const Node* find_path(const Node& root, const std::string& path) {
  const Node* node = &root;
  for (const std::string& part : path_parts(path))
    if ((node = below(*node, part)) == nullptr) break;
  return node;
}

bool paths_meet(const Node& root, const std::string& one, const std::string& other) {
  // Items of lists by their number, whatever they are named by.
  const auto plain = [&](const std::string& path) {
    std::vector<std::string> parts = path_parts(path);
    const Node* node = &root;
    for (std::string& part : parts) {
      const Node* const inside = below(*node, part);
      if (inside == nullptr) break;
      if (node->kind == Node::Kind::sequence) part = std::to_string(inside - node->items.data());
      node = inside;
    }
    return parts;
  };
  const std::vector<std::string> a = plain(one), b = plain(other);
  return std::equal(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(std::min(a.size(), b.size())), b.begin());
}

Node read_document(const std::string& file, const std::vector<std::string>& sets, Problems& problems) {
  return finish(read_yaml(file, problems), file, sets, problems);
}

Node parse_document(const std::string& text, const std::string& name, const std::vector<std::string>& sets,
                    Problems& problems) {
  return finish(parse_yaml(text, name, problems), name, sets, problems);
}

}  // namespace subsoil::sim
