#include "libsim/keys/functions.hpp"

#include <fmt/format.h>

#include <cctype>

#include "libmbd/base/characteristic.hpp"
#include "libmbd/base/function.hpp"
#include "libsim/document/arithmetic.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"

/// Functions of time, characteristics, formulas.
namespace subsoil::sim {
namespace {

/// A kind whose word holds its first value itself: {expression: "sin(t)", unit: m}.
template <class Kind>
concept WordIsKey = requires {
  requires Kind::word_is_key;
};

template <class Kind, class... Units>
Card card_with(const Units&... units) {
  return card_shown_by([&](Fields& fields) {
    Kind kind;
    kind.describe(fields, units...);
  });
}

/// A law (function of time, characteristic) from `{word: {parameters}}` or `{table: [[...]]}`, one kind of `Kinds`.
template <class Law, class Kinds, class... Units>
Law law_of(Reader& reader, const Node& node, const std::string& path, const Units&... units) {
  Reading& reading = reader.reading();
  const std::size_t before = reading.problems.count();
  std::vector<std::string> words;
  ForEach<Kinds>::call([&]<class Kind>(std::type_identity<Kind>) { words.push_back(card_with<Kind>(units...).word); });
  // An unknown kind of law says nothing about the other keys: it is sought by a reader of its own.
  const auto type = Reader(reading, node, path).find_type(node, path, words);
  Law law;
  std::size_t i = 0;
  ForEach<Kinds>::call([&]<class Kind>(std::type_identity<Kind>) {
    if (i++ != type) return;
    const std::string& word = words[*type];
    const Node& given = node.find(word)->value;
    Kind kind;
    if constexpr (WordIsKey<Kind>) {
      Reader inner(reading, node, path);
      kind.describe(inner, units...);
      inner.finish();
    } else {
      Node parameters = given;
      if (given.kind == Node::Kind::sequence) {  // {table: [[0 s, 0 m], ...]}
        parameters = Node::mapping();
        parameters.place = given.place;
        parameters.add("points", given);
      }
      Reader inner(reading, mapping_of(parameters), path + "." + word);
      kind.describe(inner, units...);
      inner.finish();
      if (node.entries.size() > 1)
        throw Refusal("only `" + word + "` may stand here", "its parameters belong inside it");
    }
    if (reading.problems.count() == before) law = Law(std::move(kind));
  });
  return law;
}

template <class Kinds, class Law, class... Units>
Node law_node(const Law& law, const Units&... units) {
  Node node = Node::mapping(true);
  ForEach<Kinds>::call([&]<class Kind>(std::type_identity<Kind>) {
    if (const Kind* held = law.template get_if<Kind>()) {
      Kind kind = *held;
      Node parameters = Node::mapping(true);
      Printer printer(parameters, false);
      kind.describe(printer, units...);
      if constexpr (WordIsKey<Kind>) {
        node = std::move(parameters);
      } else {
        node.add(printer.word(), std::move(parameters));
      }
    }
  });
  return node;
}

/// Name of a function or characteristic among the definitions of a schema.
template <class... Units>
std::string definition_of(const char* law, const Units&... units) {
  std::string name = law;
  for (const std::string& unit : {units...}) {
    name += '.';
    for (const char c : unit)
      if (c == '/')
        name += "-per-";
      else
        name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '-';
  }
  return name;
}

/// {word: {parameters}} of one kind, or {table: [[0 s, 0 m], ...]}.
template <class Kind, class... Units>
void outline_kind(Schema& schema, const Units&... units) {
  Kind kind;
  Fields& fields = schema;
  if constexpr (WordIsKey<Kind>) {
    kind.describe(fields, units...);
  } else {
    const Card card = card_with<Kind>(units...);
    schema.card(card.word.c_str(), card.meaning.c_str());
    Schema parameters(schema.shared(), schema.child(card.word));
    Fields& inner = parameters;
    kind.describe(inner, units...);
    const Json* points = parameters.find("points");
    const Json form = parameters.object();
    schema.add({card.word, card.meaning, true}, points == nullptr ? form : either({*points, form}));
  }
}

template <class Kinds, class... Units>
Json kinds_form(SchemaShared& shared, const std::string& name, const Units&... units) {
  std::vector<Schema::Outline> kinds;
  ForEach<Kinds>::call([&]<class Kind>(std::type_identity<Kind>) {
    kinds.push_back([&](Schema& schema) { outline_kind<Kind>(schema, units...); });
  });
  Schema law(shared, name + ".kinds");
  law.choose_by_key(kinds);
  return law.object();
}

class FunctionOfTime final : public Compound {
 public:
  FunctionOfTime(mbd::Function& value, const std::string& unit) : value_(value), unit_(unit) {}
  void read(Reader& reader, const Field& field) override {
    reader.leaf(field, [&](const Node& node) { value_ = function_of(reader, node, reader.child(field.key)); });
  }
  void print(Printer& printer, const Field& field) const override {
    printer.leaf(field.key, node_of(value_), field.meaning);
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, fmt::format("{}, constant or function of time", unit_),
             KeyList::fallback(node_of(value_), field.needed), "", field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    const std::string law = definition_of("function", unit_), name = schema.shared().part ? "part." + law : law;
    Json& definitions = schema.shared().definitions;
    if (!definitions.contains(name)) {
      definitions[name] = Json::object();  // terms are functions of the same unit
      const Json kinds = kinds_form<mbd::FunctionKinds>(schema.shared(), law, unit_);
      definitions[name] = either({number_form(unit_), list_form(Schema::reference(name)), kinds});
    }
    schema.add(field, either({Schema::reference(name)}), fmt::format("{}, constant or function of time", unit_));
  }

 private:
  mbd::Function function_of(Reader& reader, const Node& node, const std::string& path) {
    if (node.kind == Node::Kind::scalar) return {numbers_of(node, unit_, 1, reader.exponent()).front()};
    if (node.kind == Node::Kind::sequence) {  // terms that add up
      mbd::SumFunction sum;
      for (const Node& term : node.items) sum.terms.push_back(function_of(reader, term, path));
      return {std::move(sum)};
    }
    return law_of<mbd::Function, mbd::FunctionKinds>(reader, node, path, unit_);
  }
  Node node_of(const mbd::Function& function) const {
    if (!function.is_set()) return {};
    if (const auto* constant = function.get_if<mbd::ConstantFunction>())
      return Node::of(format_quantity(constant->value_, unit_));
    if (const auto* sum = function.get_if<mbd::SumFunction>()) {
      Node terms = Node::list(true);
      for (const mbd::Function& term : sum->terms) terms.items.push_back(node_of(term));
      return terms;
    }
    return law_node<mbd::FunctionKinds>(function, unit_);
  }

  mbd::Function& value_;
  const std::string& unit_;
};

class CharacteristicLaw final : public Compound {
 public:
  CharacteristicLaw(mbd::Characteristic& value, const std::string& x_unit, const std::string& unit)
      : value_(value), x_unit_(x_unit), unit_(unit) {}
  void read(Reader& reader, const Field& field) override {
    reader.leaf(field, [&](const Node& node) {
      value_ = law_of<mbd::Characteristic, mbd::CharacteristicKinds>(reader, mapping_of(node), reader.child(field.key),
                                                                     x_unit_, unit_);
    });
  }
  void print(Printer& printer, const Field& field) const override {
    if (value_.is_set())
      printer.leaf(field.key, law_node<mbd::CharacteristicKinds>(value_, x_unit_, unit_), field.meaning);
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, fmt::format("{} over {}, characteristic", unit_, x_unit_), "left out", "", field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    const std::string law = definition_of("characteristic", x_unit_, unit_);
    const std::string name = schema.shared().part ? "part." + law : law;
    Json& definitions = schema.shared().definitions;
    if (!definitions.contains(name)) {
      const Json kinds = kinds_form<mbd::CharacteristicKinds>(schema.shared(), law, x_unit_, unit_);
      definitions[name] = kinds;
    }
    schema.add(field, either({Schema::reference(name)}), fmt::format("{} over {}, characteristic", unit_, x_unit_));
  }

 private:
  mbd::Characteristic& value_;
  const std::string &x_unit_, &unit_;
};

/// A formula in t with the unit of its value beside it.
class ExpressionOfTime final : public Compound {
 public:
  ExpressionOfTime(mbd::ExpressionFunction& value, const std::string& unit) : value_(value), unit_(unit) {}
  void read(Reader& reader, const Field& field) override {
    std::string given;
    double size = 1;
    reader.leaf({"unit", fmt::format("the unit of the formula's value, such as {}", unit_), unit_ != "1"},
                [&](const Node& node) {
                  given = scalar_of(node);
                  if (given == "1") return static_cast<void>(parse_quantity(given, unit_));
                  if (!given.empty() && given[0] >= '0' && given[0] <= '9')
                    throw UnitError("must be a unit alone; write the number into the formula");
                  size = parse_quantity("1 " + given, unit_);
                });
    reader.leaf(field, [&](const Node& node) {
      value_ = make_expression(with_numbers(scalar_of(node), {"t"}, size == 1), given, size);
    });
  }
  void print(Printer& printer, const Field& field) const override {
    if (!value_.text.empty()) printer.leaf(field.key, Node::of(value_.text), field.meaning);
    if (!value_.unit.empty()) printer.leaf("unit", Node::of(value_.unit), meaning_of_unit());
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "formula", "required", "", field.meaning);
    keys.add("unit", "a unit", unit_ == "1" ? "left out" : "required", "", meaning_of_unit());
  }
  void outline(Schema& schema, const Field& field) const override {
    schema.add(field, text_form(), "formula");
    schema.add({"unit", meaning_of_unit(), unit_ != "1"}, text_form());
  }

 private:
  std::string meaning_of_unit() const {
    return fmt::format("the unit of the formula's value: {} or another of its dimension; a plain number needs none",
                       unit_);
  }
  mbd::ExpressionFunction& value_;
  const std::string& unit_;
};

/// A formula in z, v and m.
class Formula final : public Value {
 public:
  Formula(std::string& text, std::function<double(double, double, double)>& call) : text_(text), call_(call) {}
  void read(const Node& node, const ReadScope&) override {
    text_ = with_numbers(scalar_of(node), {"z", "v", "m"}, true);
    call_ = make_formula(text_, {"z", "v", "m"});
  }
  Node print(const PrintScope&) const override { return text_.empty() ? Node{} : Node::of(text_); }
  std::string what() const override { return "formula"; }
  Json schema() const override { return text_form(); }

 private:
  std::string& text_;
  std::function<double(double, double, double)>& call_;
};

template <class Kinds, class... Units>
void list_forms(std::vector<KnownKey>& keys, const std::string& head, const Units&... units) {
  ForEach<Kinds>::call([&]<class Kind>(std::type_identity<Kind>) {
    Kind kind;
    std::vector<KnownKey> below;
    KeyList inner(below, "");
    kind.describe(inner, units...);
    const std::string path = head + "." + inner.card().word;
    KnownKey top{path, "type", "", "", inner.card().meaning};
    if (!below.empty() && below.front().path == inner.card().word) {  // {expression: "sin(t)", unit: m}
      top = below.front();
      top.path = path, top.meaning = inner.card().meaning + ": " + top.meaning;
      below.erase(below.begin());
    }
    keys.push_back(top);
    for (const KnownKey& k : below) keys.push_back({path + "." + k.path, k.unit, k.fallback, k.range, k.meaning});
  });
}

}  // namespace

void list_function_forms(std::vector<KnownKey>& keys) {
  list_forms<mbd::FunctionKinds>(keys, "function", std::string("U"));
  list_forms<mbd::CharacteristicKinds>(keys, "characteristic", std::string("X"), std::string("U"));
}

void Fields::function(const char* key, mbd::Function& value, Text unit, Text meaning) {
  FunctionOfTime function(value, unit);
  visit_compound({key, meaning, !value.is_set(), unit}, function);
}

void Fields::optional_function(const char* key, mbd::Function& value, Text unit, Text meaning) {
  FunctionOfTime function(value, unit);
  visit_compound({key, meaning, false, unit}, function);
}

void Fields::optional_characteristic(const char* key, mbd::Characteristic& value, Text x_unit, Text unit,
                                     Text meaning) {
  CharacteristicLaw law(value, x_unit, unit);
  visit_compound({key, meaning}, law);
}

void Fields::expression(const char* key, mbd::ExpressionFunction& value, Text unit, Text meaning) {
  ExpressionOfTime expression(value, unit);
  visit_compound({key, meaning, true}, expression);
}

void Fields::formula(const char* key, std::string& text, std::function<double(double, double, double)>& call,
                     Text meaning) {
  Formula formula(text, call);
  visit_value({key, meaning, true}, formula);
}

}  // namespace subsoil::sim
