#include "apps/scenario/document.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>
#include <tuple>

#include "apps/input_limits.hpp"
#include "apps/scenario/library.hpp"
#include "apps/scenario/yaml_bounds.hpp"

namespace subsoil::app {
namespace fs = std::filesystem;

std::string Place::text() const { return line > 0 ? fmt::format("{}:{}:{}", file, line, column) : file; }

Node Node::of(std::string text) {
  Node node;
  node.kind = Kind::scalar;
  node.scalar = std::move(text);
  return node;
}
Node Node::list(bool flow) {
  Node node;
  node.kind = Kind::sequence;
  node.flow = flow;
  return node;
}
Node Node::mapping(bool flow) {
  Node node;
  node.kind = Kind::mapping;
  node.flow = flow;
  return node;
}

const Node::Entry* Node::find(std::string_view key) const {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.key == key; });
  return found == entries.end() ? nullptr : &*found;
}
Node::Entry* Node::find(std::string_view key) { return const_cast<Entry*>(static_cast<const Node&>(*this).find(key)); }
Node& Node::add(const std::string& key, Node value) {
  kind = Kind::mapping;
  entries.push_back({key, value.place, std::move(value)});
  return entries.back().value;
}

std::string Node::one_line() const {
  std::string text;
  if (kind == Kind::scalar) {
    text = scalar;
  } else if (kind == Kind::null) {
    text = "(nothing)";
  } else if (kind == Kind::sequence) {
    text = "[";
    for (const Node& item : items) text += (text.size() > 1 ? ", " : "") + item.one_line();
    text += "]";
  } else {
    text = "{";
    for (const Entry& e : entries)
      text += fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", e.key, e.value.one_line());
    text += "}";
  }
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

void Problems::add(const Place& place, const std::string& path, const std::string& rule) {
  found_.emplace_back(place, fmt::format("{} {}: {}", place.text(), path, rule));
}
void Problems::add(const Place& place, const std::string& path, const std::string& value, const std::string& rule) {
  found_.emplace_back(place, fmt::format("{} {} = {}: {}", place.text(), path, value, rule));
}

std::vector<std::string> Problems::lines() const {
  std::map<std::string, std::size_t> files;  // in the order in which they first came up
  for (const auto& [place, line] : found_) files.emplace(place.file, files.size());
  const auto key = [&](const Place& p) { return std::tuple{files.at(p.file), p.line, p.column}; };
  auto sorted = found_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const auto& a, const auto& b) { return key(a.first) < key(b.first); });
  std::vector<std::string> lines;
  for (auto& [place, line] : sorted) lines.push_back(std::move(line));
  return lines;
}

ScenarioError::ScenarioError(const Problems& problems)
    : std::runtime_error(fmt::format("{}", fmt::join(problems.lines(), "\n"))), lines(problems.lines()) {}

namespace {

/// Length of the UTF-8 character that `text` begins with; 0: none, or one that has no place in text.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
  const unsigned a = byte(0), b = byte(1);
  if (a < 0x80) return a >= 0x20 || a == '\t' || a == '\n' || a == '\r' ? 1 : 0;
  if (a >= 0xC2 && a <= 0xDF) return follows(1) ? 2 : 0;
  if (a >= 0xE0 && a <= 0xEF) {
    const bool overlong = a == 0xE0 && b < 0xA0, surrogate = a == 0xED && b > 0x9F;
    return !overlong && !surrogate && follows(1) && follows(2) ? 3 : 0;
  }
  if (a >= 0xF0 && a <= 0xF4) {
    const bool overlong = a == 0xF0 && b < 0x90, beyond = a == 0xF4 && b > 0x8F;
    return !overlong && !beyond && follows(1) && follows(2) && follows(3) ? 4 : 0;
  }
  return 0;
}

/// Names and titles go into results that others read: CSV, XDMF, HDF5.
void check_text(std::string_view text, const std::string& name) {
  int line = 1, column = 1;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text.substr(i));
    if (length == 0)
      throw ScenarioError(
          fmt::format("{}:{}:{}: holds the byte 0x{:02X}, which is no UTF-8 text; save the file as UTF-8", name, line,
                      column, static_cast<unsigned char>(text[i])));
    line += text[i] == '\n' ? 1 : 0;
    column = text[i] == '\n' ? 1 : column + 1;
    i += length;
  }
}

// ---- yaml-cpp -> Node ----------------------------------------------------------------------------------------------

class Builder {
 public:
  Builder(Problems& problems, std::vector<std::string> files) : problems_(problems), files_(std::move(files)) {}

  Node build(const YAML::Node& yaml, const std::string& path, std::size_t depth) {
    Node node;
    node.place = place(yaml.Mark());
    if (++values_ > limits_.values)
      throw ScenarioError(fmt::format("{} {}: more than {} keys and values; are aliases nested in aliases?",
                                      node.place.text(), path, limits_.values));
    if (depth > limits_.depth)
      throw ScenarioError(
          fmt::format("{}: nested deeper than {}; does an anchor hold itself?", node.place.text(), limits_.depth));
    if (yaml.IsScalar()) {
      node.kind = Node::Kind::scalar;
      node.scalar = yaml.Scalar();
      check_scalar(node, path);
    } else if (yaml.IsSequence()) {
      node.kind = Node::Kind::sequence;
      for (std::size_t i = 0; i < yaml.size(); ++i) {
        node.items.push_back(build(yaml[i], fmt::format("{}[{}]", path, i), depth + 1));
      }
    } else if (yaml.IsMap()) {
      node.kind = Node::Kind::mapping;
      build_mapping(yaml, path, depth, node);
    }
    return node;
  }

  Node file(const std::string& name);

 private:
  /// An escape such as "\x01" makes what the file itself may not hold.
  static void check_scalar(const Node& node, const std::string& path) {
    for (std::size_t i = 0; i < node.scalar.size();) {
      const std::size_t length = character_length(std::string_view(node.scalar).substr(i));
      if (length == 0)
        throw ScenarioError(fmt::format("{} {}: holds the control character 0x{:02X}; leave it out", node.place.text(),
                                        path, static_cast<unsigned char>(node.scalar[i])));
      i += length;
    }
  }
  Place place(const YAML::Mark& mark) const { return {files_.back(), mark.line + 1, mark.column + 1}; }

  void build_mapping(const YAML::Node& yaml, const std::string& path, std::size_t depth, Node& node) {
    std::vector<Node> merged, included;
    for (const auto& pair : yaml) {
      const Place at = place(pair.first.Mark());
      if (!pair.first.IsScalar()) {
        problems_.add(at, path.empty() ? "(top)" : path, "a key must be a plain word");
        continue;
      }
      const std::string key = pair.first.Scalar();
      const std::string here = path.empty() ? key : path + "." + key;
      Node value = build(pair.second, key == "<<" ? path : here, depth + 1);
      if (value.kind == Node::Kind::null) value.place = at;
      if (key == "<<") {
        merge_key(value, here, merged);
      } else if (key == "include") {
        include(value, here, included);
      } else if (const Node::Entry* first = node.find(key)) {
        problems_.add(at, here, fmt::format("stands twice; first in line {}", first->place.line));
      } else {
        node.entries.push_back({key, at, std::move(value)});
      }
    }
    // Own keys win over merged anchors (shallow, as YAML has it), these over included files (key by key, in depth).
    for (const Node& other : merged) {
      for (const Node::Entry& e : other.entries) {
        if (node.find(e.key) == nullptr) node.entries.push_back(e);
      }
    }
    for (const Node& other : included) merge_deep(node, other);
  }

  /// A key without value (`H9:` or `H9: ~`) takes an included one away.
  static void merge_deep(Node& into, const Node& from) {
    for (const Node::Entry& e : from.entries) {
      Node::Entry* own = into.find(e.key);
      if (own == nullptr) {
        into.entries.push_back(e);
      } else if (own->value.kind == Node::Kind::mapping && e.value.kind == Node::Kind::mapping) {
        merge_deep(own->value, e.value);
      } else if (own->value.kind == Node::Kind::null) {
        std::erase_if(into.entries, [&](const Node::Entry& x) { return x.key == e.key; });
      }
    }
  }

  void merge_key(const Node& value, const std::string& path, std::vector<Node>& merged) {
    if (value.kind == Node::Kind::mapping) {
      merged.push_back(value);
    } else if (value.kind == Node::Kind::sequence) {
      for (const Node& item : value.items) merge_key(item, path, merged);
    } else {
      problems_.add(value.place, path, "must be an anchored mapping, such as *rig");
    }
  }

  void include(const Node& value, const std::string& path, std::vector<Node>& included) {
    if (value.kind == Node::Kind::sequence) {
      for (const Node& item : value.items) include(item, path, included);
      return;
    }
    if (value.kind != Node::Kind::scalar) {
      problems_.add(value.place, path, "must be a file name or a list of them");
      return;
    }
    const fs::path file = (fs::path(files_.back()).parent_path() / value.scalar).lexically_normal();
    for (const std::string& open : files_) {
      if (fs::weakly_canonical(open) == fs::weakly_canonical(file)) {
        problems_.add(value.place, path, value.scalar, "includes itself");
        return;
      }
    }
    if (!fs::is_regular_file(file)) {
      problems_.add(value.place, path, value.scalar, "there is no such file beside " + files_.back());
      return;
    }
    files_.push_back(file.string());
    Node node = this->file(file.string());
    files_.pop_back();
    if (node.kind == Node::Kind::mapping) {
      included.push_back(std::move(node));
    } else {
      problems_.add(value.place, path, value.scalar, "must hold a mapping (key: value lines)");
    }
  }

  Problems& problems_;
  const InputLimits& limits_ = input_limits();
  std::vector<std::string> files_;                 // the chain of includes, the innermost last
  std::size_t values_ = 0, bytes_ = 0, read_ = 0;  // so far: values built, bytes and files read
};

/// What is probably meant where a line is no YAML.
std::string cure_of_line(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string here;
  for (int k = 0; k <= line && std::getline(lines, here); ++k) {
  }
  const std::size_t indent = here.find_first_not_of(" \t");
  if (indent != std::string::npos && here.substr(0, indent).find('\t') != std::string::npos)
    return "; the line is indented with a tab, YAML takes blanks only";
  const std::size_t colon = here.find(": ");
  if (colon != std::string::npos && here.find(": ", colon + 2) != std::string::npos &&
      here.find_first_of("{[\"'", 0) == std::string::npos)
    return fmt::format("; put text with a colon in quotes: {}: \"{}\"", here.substr(0, colon), here.substr(colon + 2));
  return {};
}

YAML::Node parse(const std::string& text, const std::string& name) {
  try {
    check_yaml_bounds(text, name);
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw ScenarioError(fmt::format("{}:{}:{}: no YAML: {}{}", name, e.mark.line + 1, e.mark.column + 1, e.msg,
                                    cure_of_line(text, e.mark.line)));
  }
}

/// @param most bytes that may still be read
std::string contents(const std::string& file, std::size_t most) {
  if (fs::is_directory(file)) throw ScenarioError(fmt::format("{}: is a folder; name a scenario file", file));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ScenarioError(fmt::format("{}: cannot be opened; check the name and its permissions", file));
  std::string text(most + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > most)
    throw ScenarioError(
        fmt::format("{}: is too long: a scenario and what it includes may have {} bytes together; keep "
                    "tables and meshes in files of their own{}",
                    file, input_limits().scenario_bytes, allow_more("scenario-bytes")));
  check_text(text, file);
  return text;
}

Node Builder::file(const std::string& name) {
  if (++read_ > limits_.files)
    throw ScenarioError(fmt::format("{}: is the {}th file of this scenario; at most {} may be included{}", name, read_,
                                    limits_.files, allow_more("files")));
  const std::string text = contents(name, limits_.scenario_bytes - bytes_);
  bytes_ += text.size();
  return build(parse(text, name), "", 0);
}

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
Node* list_item(Node& list, const std::string& part) {
  std::size_t index = 0;
  const auto [end, code] = std::from_chars(part.data(), part.data() + part.size(), index);
  if (code == std::errc{} && end == part.data() + part.size()) {
    return index < list.items.size() ? &list.items[index] : nullptr;
  }
  for (Node& item : list.items) {
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

void apply_set(Node& root, const std::string& set, Problems& problems) {
  const Place place{"--set", 0, 0};
  const std::size_t equals = set.find('=');
  if (equals == std::string::npos || equals == 0) {
    problems.add(place, set, "must be path=value, such as soil.bed.radius=\"12 mm\"");
    return;
  }
  const std::string path = set.substr(0, equals);
  check_text(set, "--set");
  Node value;
  try {
    check_yaml_bounds(set.substr(equals + 1), "--set");
    value = Builder(problems, {"--set"}).build(YAML::Load(set.substr(equals + 1)), path, 0);
  } catch (const YAML::Exception& e) {
    problems.add(place, path, set.substr(equals + 1), "no YAML: " + e.msg);
    return;
  }
  place_everywhere(value, place);
  Node* node = &root;
  for (const std::string& part : path_parts(path)) {
    if (node->kind == Node::Kind::sequence) {
      Node* item = list_item(*node, part);
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

// ---- Node -> YAML --------------------------------------------------------------------------------------------------

/// Plain unless YAML would take it for something else.
std::string quoted(const std::string& text) {
  static constexpr std::string_view special = ":{}[],&*#?|-<>=!%@`\"'\\\n\t";
  const bool number_like = !text.empty() && (text[0] == '-' || text[0] == '+') && text.size() > 1 && text[1] != ' ';
  bool plain = !text.empty() && text.front() != ' ' && text.back() != ' ' && text != "~" && text != "null";
  for (std::size_t i = 0; plain && i < text.size(); ++i) {
    const bool inside = i > 0 && (text[i] == '-' || text[i] == '%' || text[i] == '=' || text[i] == '\'');
    if (special.find(text[i]) != std::string_view::npos && !inside && !(i == 0 && number_like)) plain = false;
  }
  if (plain) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (c == '\n') {
      result += "\\n";
    } else if (c == '\t') {
      result += "\\t";
    } else {
      result += c;
    }
  }
  return result + "\"";
}

std::string flow_text(const Node& node) {
  if (node.kind == Node::Kind::scalar) return quoted(node.scalar);
  if (node.kind == Node::Kind::null) return "~";
  std::vector<std::string> parts;
  for (const Node& item : node.items) parts.push_back(flow_text(item));
  for (const Node::Entry& e : node.entries) parts.push_back(quoted(e.key) + ": " + flow_text(e.value));
  const bool list = node.kind == Node::Kind::sequence;
  return fmt::format("{}{}{}", list ? '[' : '{', fmt::join(parts, ", "), list ? ']' : '}');
}

void block_text(const Node& node, int indent, bool first_inline, std::string& out) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  bool first = first_inline;
  const auto lead = [&] { return std::exchange(first, false) ? std::string{} : margin; };
  for (const Node& item : node.items) {
    out += lead() + "- ";
    const bool flow = item.flow || item.kind == Node::Kind::scalar || (item.items.empty() && item.entries.empty());
    if (flow) {
      out += flow_text(item) + "\n";
    } else {
      block_text(item, indent + 2, true, out);
    }
  }
  for (const Node::Entry& e : node.entries) {
    const Node& value = e.value;
    const bool flow = value.flow || value.kind == Node::Kind::scalar || (value.items.empty() && value.entries.empty());
    std::string line = quoted(e.key) + ":" + (flow ? " " + flow_text(value) : "");
    if (!value.comment.empty()) {
      const std::size_t width = line.size() < 40 ? 40 - line.size() : 1;
      line += std::string(width, ' ') + "# " + value.comment;
    }
    out += lead() + line + "\n";
    if (!flow) block_text(value, indent + 2, false, out);
  }
}

/// Levenshtein distance: letters to change, add or drop.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, change}));
    }
  }
  return row.back();
}

}  // namespace

Node read_document(const std::string& file, const std::vector<std::string>& sets, Problems& problems) {
  return finish(Builder(problems, {file}).file(file), file, sets, problems);
}

Node parse_document(const std::string& text, const std::string& name, const std::vector<std::string>& sets,
                    Problems& problems) {
  check_text(text, name);
  return finish(Builder(problems, {name}).build(parse(text, name), "", 0), name, sets, problems);
}

std::string emit(const Node& node) {
  std::string text;
  block_text(node, 0, false, text);
  return text;
}

std::string beside(const Place& place, const std::string& file) {
  const bool in_file = place.line > 0;  // a file named on the command line is sought from here
  const fs::path folder = in_file ? fs::path(place.file).parent_path() : fs::path{};
  return fs::weakly_canonical(fs::absolute(folder / file)).string();
}

const std::string* nearest(std::string_view word, const std::vector<std::string>& known) {
  const std::string* found = nullptr;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t d = distance(word, candidate);
    if (d < least) {
      least = d;
      found = &candidate;
    }
  }
  return found;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  if (const std::string* near = nearest(word, known)) return fmt::format("; did you mean `{}`?", *near);
  if (known.empty()) return "; none are known here";
  return fmt::format("; known here: {}", fmt::join(known, ", "));
}

}  // namespace subsoil::app
