#pragma once
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace subsoil::sim {

/// Where something was written: a file's line and column (from 1), or the command line.
struct Place {
  static constexpr const char* command_line = "--set";
  std::string file;  // as the user named it, or command_line
  int line = 0, column = 0;
  std::string text() const;  // "till.yaml:41:9" or "--set"
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

/// The nearest of `known`: one letter off, else the shortest that begins with the whole words given, else that within a
/// third of the word's length; null: none.
const std::string* nearest(std::string_view word, const std::vector<std::string>& known);
/// "; did you mean `density`?" for the nearest of `known`, else "; known here: ...".
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace subsoil::sim
