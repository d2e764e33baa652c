#pragma once
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// A scenario file as a tree in which every key and value knows where it stands. Includes, anchors, merge keys and
/// `--set` are resolved here; what the keys mean is the reader's business. Faults are collected, not thrown one by one.
namespace subsoil::app {

/// Where something was written: a file's line and column (from 1), or the command line.
struct Place {
  std::string file;  // as the user named it; "--set" for the command line
  int line = 0, column = 0;
  std::string text() const;  // "till.yaml:41:9" or "--set"
};

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

/// All refusals of one reading, sorted by place. A line: `place path = value: rule; cure`.
class Problems {
 public:
  void add(const Place& place, const std::string& path, const std::string& rule);
  void add(const Place& place, const std::string& path, const std::string& value, const std::string& rule);
  bool empty() const { return found_.empty(); }
  std::size_t count() const { return found_.size(); }
  std::vector<std::string> lines() const;

 private:
  std::vector<std::pair<Place, std::string>> found_;
};

/// A scenario that cannot be taken: what() holds one line per fault.
struct ScenarioError : std::runtime_error {
  explicit ScenarioError(const Problems& problems);
  explicit ScenarioError(const std::string& line) : std::runtime_error(line), lines{line} {}
  std::vector<std::string> lines;
};

/// Reads a file with its includes, then applies `path=value` overrides. Syntax errors throw (nothing can be read past
/// them); everything else goes to `problems`.
Node read_document(const std::string& file, const std::vector<std::string>& sets, Problems& problems);
/// The same for text; `name` stands for the file in messages and its folder is where includes are sought.
Node parse_document(const std::string& text, const std::string& name, const std::vector<std::string>& sets,
                    Problems& problems);

/// YAML text of a tree; comments of mapping entries above them.
std::string emit(const Node& node);

/// Path of `file` as named in the file at `place`: beside it, absolute and normal.
std::string beside(const Place& place, const std::string& file);

/// The nearest of `known` within a third of the word's length; null: none.
const std::string* nearest(std::string_view word, const std::vector<std::string>& known);
/// "; did you mean `density`?" for the nearest of `known` within a third of the word's length, else "; known here:
/// ...".
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace subsoil::app
