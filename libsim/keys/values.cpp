#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "libsim/document/quantity.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/points_file.hpp"

/// The plain values: numbers, words, names, files. What is read and what is printed stand beside each other.
namespace subsoil::sim {
namespace {

namespace fs = std::filesystem;

// ---- numbers -------------------------------------------------------------------------------------------------------

/// A number that may be NaN, or an optional one.
class Quantity final : public Value {
 public:
  Quantity(double& value, const std::string& unit, const Range& range, bool optional)
      : number_(&value), unit_(unit), range_(range), optional_(optional) {}
  Quantity(std::optional<double>& value, const std::string& unit, const Range& range)
      : maybe_(&value), unit_(unit), range_(range), optional_(true) {}

  void read(const Node& node, const ReadScope& scope) override {
    const double read = numbers_of(node, unit_, 1, scope.n).front();
    check_range(read, range_, unit_, scope.field.cure);
    set(read);
  }
  void given() override {
    if (optional_) set(0);
  }
  bool supply(double value) override {
    set(value);
    return true;
  }
  std::optional<double> number() const override {
    const std::optional<double> held = maybe_ != nullptr ? *maybe_ : *number_;
    return held && !std::isnan(*held) ? held : std::nullopt;
  }
  Node print(const PrintScope& scope) const override {
    const std::optional<double> held = number();
    if (!held || (!optional_ && std::isinf(*held))) return {};
    if (scope.symbols && symbolic()) return Node::of(fmt::format("{} {}", *held, unit_));
    return Node::of(format_quantity(*held, unit_, scope.n));
  }
  std::string what() const override { return unit_; }
  Json schema() const override { return number_form(unit_, range_); }
  std::string range() const override { return std::string(range_.text()); }

 private:
  void set(double value) {
    if (maybe_ != nullptr) *maybe_ = value;
    if (number_ != nullptr) *number_ = value;
  }
  /// Powers of n, and the U that stands for a function's unit in the reference.
  bool symbolic() const { return unit_.find("(n") != std::string::npos || unit_.find('U') != std::string::npos; }

  double* number_ = nullptr;
  std::optional<double>* maybe_ = nullptr;
  const std::string& unit_;
  Range range_;
  bool optional_;
};

class QuantityOr final : public Value {
 public:
  QuantityOr(std::optional<double>& value, const char* word, const std::string& unit, const Range& range)
      : value_(value), word_(word), unit_(unit), range_(range) {}
  void read(const Node& node, const ReadScope&) override {
    if (scalar_of(node) == word_) {
      value_.reset();
      return;
    }
    const double read = parse_quantity(node.scalar, unit_);
    check_range(read, range_, unit_);
    value_ = read;
  }
  Node print(const PrintScope&) const override { return Node::of(value_ ? format_quantity(*value_, unit_) : word_); }
  std::string what() const override { return unit_; }
  Json schema() const override { return either({words_form({word_}), number_form(unit_, range_)}); }
  std::string range() const override { return fmt::format("{} or {}", range_.text(), word_); }

 private:
  std::optional<double>& value_;
  std::string word_;
  const std::string& unit_;
  Range range_;
};

class Quantities final : public Value {
 public:
  Quantities(std::vector<double>& values, const std::string& unit, const Range& range)
      : values_(values), unit_(unit), range_(range) {}
  void read(const Node& node, const ReadScope& scope) override {
    values_ = numbers_of(node, unit_, 0, scope.n);
    for (const double value : values_) check_range(value, range_, unit_);
  }
  Node print(const PrintScope&) const override {
    std::vector<std::string> texts;
    for (const double value : values_) texts.push_back(format_quantity(value, unit_));
    return texts.empty() ? Node{} : sequence(texts);
  }
  std::string what() const override { return fmt::format("list of {}", unit_); }
  Json schema() const override { return numbers_form(unit_, 0); }
  std::string range() const override { return std::string(range_.text()); }

 private:
  std::vector<double>& values_;
  const std::string& unit_;
  Range range_;
};

class Span final : public Value {
 public:
  Span(double& least, double& largest, const std::string& unit, const Range& range)
      : least_(least), largest_(largest), unit_(unit), range_(range) {}
  void read(const Node& node, const ReadScope& scope) override {
    const std::vector<double> both = numbers_of(node, unit_, 2, scope.n);
    for (const double value : both) check_range(value, range_, unit_);
    if (!(both[0] < both[1])) throw Refusal("the first number must be less than the second");
    least_ = both[0], largest_ = both[1];
  }
  Node print(const PrintScope&) const override {
    const double both[2]{least_, largest_};
    return std::isnan(least_) ? Node{} : Node::of(format_quantities(both, 2, unit_));
  }
  std::string what() const override { return fmt::format("2 numbers {}", unit_); }
  Json schema() const override { return numbers_form(unit_, 2); }
  std::string range() const override { return std::string(range_.text()); }

 private:
  double &least_, &largest_;
  const std::string& unit_;
  Range range_;
};

/// Components of a vector; `values` empty: none.
class Components : public Value {
 public:
  using Assign = std::function<void(const double*)>;
  Components(std::size_t size, std::vector<double> values, const std::string& unit, bool zero_when_given, Assign assign)
      : size_(size),
        values_(std::move(values)),
        unit_(unit),
        zero_when_given_(zero_when_given),
        assign_(std::move(assign)) {}
  void read(const Node& node, const ReadScope& scope) override {
    assign_(numbers_of(node, unit_, size_, scope.n).data());
  }
  void given() override {
    if (zero_when_given_) assign_(std::vector<double>(size_).data());
  }
  Node print(const PrintScope&) const override {
    const bool absent = values_.empty() || std::isnan(values_[0]);
    return absent ? Node{} : Node::of(format_quantities(values_.data(), size_, unit_));
  }
  std::string what() const override {
    return unit_ == "1" ? fmt::format("{} numbers", size_) : fmt::format("{} numbers {}", size_, unit_);
  }
  Json schema() const override { return numbers_form(unit_, size_); }

 protected:
  std::size_t size_;
  std::vector<double> values_;
  const std::string& unit_;
  bool zero_when_given_;
  Assign assign_;
};

class Downward final : public Components {
 public:
  using Components::Components;
  void read(const Node& node, const ReadScope& scope) override {
    const std::vector<double> numbers = numbers_of(node, unit_, 0, scope.n);
    if (numbers.size() != 1 && numbers.size() != 3) throw Refusal("must be one number (downward) or three");
    if (numbers.size() == 1 && numbers[0] < 0)
      throw Refusal(
          "must not be negative, since one number acts downward (-y); leave out the sign, or write three numbers");
    const double vector[3]{0, -numbers[0], 0};
    assign_(numbers.size() == 1 ? vector : numbers.data());
  }
  Json schema() const override { return either({number_form(unit_), numbers_form(unit_, 3)}); }
};

class Whole final : public Value {
 public:
  Whole(std::optional<long> held, const Range& range, std::function<void(long)> assign)
      : held_(held), range_(range), assign_(std::move(assign)) {}
  void read(const Node& node, const ReadScope& scope) override {
    assign_(whole_number(node, range_, scope.field.cure));
  }
  Node print(const PrintScope&) const override { return held_ ? Node::of(std::to_string(*held_)) : Node{}; }
  std::string what() const override { return "whole number"; }
  Json schema() const override { return number_form("1", range_); }
  std::string range() const override { return std::string(range_.text()); }

 private:
  std::optional<long> held_;
  Range range_;
  std::function<void(long)> assign_;
};

/// The format that this program reads.
class Version final : public Value {
 public:
  explicit Version(long& value) : value_(value) {}
  void read(const Node& node, const ReadScope&) override {
    value_ = whole_number(node, "[1, 1]", "this program reads format 1");
  }
  Node print(const PrintScope&) const override { return Node::of(std::to_string(value_)); }
  std::string what() const override { return "whole number"; }
  Json schema() const override { return words_form({"1"}); }

 private:
  long& value_;
};

/// The size of a unit: `mm`, or `25 mm`.
class UnitSize final : public Value {
 public:
  UnitSize(double& size, const std::string& expected) : size_(size), expected_(expected) {}
  void read(const Node& node, const ReadScope&) override {
    const std::string& text = scalar_of(node);
    const bool number_first = !text.empty() && text[0] >= '0' && text[0] <= '9';
    size_ = parse_quantity(number_first ? text : "1 " + text, expected_);
    check_range(size_, positive, expected_);
  }
  Node print(const PrintScope&) const override {
    return std::isnan(size_) ? Node{} : Node::of(format_quantity(size_, expected_));
  }
  std::string what() const override { return expected_; }
  Json schema() const override { return text_form(); }
  std::string range() const override { return std::string(positive.text()); }

 private:
  static constexpr Range positive{"(0, inf)"};
  double& size_;
  const std::string& expected_;
};

/// [[x, y], ...] or {x: y, ...}
Json table_form(const std::string& x_unit, const std::string& y_unit) {
  Json pair = list_form(Json::array({number_form(x_unit), number_form(y_unit)}), 2);
  return either({list_form(pair), {{"type", "object"}, {"additionalProperties", number_form(y_unit)}}});
}

class Table final : public Value {
 public:
  Table(std::vector<double>& xs, std::vector<double>& ys, const std::string& x_unit, const std::string& y_unit)
      : xs_(xs), ys_(ys), x_unit_(x_unit), y_unit_(y_unit) {}
  void read(const Node& node, const ReadScope& scope) override {
    if (node.kind == Node::Kind::mapping) {  // {8 mm: 0.3, 10 mm: 0.7}
      for (const Node::Entry& e : node.entries) {
        xs_.push_back(parse_quantity(e.key, x_unit_, scope.n));
        ys_.push_back(numbers_of(e.value, y_unit_, 1, scope.n).front());
      }
      return;
    }
    const std::string rule = fmt::format("must be a list of pairs such as [[1 {0}, 2 {1}], [3 {0}, 4 {1}]]",
                                         x_unit_ == "1" ? "" : x_unit_, y_unit_ == "1" ? "" : y_unit_);
    if (node.kind != Node::Kind::sequence) throw Refusal(rule);
    for (const Node& row : node.items) {
      if (row.kind != Node::Kind::sequence || row.items.size() != 2) throw Refusal(rule);
      xs_.push_back(numbers_of(row.items[0], x_unit_, 1, scope.n).front());
      ys_.push_back(numbers_of(row.items[1], y_unit_, 1, scope.n).front());
    }
  }
  Node print(const PrintScope&) const override {
    Node rows = Node::list(true);
    for (std::size_t i = 0; i < xs_.size(); ++i)
      rows.items.push_back(sequence({format_quantity(xs_[i], x_unit_), format_quantity(ys_[i], y_unit_)}));
    return xs_.empty() ? Node{} : rows;
  }
  std::string what() const override { return fmt::format("list of [{}, {}]", x_unit_, y_unit_); }
  Json schema() const override { return table_form(x_unit_, y_unit_); }

 private:
  std::vector<double>&xs_, &ys_;
  const std::string &x_unit_, &y_unit_;
};

class Outline final : public Value {
 public:
  explicit Outline(std::vector<Vec2>& points, std::size_t least = 3) : points_(points), least_(least) {}
  void read(const Node& node, const ReadScope& scope) override {
    if (node.kind == Node::Kind::scalar) {
      points_ = points_of_file(beside(node.place, node.scalar));
    } else {
      for (const Node* item : items_of(node)) {
        const std::vector<double> p = numbers_of(*item, "m", 2, scope.n);
        points_.push_back({p[0], p[1]});
      }
    }
    if (points_.size() < least_)
      throw Refusal(least_ == 3 ? "an outline needs at least three points" : "a line needs at least two points");
  }
  Node print(const PrintScope&) const override {
    std::vector<std::string> texts;
    for (const Vec2& p : points_) texts.push_back(format_quantities(p.data(), 2, "m"));
    return texts.empty() ? Node{} : sequence(texts);
  }
  std::string what() const override { return "list of 2 numbers m, or CSV file with the columns x [m], y [m]"; }
  Json schema() const override { return either({text_form(), list_form(numbers_form("m", 2))}); }

 private:
  std::vector<Vec2>& points_;
  std::size_t least_;
};

}  // namespace

void Fields::quantity(const char* key, double& value, Text unit, const Range& range, Text meaning, const char* cure) {
  Quantity quantity(value, unit, range, false);
  visit_value({key, meaning, std::isnan(value), unit, cure}, quantity);
}

void Fields::quantity(const char* key, std::optional<double>& value, Text unit, const Range& range, Text meaning,
                      const char* cure) {
  Quantity quantity(value, unit, range);
  visit_value({key, meaning, false, unit, cure}, quantity);
}

void Fields::optional_quantity(const char* key, double& value, Text unit, const Range& range, Text meaning,
                               const char* cure) {
  Quantity quantity(value, unit, range, true);
  visit_value({key, meaning, false, unit, cure}, quantity);
}

void Fields::exponent(const char* key, double& value, const Range& range, Text meaning) {
  const std::string none = "1";
  Quantity quantity(value, none, range, false);
  visit_value({.key = key, .meaning = meaning, .needed = std::isnan(value), .unit = none, .exponent = true}, quantity);
}

void Fields::quantity_or(const char* key, std::optional<double>& value, const char* word, Text unit, const Range& range,
                         Text meaning) {
  QuantityOr quantity(value, word, unit, range);
  visit_value({key, meaning}, quantity);
}

void Fields::quantities(const char* key, std::vector<double>& values, Text unit, const Range& range, Text meaning) {
  Quantities quantities(values, unit, range);
  visit_value({key, meaning}, quantities);
}

void Fields::span(const char* key, double& least, double& largest, Text unit, const Range& range, Text meaning) {
  Span span(least, largest, unit, range);
  visit_value({key, meaning, true, unit}, span);
}

void Fields::numbers(const char* key, const Numbers& held, Text unit, Text meaning, bool needed, bool zero_when_given,
                     std::function<void(const double*)> assign) {
  Components components(held.size, held.values, unit, zero_when_given, std::move(assign));
  visit_value({key, meaning, needed, unit}, components);
}

void Fields::downward(const char* key, Vec3& value, Text unit, Text meaning) {
  Downward downward(3, {value.x, value.y, value.z}, unit, false, [&value](const double* x) {
    value = {x[0], x[1], x[2]};
  });
  visit_value({key, meaning}, downward);
}

void Fields::whole(const Field& field, std::optional<long> held, const Range& range, std::function<void(long)> assign) {
  Whole whole(held, range, std::move(assign));
  visit_value(field, whole);
}

void Fields::version(const char* key, long& value, Text meaning) {
  Version version(value);
  visit_value({.key = key, .meaning = meaning, .needed = true, .if_missing = "a scenario starts with `subsoil: 1`"},
              version);
}

void Fields::unit(const char* key, double& size, Text expected, Text meaning) {
  UnitSize unit(size, expected);
  visit_value({.key = key, .meaning = meaning + ": `mm`, `m`, ...", .needed = std::isnan(size), .if_missing = meaning},
              unit);
}

void Fields::table(const char* key, std::vector<double>& xs, std::vector<double>& ys, Text x_unit, Text y_unit,
                   Text meaning) {
  Table table(xs, ys, x_unit, y_unit);
  visit_value({key, meaning, true}, table);
}

void Fields::outline(const char* key, std::vector<Vec2>& points, Text meaning) {
  Outline outline(points);
  visit_value({key, meaning, true}, outline);
}

void Fields::points(const char* key, std::vector<Vec2>& points, Text meaning) {
  Outline line(points, 2);
  visit_value({key, meaning, true}, line);
}

void Fields::optional_outline(const char* key, std::vector<Vec2>& points, Text meaning) {
  Outline outline(points);
  visit_value({key, meaning}, outline);
}

}  // namespace subsoil::sim
