#include "libsim/document/yaml_bounds.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "libsim/base/input_limits.hpp"
#include "libsim/document/document.hpp"

namespace subsoil::sim {
namespace {

/// Counts what the parser meets; yaml-cpp's own tree takes ten times as long to build.
class Counter final : public YAML::EventHandler {
 public:
  explicit Counter(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1)
      throw ScenarioError(fmt::format(
          "{}:{}:{}: a second document begins; a scenario is one: take out the line of `---` or `...`, or "
          "put what follows into a file of its own; behind a list nothing follows: write [1 m, 2 m], or 1 2 m",
          file_, mark.line + 1, mark.column + 1));
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { value(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { value(mark), anchor(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& text) override {
    const bool key = !open_.empty() && open_.back().is_map && open_.back().values % 2 == 0;
    value(mark);
    const std::size_t most = key ? limits_.name_bytes : limits_.text_bytes;
    if (text.size() > most)
      refuse(mark, fmt::format("a {} of {} bytes; it may have {}", key ? "name" : "value", text.size(), most),
             key ? "name-bytes" : "text-bytes");
    if (tag.size() > limits_.name_bytes)
      refuse(mark, fmt::format("a tag of {} bytes; it may have {}", tag.size(), limits_.name_bytes), "name-bytes");
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark, false);
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark, true);
  }
  void OnMapEnd() override {
    const Level level = open_.back();
    open_.pop_back();
    if (level.values / 2 > limits_.keys)
      refuse(
          level.mark,
          fmt::format("the mapping holds {} keys; at most {} may stand in one mapping", level.values / 2, limits_.keys),
          "keys");
  }
  void OnAnchor(const YAML::Mark& mark, const std::string&) override { anchor(mark); }

 private:
  struct Level {
    YAML::Mark mark;
    bool is_map = false;
    std::size_t values = 0;  // keys are values too
  };

  [[noreturn]] void refuse(const YAML::Mark& mark, const std::string& what, const char* limit) const {
    throw ScenarioError(fmt::format("{}:{}:{}: {}{}", file_, mark.line + 1, mark.column + 1, what, allow_more(limit)));
  }
  void value(const YAML::Mark& mark) {
    if (!open_.empty()) ++open_.back().values;
    if (++values_ > limits_.values) refuse(mark, fmt::format("more than {} keys and values", limits_.values), "values");
  }
  void anchor(const YAML::Mark& mark) {
    if (++anchors_ > limits_.anchors)
      refuse(mark, fmt::format("more than {} anchors and aliases", limits_.anchors), "anchors");
  }
  void open(const YAML::Mark& mark, bool is_map) {
    value(mark);
    open_.push_back({mark, is_map});
    if (open_.size() > limits_.depth)
      refuse(mark, fmt::format("more than {} mappings and lists within each other", limits_.depth), "depth");
  }

  const InputLimits& limits_ = input_limits();
  std::string file_;
  std::vector<Level> open_;
  std::size_t documents_ = 0, values_ = 0, anchors_ = 0;
};

/// A directive (`%YAML 1.2`) and a tag say nothing here; yaml-cpp needs the square of their length, and takes a
/// directive amid the text for the document's end.
void check_lines(const std::string& text, const std::string& file) {
  constexpr std::size_t longest = 200;
  int line = 1;
  for (std::size_t begin = 0; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (text[begin] == '%' && end - begin > longest)
      throw ScenarioError(fmt::format("{}:{}:1: a directive of {} bytes; leave it out", file, line, end - begin));
    if (text[begin] == '%' && text.compare(begin, 6, "%YAML ") != 0 && text.compare(begin, 5, "%TAG ") != 0)
      throw ScenarioError(
          fmt::format("{}:{}:1: a line that begins with % is a directive of YAML, and this is none; a "
                      "comment begins with #",
                      file, line));
    begin = end + 1;
  }
}

}  // namespace

void check_yaml_bounds(const std::string& text, const std::string& file) {
  check_lines(text, file);
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Counter counter(file);
  while (parser.HandleNextDocument(counter)) {
  }
}

}  // namespace subsoil::sim
