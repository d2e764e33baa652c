#include "apps/scenario/printer.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scenario/units.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/measures.hpp"

namespace subsoil::app {

Node Printer::sequence(const std::vector<std::string>& texts) {
  Node node = Node::list(true);
  for (const std::string& text : texts) node.items.push_back(Node::of(text));
  return node;
}

const char* Printer::name_of(Family family) {
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

std::string Printer::comment(const std::string& meaning, const std::string& range) const {
  if (!comments_) return {};
  const std::size_t bar = range.find(" |");
  const bool spelled_out = meaning.find(range.substr(0, bar) + ":") != std::string::npos;
  return bar != std::string::npos && !spelled_out ? fmt::format("{}; {}", meaning, range) : meaning;
}

void Printer::add_row(const std::string& key, const std::string& unit, const std::string& fallback,
                      const std::string& range, const std::string& meaning) {
  rows_->push_back({path_.empty() ? key : path_ + "." + key, unit, fallback, range, meaning});
}

void Printer::leaf(const std::string& key, Node value, const std::string& unit, const std::string& range,
                   const std::string& meaning, bool needed) {
  const bool absent = value.kind == Node::Kind::null;
  if (listing()) {
    const std::string fallback = needed ? "required" : absent ? "left out" : value.one_line();
    add_row(key, unit, fallback, range, meaning);
  } else if (!absent) {
    const auto rule = std::find_if(combined_.begin(), combined_.end(), [&](const auto& c) { return c.key == key; });
    value.comment = rule == combined_.end()
                        ? comment(meaning, range)
                        : fmt::format("{} of the two materials'", rule_words[static_cast<std::size_t>(rule->rule)]);
    node_->add(key, std::move(value));
  }
}

// ---- values --------------------------------------------------------------------------------------------------------

namespace {
/// Powers of n, and the U that stands for a function's unit in the reference.
bool symbolic(const std::string& unit) {
  return unit.find("(n") != std::string::npos || unit.find('U') != std::string::npos;
}
}  // namespace

void Printer::quantity(const char* key, double& value, const std::string& unit, const std::string& range,
                       const std::string& meaning) {
  if (std::string_view(key) == "n") n_ = value;
  const bool absent = std::isnan(value) || std::isinf(value);
  const bool raw = listing() && symbolic(unit);  // a default whose unit has no meaning yet
  Node text = absent ? Node{} : Node::of(raw ? fmt::format("{} {}", value, unit) : format_quantity(value, unit, n_));
  leaf(key, std::move(text), unit, range, meaning, std::isnan(value));
}

void Printer::quantity(const char* key, std::optional<double>& value, const std::string& unit, const std::string& range,
                       const std::string& meaning) {
  leaf(key, value ? Node::of(format_quantity(*value, unit, n_)) : Node{}, unit, range, meaning);
}

void Printer::optional_quantity(const char* key, double& value, const std::string& unit, const std::string& range,
                                const std::string& meaning) {
  std::optional<double> maybe;
  if (!std::isnan(value)) maybe = value;
  quantity(key, maybe, unit, range, meaning);
}

void Printer::quantity_or(const char* key, std::optional<double>& value, const char* other, const char* unit,
                          const char* range, const char* meaning) {
  leaf(key, Node::of(value ? format_quantity(*value, unit) : other), unit, fmt::format("{} or {}", range, other),
       meaning);
}

void Printer::quantities(const char* key, std::vector<double>& values, const char* unit, const char* range,
                         const char* meaning) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(format_quantity(value, unit));
  leaf(key, texts.empty() ? Node{} : sequence(texts), fmt::format("list of {}", unit), range, meaning);
}

void Printer::span(const char* key, double& least, double& largest, const char* unit, const char* range,
                   const char* meaning) {
  const bool needed = std::isnan(least);
  const double both[2]{least, largest};
  leaf(key, needed ? Node{} : Node::of(format_quantities(both, 2, unit)), fmt::format("2 numbers {}", unit), range,
       meaning, needed);
}

void Printer::numbers(const char* key, const std::vector<double>& values, const std::string& unit, std::size_t size,
                      bool needed, const std::string& meaning) {
  const bool absent = values.empty() || std::isnan(values[0]);
  const std::string numbers_and_unit =
      unit == "1" ? fmt::format("{} numbers", size) : fmt::format("{} numbers {}", size, unit);
  leaf(key, absent ? Node{} : Node::of(format_quantities(values.data(), size, unit)), numbers_and_unit, "", meaning,
       needed);
}

void Printer::name_like(const char* key, const std::string& value, const std::string& what, const char* meaning,
                        bool needed) {
  leaf(key, value.empty() ? Node{} : Node::of(value), what, "", meaning, needed);
}

void Printer::faces(const char* key, Faces& faces, const char* meaning) {
  std::vector<std::string> open;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (faces[i]) open.emplace_back(face_names[i]);
  }
  leaf(key, sequence(open), "list of faces", "-x | +x | -y | +y | -z | +z", meaning);
}

void Printer::print_outline(const char* key, const std::vector<Vec2>& points, const char* meaning, bool needed) {
  std::vector<std::string> texts;
  for (const Vec2& p : points) texts.push_back(format_quantities(p.data(), 2, "m"));
  leaf(key, texts.empty() ? Node{} : sequence(texts), "list of 2 numbers m, or file", "", meaning, needed);
}

void Printer::table(const char* key, std::vector<double>& xs, std::vector<double>& ys, const std::string& x_unit,
                    const std::string& y_unit, const char* meaning) {
  Node rows = Node::list(true);
  for (std::size_t i = 0; i < xs.size(); ++i) {
    rows.items.push_back(sequence({format_quantity(xs[i], x_unit), format_quantity(ys[i], y_unit)}));
  }
  leaf(key, xs.empty() ? Node{} : rows, fmt::format("list of [{}, {}]", x_unit, y_unit), "", meaning, xs.empty());
}

// ---- functions of time, characteristics ----------------------------------------------------------------------------

template <class Kinds, class Law, class... Units>
Node Printer::law_node(const Law& law, const Units&... units) {
  Node node = Node::mapping(true);
  ForEach<Kinds>::call([&]<class Kind>(std::type_identity<Kind>) {
    if (const Kind* held = law.template get_if<Kind>()) {
      Kind kind = *held;
      Node parameters = Node::mapping(true);
      Printer printer(parameters, false);
      kind.describe(printer, units...);
      if constexpr (requires { Kind::word_is_key; }) {  // {expression: "sin(t)", unit: m}
        node = std::move(parameters);
      } else {
        node.add(printer.word, std::move(parameters));
      }
    }
  });
  return node;
}

Node Printer::function_node(const Function& value, const std::string& unit) const {
  if (!value.is_set()) return {};
  if (const auto* constant = value.get_if<mbd::ConstantFunction>())
    return Node::of(format_quantity(constant->value_, unit));
  if (const auto* sum = value.get_if<mbd::SumFunction>()) {
    Node terms = Node::list(true);
    for (const Function& term : sum->terms) terms.items.push_back(function_node(term, unit));
    return terms;
  }
  return law_node<mbd::FunctionKinds>(value, unit);
}

void Printer::optional_characteristic(const char* key, mbd::Characteristic& value, const std::string& x_unit,
                                      const std::string& unit, const char* meaning) {
  Node node;
  if (value.is_set()) node = law_node<mbd::CharacteristicKinds>(value, x_unit, unit);
  leaf(key, std::move(node), fmt::format("{} over {}, characteristic", unit, x_unit), "", meaning);
}

void Printer::print_function(const char* key, const Function& value, const std::string& unit, const char* meaning,
                             bool needed) {
  leaf(key, function_node(value, unit), fmt::format("{}, constant or function of time", unit), "", meaning, needed);
}

void Printer::expression(const char* key, mbd::ExpressionFunction& value, const std::string& unit,
                         const std::string& meaning) {
  leaf(key, value.text.empty() ? Node{} : Node::of(value.text), "formula", "", meaning, true);
  leaf("unit", value.unit.empty() ? Node{} : Node::of(value.unit), "a unit", "",
       fmt::format("the unit of the formula's value: {} or another of its dimension; a plain number needs none", unit),
       unit != "1");
}

// ---- names, bodies, points -----------------------------------------------------------------------------------------

void Printer::pair(const char* key, std::array<std::string, 2>& value, Family family, const char* meaning) {
  leaf(key, value[0].empty() ? Node{} : sequence({value[0], value[1]}), fmt::format("[{0}, {0}]", name_of(family)), "",
       meaning, true);
}

/// Of values the law's own keys hold what came out; they say where it is from, and are read again as they stand.
void Printer::combinations(const char* key, const std::array<std::string, 2>&, std::vector<Combination>& combine,
                           const char* meaning) {
  std::string words;
  for (const char* word : rule_words) words += (words.empty() ? "" : " | ") + std::string(word);
  if (listing()) add_row(key, "{value: rule}", "left out", words, meaning);
  combined_ = combine;
}

std::string Printer::body_name(int index) const {
  const auto i = static_cast<std::size_t>(index);
  return index >= 0 && i < body_names_.size() ? body_names_[i] : "?";
}

void Printer::body(const char* key, int& index, const char* meaning) {
  leaf(key, index < 0 ? Node{} : Node::of(body_name(index)), "name of a body", "", meaning, true);
}

void Printer::optional_body(const char* key, int& index, const char* meaning) {
  leaf(key, index < 0 ? Node{} : Node::of(body_name(index)), "name of a body, or ground", "", meaning);
}

void Printer::bodies(const char* key, int& a, int& b, const char* meaning) {
  leaf(key, a < 0 ? Node{} : sequence({body_name(a), body_name(b)}), "[name of a body, name of a body]", "", meaning,
       true);
}

void Printer::coordinate(const char* key, int& index, mbd::Coordinate& coordinate, const char* meaning) {
  const char* names[]{"x", "y", "angle"};
  leaf(key, index < 0 ? Node{} : Node::of(body_name(index) + "." + names[static_cast<int>(coordinate)]),
       "body.x, body.y or body.angle", "", meaning, true);
}

void Printer::points(const char* key, const Vec2& p_a, const Vec2& p_b, const char* meaning, bool needed) {
  if (listing()) {
    const bool ends = std::string_view(key) == "ends";
    add_row(key, ends ? "list of two points, 2 numbers m each" : "2 numbers m", needed ? "required" : "left out", "",
            fmt::format("{}; in the world of the start pose", meaning));
    add_row("points", "list of two points, 2 numbers m each", "left out", "",
            fmt::format("instead of `{}`: one point per body, each in its body's own axes", key));
    return;
  }
  leaf("points", sequence({format_quantities(p_a.data(), 2, "m"), format_quantities(p_b.data(), 2, "m")}), "", "",
       meaning);
}

void Printer::point(const char* key, int, Vec2& p, const char* meaning) {
  if (listing()) {
    add_row(key, "2 numbers m", "left out", "", fmt::format("{}; in the world of the start pose", meaning));
    add_row("point", "2 numbers m", "left out", "", fmt::format("instead of `{}`: in the body's own axes", key));
    return;
  }
  leaf("point", Node::of(format_quantities(p.data(), 2, "m")), "", "", meaning);
}

void Printer::axis(const char* key, int, double& angle_a, const char* meaning) {
  if (listing()) {
    add_row(key, "2 numbers", "required", "", fmt::format("{}: a world vector of any length", meaning));
    add_row(fmt::format("{} angle", key), "rad", "left out", "",
            fmt::format("instead of `{}`: the direction's angle in its body's own axes", key));
    return;
  }
  leaf(fmt::format("{} angle", key), Node::of(format_quantity(angle_a, "rad")), "", "", meaning);
}

// ---- start, watch --------------------------------------------------------------------------------------------------

void Printer::start(const char* key, Start& start, const char* meaning) {
  Node node = Node::of("pose");
  if (start.kind == StartKind::towing_equilibrium) {
    node = Node::mapping(true);
    node.add("towing equilibrium", Node::of(format_quantity(start.speed, "m/s")));
  }
  leaf(key, std::move(node), "word, or {towing equilibrium: m/s}", "", meaning);
}

void Printer::watches(const char* key, std::vector<Watch>& watches, const char* meaning) {
  Node node = Node::mapping();
  for (const Watch& watch : watches) {
    Node item = Node::of(watch.of);
    if (watch.kind != Watch::Kind::column) {
      item = Node::mapping(true);
      item.add(watch_words[static_cast<std::size_t>(watch.kind)], Node::of(watch.of));
      if (watch.kind == Watch::Kind::joint || watch.kind == Watch::Kind::soil_force) {
        const double along[3]{watch.along.x, watch.along.y, watch.along.z};
        item.add("along", Node::of(format_quantities(along, 3, "1")));
      }
    }
    node.add(watch.name, std::move(item));
  }
  leaf(key, watches.empty() ? Node{} : node, "named columns", "column, driver, force, joint, soil force, soil moment",
       meaning);
}

}  // namespace subsoil::app
