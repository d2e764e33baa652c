#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "libsim/document/arithmetic.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/keys/former_keys.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/nodes.hpp"

/// Words, names and files.
namespace subsoil::sim {
namespace {

class Flag final : public Value {
 public:
  explicit Flag(bool& value) : value_(value) {}
  void read(const Node& node, const ReadScope&) override {
    const std::string& word = scalar_of(node);
    if (word != "yes" && word != "no" && word != "true" && word != "false") throw Refusal("must be yes or no");
    value_ = word == "yes" || word == "true";
  }
  Node print(const PrintScope&) const override { return Node::of(value_ ? "yes" : "no"); }
  std::string what() const override { return "yes/no"; }
  Json schema() const override { return words_form({"yes", "no", "true", "false"}); }

 private:
  bool& value_;
};

/// Text of any kind; empty: left out.
class PlainText : public Value {
 public:
  PlainText(std::string& value, std::string what) : value_(value), what_(std::move(what)) {}
  void read(const Node& node, const ReadScope&) override { value_ = scalar_of(node); }
  Node print(const PrintScope&) const override { return value_.empty() ? Node{} : Node::of(value_); }
  std::string what() const override { return what_; }
  Json schema() const override { return text_form(); }

 protected:
  std::string& value_;
  std::string what_;
};

class JoinedText final : public PlainText {
 public:
  using PlainText::PlainText;
  /// A list is its items with "; " between.
  void read(const Node& node, const ReadScope& scope) override {
    if (node.kind != Node::Kind::sequence) return PlainText::read(node, scope);
    value_.clear();
    for (const Node& item : node.items)
      value_ += fmt::format("{}{}", value_.empty() ? "" : "; ",
                            item.kind == Node::Kind::scalar ? item.scalar : item.one_line());
  }
  Json schema() const override { return either({text_form(), list_form(Json::object())}); }
};

class Name final : public PlainText {
 public:
  using PlainText::PlainText;
  void read(const Node& node, const ReadScope&) override {
    value_ = scalar_of(node);
    if (const char* wrong = name_fault(value_)) throw Refusal(wrong);
  }
};

const char* name_of(Family family) {
  switch (family) {
    case Family::material:
      return "name of a material";
    case Family::body:
      return "name of a body";
    case Family::joint:
      return "name of a joint";
    case Family::driver:
      return "name of a driver";
    case Family::force:
      return "name of a force";
  }
  return "name";
}

void refuse_empty(const std::string& name, Family family) {
  if (name.empty()) throw Refusal(fmt::format("is empty; give the {}", name_of(family)));
}

/// The name of what is declared elsewhere.
class Reference final : public PlainText {
 public:
  Reference(std::string& value, Family family) : PlainText(value, name_of(family)), family_(family) {}
  void read(const Node& node, const ReadScope&) override {
    value_ = scalar_of(node);
    refuse_empty(value_, family_);
  }

 private:
  Family family_;
};

class Level final : public PlainText {
 public:
  explicit Level(std::string& value) : PlainText(value, "text") {}
  void read(const Node& node, const ReadScope&) override {
    value_ = scalar_of(node);
    if (names_parameter(value_)) value_ = in_base_units(evaluate_arithmetic(value_));
  }
};

/// A file beside the scenario, as an absolute path.
class FileName final : public PlainText {
 public:
  FileName(std::string& value, bool must_exist) : PlainText(value, "file"), must_exist_(must_exist) {}
  void read(const Node& node, const ReadScope&) override {
    value_ = beside(node.place, scalar_of(node));
    if (must_exist_ && !std::filesystem::is_regular_file(value_))
      throw Refusal(fmt::format("there is no file {}", value_));
  }
  const std::string* input_file() const override { return must_exist_ ? &value_ : nullptr; }

 private:
  bool must_exist_;
};

/// One of several words, or a list of them.
class Chosen final : public Value {
 public:
  using Assign = std::function<void(const std::vector<std::size_t>&)>;
  Chosen(std::vector<std::string> words, std::vector<std::size_t> held, bool several, Assign assign)
      : words_(std::move(words)), held_(std::move(held)), several_(several), assign_(std::move(assign)) {}
  void read(const Node& node, const ReadScope&) override {
    std::vector<std::size_t> at;
    if (several_) {
      for (const Node* item : items_of(node)) at.push_back(index_of(*item));
    } else {
      at.push_back(index_of(node));
    }
    assign_(at);
  }
  Node print(const PrintScope&) const override {
    if (!several_) return Node::of(held_.empty() ? "" : words_[held_.front()]);
    std::vector<std::string> chosen;
    for (const std::size_t i : held_) chosen.push_back(words_[i]);
    return sequence(chosen);
  }
  std::string what() const override { return several_ ? "list of words" : "word"; }
  Json schema() const override {
    return several_ ? either({words_form(words_), list_form(words_form(words_))}) : words_form(words_);
  }
  std::string range() const override {
    std::string range;
    for (const std::string& word : words_) range += (range.empty() ? "" : " | ") + word;
    return range;
  }

 private:
  std::size_t index_of(const Node& node) const {
    const std::string& word = scalar_of(node);
    const auto named = [&](std::string_view one) { return std::find(words_.begin(), words_.end(), one); };
    auto found = named(word);
    if (found == words_.end()) found = named(present_of(word));
    // What YAML 1.1, as of a Python dict, makes of yes and no.
    if (found == words_.end() && (word == "true" || word == "false")) found = named(word == "true" ? "yes" : "no");
    if (found == words_.end()) throw Refusal("unknown word" + suggestion(word, words_));
    return static_cast<std::size_t>(found - words_.begin());
  }

  std::vector<std::string> words_;
  std::vector<std::size_t> held_;
  bool several_;
  Assign assign_;
};

class Pair final : public Value {
 public:
  Pair(std::array<std::string, 2>& value, Family family) : value_(value), family_(family) {}
  void read(const Node& node, const ReadScope&) override {
    if (node.kind != Node::Kind::sequence || node.items.size() != 2)
      throw Refusal("must be two names, such as [soil, steel]");
    value_ = {scalar_of(node.items[0]), scalar_of(node.items[1])};
    for (const std::string& name : value_) refuse_empty(name, family_);
  }
  Node print(const PrintScope&) const override { return value_[0].empty() ? Node{} : sequence({value_[0], value_[1]}); }
  std::string what() const override { return fmt::format("[{0}, {0}]", name_of(family_)); }
  Json schema() const override { return list_form(text_form(), 2); }

 private:
  std::array<std::string, 2>& value_;
  Family family_;
};

}  // namespace

void Fields::flag(const char* key, bool& value, Text meaning) {
  Flag flag(value);
  visit_value({key, meaning}, flag);
}

void Fields::text(const char* key, std::string& value, Text meaning) {
  PlainText text(value, "text");
  visit_value({key, meaning}, text);
}

void Fields::level(const char* key, std::string& value, Text meaning) {
  Level level(value);
  visit_value({key, meaning}, level);
}

void Fields::joined_text(const char* key, std::string& value, Text meaning) {
  JoinedText text(value, "text");
  visit_value({key, meaning}, text);
}

void Fields::name(const char* key, std::string& value, Text meaning) {
  Name name(value, "name");
  visit_value({key, meaning, true}, name);
}

void Fields::chosen(const char* key, std::vector<std::string> words, std::vector<std::size_t> held, Text meaning,
                    bool several, std::function<void(const std::vector<std::size_t>&)> assign) {
  Chosen chosen(std::move(words), std::move(held), several, std::move(assign));
  visit_value({key, meaning}, chosen);
}

void Fields::file(const char* key, std::string& value, Text meaning) {
  FileName file(value, true);
  visit_value({key, meaning, true}, file);
}

void Fields::optional_file(const char* key, std::string& value, Text meaning) {
  FileName file(value, true);
  visit_value({key, meaning}, file);
}

void Fields::output_file(const char* key, std::string& value, Text meaning) {
  FileName file(value, false);
  visit_value({key, meaning}, file);
}

void Fields::reference(const char* key, std::string& value, Family family, Text meaning) {
  Reference name(value, family);
  visit_value({key, meaning, true}, name);
}

void Fields::optional_reference(const char* key, std::string& value, Family family, Text meaning) {
  Reference name(value, family);
  visit_value({key, meaning}, name);
}

void Fields::pair(const char* key, std::array<std::string, 2>& value, Family family, Text meaning) {
  Pair pair(value, family);
  visit_value({key, meaning, true}, pair);
}

}  // namespace subsoil::sim
