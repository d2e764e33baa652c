#include "libsim/document/yaml_reader.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "libsim/base/input_limits.hpp"
#include "libsim/document/yaml_bounds.hpp"

namespace subsoil::sim {
namespace fs = std::filesystem;

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

}  // namespace

Node read_yaml(const std::string& file, Problems& problems) { return Builder(problems, {file}).file(file); }

Node parse_yaml(const std::string& text, const std::string& name, Problems& problems) {
  check_text(text, name);
  return Builder(problems, {name}).build(parse(text, name), "", 0);
}

std::optional<Node> parse_set(const std::string& set, const std::string& path, Problems& problems) {
  const std::string value = set.substr(set.find('=') + 1);
  check_text(set, Place::command_line);
  try {
    check_yaml_bounds(value, Place::command_line);
    return Builder(problems, {Place::command_line}).build(YAML::Load(value), path, 0);
  } catch (const YAML::Exception& e) {
    problems.add({Place::command_line, 0, 0}, path, value, "no YAML: " + e.msg);
    return {};
  }
}

std::string beside(const Place& place, const std::string& file) {
  const bool in_file = place.line > 0;  // a file named on the command line is sought from here
  const fs::path folder = in_file ? fs::path(place.file).parent_path() : fs::path{};
  return fs::weakly_canonical(fs::absolute(folder / file)).string();
}

}  // namespace subsoil::sim
