#include "libsim/document/library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "libsim/document/yaml_reader.hpp"

namespace subsoil::sim {
namespace {

constexpr std::string_view head = "library ";

std::string text_of(const Node& node, std::string_view key) {
  const Node::Entry* entry = node.find(key);
  return entry == nullptr ? "" : entry->value.scalar;
}

Node part_of(const Node& node, std::string_view key) {
  const Node::Entry* entry = node.find(key);
  return entry == nullptr ? Node{} : entry->value;
}

LibraryMaterial read_material(const std::string& name, const Node& node) {
  LibraryMaterial m{.name = name,
                    .what = text_of(node, "what"),
                    .source = text_of(node, "source"),
                    .remark = text_of(node, "remark"),
                    .radius = text_of(node, "radius"),
                    .material = part_of(node, "material"),
                    .law = part_of(node, "law"),
                    .steel = part_of(node, "steel"),
                    .tests = {}};
  for (const Node& test : part_of(node, "tests").items)
    m.tests.push_back({text_of(test, "number"), text_of(test, "wanted"), text_of(test, "measured")});
  return m;
}

std::vector<LibraryMaterial> read_library() {
  Problems problems;
  const Node document = parse_yaml(std::string(library_source()), "library.yaml", problems);
  if (!problems.empty()) throw ScenarioError(problems);
  std::vector<LibraryMaterial> out;
  for (const Node::Entry& e : document.find("materials")->value.entries) out.push_back(read_material(e.key, e.value));
  return out;
}

/// All of it stands where the scenario names the library.
Node placed(Node node, const Place& place) {
  node.place = place;
  for (Node& item : node.items) item = placed(std::move(item), place);
  for (Node::Entry& e : node.entries) e.place = place, e.value = placed(std::move(e.value), place);
  return node;
}

/// The name of the library's material that a value of `materials` asks for.
std::optional<std::string> wish_of(const Node& value) {
  if (value.kind == Node::Kind::mapping) {
    const Node::Entry* key = value.find("library");
    return key == nullptr ? std::nullopt : std::optional(key->value.scalar);
  }
  if (value.kind != Node::Kind::scalar) return {};
  const std::string word = value.scalar.substr(0, value.scalar.find(' '));
  if (word != "library") return {};
  const std::size_t begin = value.scalar.find_first_not_of(' ', word.size());
  return begin == std::string::npos ? "" : value.scalar.substr(begin);
}

/// A material of the scenario that the library has.
struct TakenMaterial {
  std::string name;
  const LibraryMaterial* material;
  Place place;
};

/// The one that was probably meant, else the first.
const LibraryMaterial& nearest_material(const std::string& name) {
  std::vector<std::string> known;
  for (const LibraryMaterial& m : library()) known.push_back(m.name);
  const std::string* near = nearest(name, known);
  return near == nullptr ? library().front() : library_material(*near);
}

void fill(Node& value, const LibraryMaterial& material) {
  const Place place = value.place;
  if (value.kind == Node::Kind::scalar) {
    value = Node::mapping();
    value.place = place;
    value.add("library", placed(Node::of(material.name), place));
  }
  for (const Node::Entry& e : material.material.entries)
    if (value.find(e.key) == nullptr) value.add(e.key, placed(e.value, place));
}

bool has_pair(const Node& contacts, const std::string& a, const std::string& b) {
  return std::any_of(contacts.items.begin(), contacts.items.end(), [&](const Node& contact) {
    const Node::Entry* between = contact.find("between");
    if (between == nullptr || between->value.items.size() != 2) return false;
    const std::string &one = between->value.items[0].scalar, &other = between->value.items[1].scalar;
    return (one == a && other == b) || (one == b && other == a);
  });
}

void add_pair(Node& contacts, const TakenMaterial& soil, const std::string& other, const Node& changes) {
  if (has_pair(contacts, soil.name, other)) return;
  Node contact = Node::mapping();
  Node between = Node::list(true);
  between.items = {Node::of(soil.name), Node::of(other)};
  contact.add("between", between);
  for (const Node::Entry& e : soil.material->law.entries) {
    const Node::Entry* change = changes.find(e.key);
    const Node& value = change == nullptr ? e.value : change->value;
    if (value.kind != Node::Kind::null) contact.add(e.key, value);  // `~` takes a key away
  }
  for (const Node::Entry& e : changes.entries)
    if (contact.find(e.key) == nullptr && e.value.kind != Node::Kind::null) contact.add(e.key, e.value);
  contacts.items.push_back(placed(std::move(contact), soil.place));
}

/// Soil with itself and with steel. Two different soils have no law of a source.
void add_contacts(Node& contacts, const std::vector<TakenMaterial>& taken) {
  for (const TakenMaterial& soil : taken) {
    if (!soil.material->is_soil()) continue;
    for (const TakenMaterial& other : taken)
      if (other.material == soil.material)
        add_pair(contacts, soil, other.name, {});
      else if (!other.material->is_soil())
        add_pair(contacts, soil, other.name, soil.material->steel);
  }
}

}  // namespace

const std::vector<LibraryMaterial>& library() {
  static const std::vector<LibraryMaterial> all = read_library();
  return all;
}

const LibraryMaterial& library_material(std::string_view name) {
  std::vector<std::string> known;
  for (const LibraryMaterial& m : library()) {
    if (m.name == name) return m;
    known.push_back(m.name);
  }
  throw std::invalid_argument(
      fmt::format("the library has no material of this name{}", suggestion(std::string(name), known)));
}

void take_from_library(Node& scenario, Problems& problems) {
  Node::Entry* const materials = scenario.find("materials");
  if (materials == nullptr) return;
  std::vector<TakenMaterial> taken;
  for (Node::Entry& e : materials->value.entries) {
    const std::optional<std::string> wish = wish_of(e.value);
    if (!wish) continue;
    try {
      const LibraryMaterial& material = library_material(*wish);
      fill(e.value, material);
      taken.push_back({e.key, &material, e.value.place});
    } catch (const std::invalid_argument& error) {
      problems.add(e.value.place, "materials." + e.key, e.value.one_line(),
                   std::string(error.what()) + "; `subsoil materials` lists them");
      // Said once: what the name would bring is no fault of its own.
      const LibraryMaterial& meant = nearest_material(*wish);
      e.value = placed(Node::of(meant.name), e.value.place);
      fill(e.value, meant);
      taken.push_back({e.key, &meant, e.value.place});
    }
  }
  if (taken.empty()) return;
  Node::Entry* contacts = scenario.find("contacts");
  if (contacts == nullptr) {
    scenario.add("contacts", placed(Node::list(), materials->place));
    contacts = scenario.find("contacts");
  }
  if (contacts->value.kind == Node::Kind::null) contacts->value.kind = Node::Kind::sequence;
  if (contacts->value.kind == Node::Kind::sequence) add_contacts(contacts->value, taken);
}

std::string library_table() {
  std::string out = fmt::format("{:<22} {:<8} {:<44} {}\n", "library", "radius", "is", "of the source / measured here");
  for (const LibraryMaterial& m : library()) {
    out += fmt::format("{:<22} {:<8} {:<44}", m.name, m.radius, m.what);
    bool first = true;
    for (const LibraryTest& t : m.tests) {
      if (t.wanted.empty()) continue;
      out += fmt::format("{}{}: {} / {}", first ? " " : "; ", t.number, t.wanted, t.measured);
      first = false;
    }
    out += "\n";
  }
  return out + "\nmaterials: {soil: library " + library().front().name +
         ", share: library steel} takes them, with their contact laws; `subsoil materials NAME` says more.\n";
}

std::string library_text(const LibraryMaterial& m) {
  std::string out = fmt::format("{}: {}\n", m.name, m.what);
  if (!m.source.empty()) out += "source: " + m.source + "\n";
  if (!m.remark.empty()) out += "remark: " + m.remark + "\n";
  if (!m.radius.empty()) out += fmt::format("for spheres of {} radius, equal or within a tenth of it\n", m.radius);
  const auto list = [&](const char* title, const Node& node) {
    if (node.entries.empty()) return;
    out += std::string(title) + ":\n";
    for (const Node::Entry& e : node.entries)
      out += fmt::format("  {}: {}\n", e.key, e.value.kind == Node::Kind::null ? "left out" : e.value.one_line());
  };
  list("material", m.material);
  list("law between its spheres", m.law);
  list("against steel otherwise", m.steel);
  if (m.tests.empty()) return out;
  out +=
      fmt::format("laboratory tests (`subsoil test NAME configs/laboratory/library.yaml`):\n  {:<28} {:>16} {:>24}\n",
                  "number", "of the source", "measured, 95 %");
  for (const LibraryTest& t : m.tests)
    out += fmt::format("  {:<28} {:>16} {:>24}\n", t.number, t.wanted.empty() ? "-" : t.wanted, t.measured);
  return out;
}

}  // namespace subsoil::sim
