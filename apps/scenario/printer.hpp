#pragma once
#include <cmath>
#include <concepts>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "apps/scenario/declarations.hpp"
#include "apps/scenario/document.hpp"
#include "apps/scenario/families.hpp"
#include "libmbd/characteristic.hpp"
#include "libmbd/coordinate.hpp"

/// The visitor of the declarations that prints: a struct's values as a document (the explicit copy, `new`), or a type's
/// keys as rows (`explain`, docs). One class, because a default is a value printed; long, because it answers every word
/// of the vocabulary, most of them in a line or two.
namespace subsoil::app {

/// One key of the reference.
struct Row {
  std::string path;      // "machine.bodies.<name>.mass"
  std::string unit;      // of the value; for others what it is: "word", "yes/no", "text", "name of a body"
  std::string fallback;  // default; "required"; "left out"
  std::string range;     // interval or words to choose from
  std::string meaning;
};

/// Word and meaning on a type's card.
struct Card {
  std::string word, meaning;
};
template <class T>
const Card& card_of();

/// Every key of a scenario, in the order of the declarations.
const std::vector<Row>& reference_rows();

class Printer {
 public:
  /// Prints values below `node`.
  Printer(Node& node, bool comments) : node_(&node), comments_(comments) {}
  /// Lists keys below `path`.
  Printer(std::vector<Row>& rows, std::string path) : rows_(&rows), path_(std::move(path)) {}

  std::string word, word_meaning;  // of the last card

  void card(const char* w, const char* m) { word = w, word_meaning = m; }

  // -- values --
  void quantity(const char* key, double& value, const std::string& unit, const std::string& range,
                const std::string& meaning);
  void quantity(const char* key, std::optional<double>& value, const std::string& unit, const std::string& range,
                const std::string& meaning);
  void optional_quantity(const char* key, double& value, const std::string& unit, const std::string& range,
                         const std::string& meaning);
  void derived(const char* key, double& value, const std::string& unit, const std::string& range,
               const std::string& meaning) {
    optional_quantity(key, value, unit, range, meaning);
  }
  void quantity_or(const char* key, std::optional<double>& value, const char* other, const char* unit,
                   const char* range, const char* meaning);
  void quantities(const char* key, std::vector<double>& values, const char* unit, const char* range,
                  const char* meaning);
  void span(const char* key, double& least, double& largest, const char* unit, const char* range, const char* meaning);
  template <class Vector>
  void vector(const char* key, Vector& value, const std::string& unit, const std::string& meaning) {
    constexpr std::size_t size = std::is_same_v<Vector, Vec3> ? 3 : sizeof(Vector) / sizeof(double);
    numbers(key, numbers_of(value, size), unit, size, std::isnan(value[0]), meaning);
  }
  template <class Vector>
  void vector(const char* key, std::optional<Vector>& value, const std::string& unit, const std::string& meaning) {
    constexpr std::size_t size = std::is_same_v<Vector, Vec3> ? 3 : sizeof(Vector) / sizeof(double);
    numbers(key, value ? numbers_of(*value, size) : std::vector<double>{}, unit, size, false, meaning);
  }
  void downward(const char* key, Vec3& value, const char* unit, const char* meaning) {
    vector(key, value, unit, meaning);
  }
  template <class Int>
  requires std::integral<Int>
  void count(const char* key, Int& value, const char* range, const char* meaning) {
    leaf(key, Node::of(std::to_string(value)), "whole number", range, meaning);
  }
  void count(const char* key, std::optional<long>& value, const char* range, const char* meaning) {
    leaf(key, value ? Node::of(std::to_string(*value)) : Node{}, "whole number", range, meaning);
  }
  void version(const char* key, long& value, const char* meaning) {
    leaf(key, Node::of(std::to_string(value)), "whole number", "", meaning, true);
  }
  void flag(const char* key, bool& value, const char* meaning) {
    leaf(key, Node::of(value ? "yes" : "no"), "yes/no", "", meaning);
  }
  void text(const char* key, std::string& value, const char* meaning) { name_like(key, value, "text", meaning, false); }
  void name(const char* key, std::string& value, const char* meaning) { name_like(key, value, "name", meaning, true); }
  template <class E>
  void choice(const char* key, E& value, std::initializer_list<std::pair<const char*, std::type_identity_t<E>>> words,
              const char* meaning) {
    leaf(key, Node::of(word_of<E>(value, words)), "word", range_of<E>(words), meaning);
  }
  template <class E>
  void words(const char* key, std::vector<E>& values,
             std::initializer_list<std::pair<const char*, std::type_identity_t<E>>> words, const char* meaning) {
    std::vector<std::string> chosen;
    for (const E& value : values) chosen.push_back(word_of<E>(value, words));
    leaf(key, sequence(chosen), "list of words", range_of<E>(words), meaning);
  }
  void faces(const char* key, Faces& faces, const char* meaning);
  void file(const char* key, std::string& value, const char* meaning) { name_like(key, value, "file", meaning, true); }
  void optional_file(const char* key, std::string& value, const char* meaning) {
    name_like(key, value, "file", meaning, false);
  }
  void output_file(const char* key, std::string& value, const char* meaning) {
    name_like(key, value, "file", meaning, false);
  }
  void unit(const char* key, double& size, const char* expected, const char* meaning) {
    quantity(key, size, expected, "(0, inf)", std::string(meaning) + ": `mm`, `m`, ...");
  }
  void outline(const char* key, std::vector<Vec2>& points, const char* meaning) {
    print_outline(key, points, meaning, true);
  }
  void optional_outline(const char* key, std::vector<Vec2>& points, const char* meaning) {
    print_outline(key, points, meaning, false);
  }
  void table(const char* key, std::vector<double>& xs, std::vector<double>& ys, const std::string& x_unit,
             const std::string& y_unit, const char* meaning);
  void function(const char* key, Function& value, const std::string& unit, const char* meaning) {
    print_function(key, value, unit, meaning, !value.is_set());
  }
  void optional_function(const char* key, Function& value, const std::string& unit, const char* meaning) {
    print_function(key, value, unit, meaning, false);
  }
  void optional_characteristic(const char* key, mbd::Characteristic& value, const std::string& x_unit,
                               const std::string& unit, const char* meaning);
  void formula(const char* key, std::string& text, std::function<double(double, double, double)>&,
               const char* meaning) {
    name_like(key, text, "formula", meaning, true);
  }
  void expression(const char* key, mbd::ExpressionFunction& value, const std::string& unit, const std::string& meaning);

  // -- names of other things --
  void reference(const char* key, std::string& value, Family family, const char* meaning) {
    name_like(key, value, name_of(family), meaning, true);
  }
  void optional_reference(const char* key, std::string& value, Family family, const char* meaning) {
    name_like(key, value, name_of(family), meaning, false);
  }
  void joint(const char* key, std::string& value, const char* meaning) {
    reference(key, value, Family::joint, meaning);
  }
  void force(const char* key, std::string& value, const char* meaning) {
    reference(key, value, Family::force, meaning);
  }
  void marker(const char* key, mbd::Marker& value, const char* meaning) {
    name_like(key, value.name, "name of a marker or body", meaning, true);
  }
  void optional_marker(const char* key, mbd::Marker& value, const char* meaning) {
    name_like(key, value.name, "name of a marker or body", meaning, false);
  }
  template <std::size_t count>
  void markers(const char* key, std::array<mbd::Marker, count>& values, const char* meaning) {
    std::vector<std::string> names;
    for (const mbd::Marker& m : values) names.push_back(m.name);
    leaf(key, values[0].name.empty() ? Node{} : sequence(names), std::to_string(count) + " markers or bodies", "",
         meaning, true);
  }
  void pair(const char* key, std::array<std::string, 2>& value, Family family, const char* meaning);
  void combinations(const char* key, const std::array<std::string, 2>&, std::vector<Combination>& combine,
                    const char* meaning);

  // -- bodies and points --
  void body(const char* key, int& index, const char* meaning);
  void optional_body(const char* key, int& index, const char* meaning);
  void bodies(const char* key, int& a, int& b, const char* meaning);
  void coordinate(const char* key, int& index, mbd::Coordinate& coordinate, const char* meaning);
  void joint_point(int, Vec2& p_a, int, Vec2& p_b, const char* meaning) { points("at", p_a, p_b, meaning, true); }
  void optional_joint_point(int, Vec2& p_a, int, Vec2& p_b, const char* meaning) {
    points("at", p_a, p_b, meaning, false);
  }
  void end_points(int, Vec2& p_a, int, Vec2& p_b, const char* meaning) { points("ends", p_a, p_b, meaning, true); }
  void point(const char* key, int, Vec2& p, const char* meaning);
  void axis(const char* key, int, double& angle_a, const char* meaning);

  // -- structure --
  template <class T>
  void section(const char* key, T& value, const char* meaning) {
    print_mapping(key, meaning, false, [&](Printer& p) { declare(p, value); });
  }
  template <class T>
  void section(const char* key, std::optional<T>& value, const char* meaning) {
    if (listing()) {
      T prototype{};
      print_mapping(key, meaning, false, [&](Printer& p) { declare(p, prototype); });
    } else if (value) {
      section(key, *value, meaning);
    }
  }
  template <class Declare>
  void group(const char* key, const char* meaning, Declare declare_group) {
    print_mapping(key, meaning, true, [&](Printer& p) { declare_group(p); });
  }
  template <class T>
  void list(const char* key, std::vector<T>& values, const char* meaning) {
    if (listing()) {
      T prototype{};
      add_row(key, "list of mappings", "left out", "", meaning);
      Printer printer(*rows_, path_.empty() ? key : path_ + "." + key);
      declare(printer, prototype);
      return;
    }
    if (values.empty()) return;
    Node items = Node::list();
    items.comment = comment(meaning, "");
    for (T& value : values) {
      Node& item = items.items.emplace_back(Node::mapping());
      Printer printer(item, comments_ && items.items.size() == 1);
      declare(printer, value);
    }
    node_->add(key, std::move(items));
  }
  template <class T>
  void named(const char* key, std::vector<T>& values, const char* meaning) {
    print_named(key, values, meaning, [](Printer& p, T& value) { declare(p, value); });
  }
  template <class T>
  void elements(const char* key, std::vector<T>& values, const char* meaning) {
    if (listing()) {
      add_row(key, "named mappings", "left out", "", meaning);
      using Variant = decltype(T{}.element);
      ForEach<Variant>::call([&]<class E>(std::type_identity<E>) {
        E prototype{};
        list_type(std::string(key), prototype);
      });
    } else {
      print_named(key, values, meaning,
                  [](Printer& p, T& value) { visit([&](auto& e) { declare(p, e); }, value.element); });
    }
  }
  void kind(const char* key, GivenLaw& value, const char* meaning);  // given_law.cpp
  template <class Variant>
  void kind(const char* key, Variant& value, const char* meaning) {
    if (!listing()) {
      std::visit(
          [&](auto& law) {
            leaf(key, Node::of(card_of<std::decay_t<decltype(law)>>().word), "word", "", meaning);
            declare(*this, law);
          },
          value);
      return;
    }
    std::string range;
    std::vector<Row> types;
    ForEach<Variant>::call([&]<class T>(std::type_identity<T>) {
      T prototype{};
      Printer printer(types, path_);
      printer.list_type("", prototype);
      range += (range.empty() ? "" : " | ") + printer.word;
    });
    add_row(key, "word", "required", range, meaning);
    rows_->insert(rows_->end(), types.begin(), types.end());
  }
  template <class Variant>
  void optional_form(const char* key, Variant& value, const char* meaning) {
    form(key, value, meaning, false);
  }
  template <class Variant>
  void form(const char* key, Variant& value, const char* meaning, bool needed = true) {
    if (listing()) {
      add_row(key, "one of the forms below", needed ? "required" : "left out", "", meaning);
      const Card own{word, word_meaning};  // the card is that of the type whose form this is
      ForEach<Variant>::call([&]<class T>(std::type_identity<T>) {
        T prototype{};
        list_type(key, prototype);
      });
      word = own.word, word_meaning = own.meaning;
      return;
    }
    Node form = Node::mapping(true);
    Printer printer(form, false);
    std::visit([&](auto& f) { declare(printer, f); }, value);
    if (form.entries.size() == 1 && form.entries[0].key == "equal") form = Node::of(form.entries[0].value.scalar);
    form.comment = comment(meaning, "");
    const bool empty = form.entries.empty() && form.scalar.empty();
    if (!empty) node_->add(key, std::move(form));
  }
  template <class Variant>
  void inline_form(Variant& value) {
    if (listing()) {
      ForEach<Variant>::call([&]<class T>(std::type_identity<T>) {
        T prototype{};
        list_type("", prototype);
      });
    } else {
      std::visit([&](auto& f) { declare(*this, f); }, value);
    }
  }
  void turns(const char* key, Rotation&, const char* meaning) { leaf(key, Node{}, "3 numbers rad", "", meaning); }
  void start(const char* key, Start& start, const char* meaning);
  void watches(const char* key, std::vector<Watch>& watches, const char* meaning);

  /// Rows of one alternative, below `key.word`.
  template <class T>
  void list_type(const std::string& key, T& prototype) {
    std::vector<Row> rows;
    Printer inner(rows, "");
    declare(inner, prototype);
    word = inner.word;
    word_meaning = inner.word_meaning;
    const std::string below = (key.empty() ? "" : key + ".") + word;
    // The word is a key of its own (`revolute: [a, b]`, `plane: {...}`) or only names the type (`law: wet`).
    const bool has_value = !rows.empty() && rows.front().path == word;
    Row type{below, "type", "", "", word_meaning};
    if (has_value) {
      type = rows.front();
      type.meaning = type.meaning == word_meaning ? word_meaning : word_meaning + "; value: " + type.meaning;
      rows.erase(rows.begin());
    }
    add_row(below, type.unit, type.fallback, type.range, type.meaning);
    for (Row& row : rows) {
      const bool nested = row.path.starts_with(word + ".");
      add_row(nested ? (key.empty() ? "" : key + ".") + row.path : below + "." + row.path, row.unit, row.fallback,
              row.range, row.meaning);
    }
  }

 private:
  bool listing() const { return rows_ != nullptr; }
  static Node sequence(const std::vector<std::string>& texts);
  static const char* name_of(Family family);
  template <class Vector>
  static std::vector<double> numbers_of(const Vector& value, std::size_t size) {
    std::vector<double> result;
    for (std::size_t i = 0; i < size; ++i) {
      if constexpr (std::is_same_v<Vector, Vec3>) {
        result.push_back(value[static_cast<int>(i)]);
      } else {
        result.push_back(value[i]);
      }
    }
    return result;
  }
  template <class E>
  static std::string word_of(E value,
                             const std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>& words) {
    for (const auto& [text, meant] : words) {
      if (meant == value) return text;
    }
    return "";
  }
  template <class E>
  static std::string range_of(const std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>& words) {
    std::string range;
    for (const auto& pair : words) range += (range.empty() ? "" : " | ") + std::string(pair.first);
    return range;
  }

  std::string comment(const std::string& meaning, const std::string& range) const;
  void add_row(const std::string& key, const std::string& unit, const std::string& fallback, const std::string& range,
               const std::string& meaning);
  /// The one place where a key is printed. A null value is one that is left out.
  void leaf(const std::string& key, Node value, const std::string& unit, const std::string& range,
            const std::string& meaning, bool needed = false);
  void numbers(const char* key, const std::vector<double>& values, const std::string& unit, std::size_t size,
               bool needed, const std::string& meaning);
  void name_like(const char* key, const std::string& value, const std::string& what, const char* meaning, bool needed);
  void print_outline(const char* key, const std::vector<Vec2>& points, const char* meaning, bool needed);
  void points(const char* key, const Vec2& p_a, const Vec2& p_b, const char* meaning, bool needed);
  void print_function(const char* key, const Function& value, const std::string& unit, const char* meaning,
                      bool needed);
  Node function_node(const Function& value, const std::string& unit) const;
  template <class Kinds, class Law, class... Units>
  static Node law_node(const Law& law, const Units&... units);
  std::string body_name(int index) const;

  template <class Print>
  void print_mapping(const std::string& key, const std::string& meaning, bool flow, Print print) {
    if (listing()) {
      add_row(key, "section", "", "", meaning);
      Printer printer(*rows_, path_.empty() ? key : path_ + "." + key);
      print(printer);
      return;
    }
    Node mapping = Node::mapping(flow);
    mapping.comment = comment(meaning, "");
    Printer printer(mapping, comments_ && !flow);
    printer.body_names_ = body_names_;
    print(printer);
    body_names_ = printer.body_names_;
    if (!mapping.entries.empty()) node_->add(key, std::move(mapping));
  }
  template <class T, class Print>
  void print_named(const char* key, std::vector<T>& values, const char* meaning, Print print) {
    if (listing()) {
      T prototype{};
      add_row(key, "named mappings", "left out", "", meaning);
      Printer printer(*rows_, (path_.empty() ? "" : path_ + ".") + key + ".<name>");
      print(printer, prototype);
      return;
    }
    if (values.empty()) return;
    Node mapping = Node::mapping();
    mapping.comment = comment(meaning, "");
    for (T& value : values) {
      Node item = Node::mapping(true);
      Printer printer(item, false);
      if constexpr (std::is_same_v<T, Body>) body_names_.push_back(value.name);
      printer.body_names_ = body_names_;
      print(printer, value);
      mapping.add(value.name, std::move(item));
    }
    node_->add(key, std::move(mapping));
  }

  Node* node_ = nullptr;
  bool comments_ = false;
  std::vector<Row>* rows_ = nullptr;
  std::string path_;
  std::optional<double> n_;  // the quantity `n` of this mapping, for powers such as (n+1)
  std::vector<std::string> body_names_{"ground"};
  std::vector<Combination> combined_;  // quantities of this mapping that a rule has supplied
};

template <class T>
const Card& card_of() {
  static const Card card = [] {
    std::vector<Row> rows;
    Printer printer(rows, "");
    T prototype{};
    if constexpr (requires { prototype.describe(printer, std::string{}); }) {
      prototype.describe(printer, "1");
    } else if constexpr (requires { prototype.describe(printer, std::string{}, std::string{}); }) {
      prototype.describe(printer, "1", "1");
    } else {
      declare(printer, prototype);
    }
    return Card{printer.word, printer.word_meaning};
  }();
  return card;
}

template <class List>
std::vector<std::string> words_of() {
  std::vector<std::string> words;
  ForEach<List>::call([&]<class T>(std::type_identity<T>) { words.push_back(card_of<T>().word); });
  return words;
}

}  // namespace subsoil::app
