#include "apps/scenario/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace subsoil::app {
namespace fs = std::filesystem;

// ---- faults --------------------------------------------------------------------------------------------------------

void Reader::fault(const Node& node, const std::string& path, const std::string& rule) {
  reading_.problems.add(node.place, path, node.one_line(), rule);
}

void Reader::missing(const std::string& key, const std::string& meaning) {
  reading_.problems.add(node_.place, child(key), fmt::format("is missing: {}", meaning));
}

std::string Reader::with_unit(const std::string& meaning, const std::string& unit) {
  return unit == "1" ? meaning : fmt::format("{}, in {}", meaning, unit);
}

/// The nearest key of this mapping, else where else the key is known, else what is known here.
std::string Reader::cure_for(const std::string& key) const {
  const std::string here = suggestion(key, known_);
  if (here.starts_with("; did you mean")) return here;
  for (const Row& row : reference_rows()) {
    const bool same = row.path == key || (row.path.ends_with("." + key) && row.unit != "type");
    if (same) return fmt::format("; it belongs at `{}`", row.path);
  }
  return here;
}

void Reader::finish() {
  if (open_) return;
  for (const auto& [key, value] : combined_)
    if (std::find(known_.begin(), known_.end(), key) == known_.end())
      reading_.problems.add(node_.find("combine")->place, child("combine." + key),
                            "the law has no such value; leave it out");
  for (const Node::Entry& e : node_.entries) {
    if (std::find(known_.begin(), known_.end(), e.key) != known_.end()) continue;
    const std::string rule = "unknown key" + cure_for(e.key);
    if (e.value.kind == Node::Kind::scalar) {
      reading_.problems.add(e.place, child(e.key), e.value.one_line(), rule);
    } else {
      reading_.problems.add(e.place, child(e.key), rule);
    }
  }
}

void Reader::no_type(const Node& node, const std::string& path, int found, const std::vector<std::string>& words) {
  if (found > 1) {
    reading_.problems.add(node.place, path, node.one_line(), "holds two types; keep one of them");
    return;
  }
  const std::string first = node.entries.empty() ? "" : node.entries.front().key;
  reading_.problems.add(node.place, path, node.one_line(), "does not say what it is" + suggestion(first, words));
}

// ---- taking nodes apart --------------------------------------------------------------------------------------------

const std::string& Reader::scalar_of(const Node& node) {
  if (node.kind != Node::Kind::scalar) throw UnitError("must be a single value, not a list or mapping");
  return node.scalar;
}

const Node& Reader::mapping_of(const Node& node) {
  if (node.kind != Node::Kind::mapping) throw UnitError("must be a mapping: `key: value` lines, or {key: value, ...}");
  return node;
}

std::vector<const Node*> Reader::items_of(const Node& node) {
  std::vector<const Node*> items;
  if (node.kind == Node::Kind::sequence) {
    for (const Node& item : node.items) items.push_back(&item);
  } else {
    items.push_back(&node);
  }
  return items;
}

std::vector<double> Reader::numbers_of(const Node& node, const std::string& unit, std::size_t count) const {
  if (node.kind != Node::Kind::sequence) return parse_quantities(scalar_of(node), unit, count, n_);
  std::vector<double> numbers;  // [1, 0] or [1 m, 2 m]: each with its unit
  for (const Node& item : node.items) numbers.push_back(parse_quantity(scalar_of(item), unit, n_));
  if (count != 0 && numbers.size() != count) {
    throw UnitError(fmt::format("holds {} numbers; needed are {}", numbers.size(), count));
  }
  return numbers;
}

/// `range` is an interval "(0, 1]"; the cure may follow it, or stand in the meaning as "...; for no damping use 1".
void Reader::check_range(double value, const std::string& range, const std::string& unit, const std::string& meaning) {
  const std::size_t comma = range.find(','), end = range.find_first_of(")]", comma);
  const double low = std::stod(range.substr(1, comma - 1)), high = std::stod(range.substr(comma + 1, end - comma - 1));
  const bool above = range[0] == '[' ? value >= low : value > low;
  const bool below = range[end] == ']' ? value <= high : value < high;
  if (above && below) return;
  const std::string interval = range.substr(0, end + 1);
  const std::size_t hint = meaning.find("; for ");
  const std::string cure = range.substr(end + 1) + (hint == std::string::npos ? "" : meaning.substr(hint));
  throw UnitError(fmt::format("must be in {}{}{}", interval, unit == "1" ? "" : " " + unit, cure));
}

long Reader::whole_number(const Node& node, const char* range) {
  const double value = parse_number(scalar_of(node));
  if (value != std::floor(value) || std::abs(value) > 9e15) throw UnitError("must be a whole number");
  check_range(value, range, "1");
  return static_cast<long>(value);
}

// ---- values --------------------------------------------------------------------------------------------------------

void Reader::quantity(const char* key, double& value, const std::string& unit, const char* range, const char* meaning) {
  if (const auto found = combined_.find(key); found != combined_.end() && node_.find(key) == nullptr) {
    known_.push_back(key);
    value = found->second;
    return;
  }
  const bool is_n = std::string_view(key) == "n";
  leaf(key, std::isnan(value), with_unit(meaning, unit), [&](const Node& node) {
    if (n_missing_ && unit.find("(n") != std::string::npos) return;  // n itself is reported
    const double read = numbers_of(node, unit, 1).front();
    check_range(read, range, unit, meaning);
    value = read;
  });
  if (is_n && std::isnan(value)) n_missing_ = true;
  if (is_n && !std::isnan(value)) n_ = value;
}

void Reader::quantity(const char* key, std::optional<double>& value, const std::string& unit, const char* range,
                      const char* meaning) {
  double read = 0;
  quantity(key, read, unit, range, meaning);
  if (node_.find(key) != nullptr || combined_.contains(key)) value = read;
}

void Reader::optional_quantity(const char* key, double& value, const std::string& unit, const char* range,
                               const char* meaning) {
  std::optional<double> read;
  quantity(key, read, unit, range, meaning);
  if (read) value = *read;
}

void Reader::quantity_or(const char* key, std::optional<double>& value, const char* word, const char* unit,
                         const char* range, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    if (scalar_of(node) == word) {
      value.reset();
      return;
    }
    const double read = parse_quantity(node.scalar, unit);
    check_range(read, range, unit);
    value = read;
  });
}

void Reader::quantities(const char* key, std::vector<double>& values, const char* unit, const char* range,
                        const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    values = numbers_of(node, unit, 0);
    for (const double value : values) check_range(value, range, unit);
  });
}

void Reader::span(const char* key, double& least, double& largest, const char* unit, const char* range,
                  const char* meaning) {
  leaf(key, true, with_unit(meaning, unit), [&](const Node& node) {
    const std::vector<double> both = numbers_of(node, unit, 2);
    for (const double value : both) check_range(value, range, unit);
    if (!(both[0] < both[1])) throw UnitError("the first number must be less than the second");
    least = both[0], largest = both[1];
  });
}

void Reader::downward(const char* key, Vec3& value, const char* unit, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    const std::vector<double> numbers = numbers_of(node, unit, 0);
    if (numbers.size() != 1 && numbers.size() != 3) throw UnitError("must be one number (downward) or three");
    value = numbers.size() == 1 ? Vec3{0, -numbers[0], 0} : Vec3{numbers[0], numbers[1], numbers[2]};
  });
}

void Reader::version(const char* key, long& value, const char*) {
  leaf(key, true, "a scenario starts with `subsoil: 1`",
       [&](const Node& node) { value = whole_number(node, "[1, 1]; this program reads format 1"); });
}

void Reader::flag(const char* key, bool& value, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    const std::string& word = scalar_of(node);
    if (word != "yes" && word != "no" && word != "true" && word != "false") throw UnitError("must be yes or no");
    value = word == "yes" || word == "true";
  });
}

void Reader::text(const char* key, std::string& value, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) { value = scalar_of(node); });
}

namespace {
/// Names become columns such as `shovel.x` and groups of files.
const char* name_fault(const std::string& name) {
  if (name.empty()) return "a name must not be empty";
  if (name.find_first_of("./,[]\"\n\t") != std::string::npos) return "a name must not hold . / , [ ] or quotes";
  return nullptr;
}
}  // namespace

void Reader::name(const char* key, std::string& value, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    value = scalar_of(node);
    if (const char* wrong = name_fault(value)) throw UnitError(wrong);
  });
}

void Reader::check_name(const Node::Entry& entry, const std::string& path) {
  if (const char* wrong = name_fault(entry.key)) reading_.problems.add(entry.place, path + "." + entry.key, wrong);
  if (entry.key == "ground") {
    reading_.problems.add(entry.place, path + "." + entry.key, "`ground` is always there; take another name");
  }
}

void Reader::faces(const char* key, Faces& faces, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    faces = {};
    for (const Node* item : items_of(node)) {
      const auto found = std::find(face_names.begin(), face_names.end(), scalar_of(*item));
      if (found == face_names.end()) throw UnitError("faces are -x, +x, -y, +y, -z, +z");
      faces[static_cast<std::size_t>(found - face_names.begin())] = true;
    }
  });
}

void Reader::pair(const char* key, std::array<std::string, 2>& value, Family, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    if (node.kind != Node::Kind::sequence || node.items.size() != 2) {
      throw UnitError("must be two names, such as [soil, steel]");
    }
    value = {scalar_of(node.items[0]), scalar_of(node.items[1])};
  });
}

void Reader::combinations(const char* key, const std::array<std::string, 2>& between, std::vector<Combination>& combine,
                          const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    for (const Node::Entry& e : mapping_of(node).entries) try {
        std::vector<std::string> known;
        for (const Combinable& c : combinables) known.emplace_back(c.key);
        const auto what =
            std::find_if(combinables.begin(), combinables.end(), [&](const Combinable& c) { return c.key == e.key; });
        if (what == combinables.end()) throw UnitError("no value that can be combined" + suggestion(e.key, known));
        if (node_.find(e.key.c_str()) != nullptr)
          throw UnitError(fmt::format("`{}` stands in this entry too; keep the value or the rule", e.key));
        combined_[e.key] = std::nan("");  // whatever is wrong with it, it is not missing besides
        const auto word = std::find(rule_words.begin(), rule_words.end(), scalar_of(e.value));
        if (word == rule_words.end())
          throw UnitError("unknown rule" + suggestion(e.value.scalar, {rule_words.begin(), rule_words.end()}));
        const auto rule = static_cast<CombinationRule>(word - rule_words.begin());
        combined_[e.key] = this->combine(*what, rule, between);
        combine.push_back({e.key, rule});
      } catch (const UnitError& fault) {
        this->fault(e.value, child(key) + "." + e.key, fault.what());
      }
  });
}

/// NaN where a name is no material's, which is reported elsewhere.
double Reader::combine(const Combinable& what, CombinationRule rule, const std::array<std::string, 2>& between) const {
  double values[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const auto m = std::find_if(reading_.materials.begin(), reading_.materials.end(),
                                [&](const Material& material) { return material.name == between[i]; });
    if (m == reading_.materials.end()) return std::nan("");
    if (!((*m).*what.value))
      throw UnitError(
          fmt::format("material `{0}` has no {1}; give it there, or the pair's {1} here in place of the rule",
                      between[i], what.key));
    values[i] = *((*m).*what.value);
  }
  return combined(rule, values[0], values[1]);
}

// ---- files ---------------------------------------------------------------------------------------------------------

void Reader::input_file(const char* key, std::string& value, bool needed, const char* meaning) {
  leaf(key, needed, meaning, [&](const Node& node) {
    value = beside(node.place, scalar_of(node));
    if (!fs::is_regular_file(value)) throw UnitError(fmt::format("there is no file {}", value));
  });
}

void Reader::output_file(const char* key, std::string& value, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) { value = beside(node.place, scalar_of(node)); });
}

void Reader::unit(const char* key, double& size, const char* expected, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    const std::string& text = scalar_of(node);
    const bool number_first = !text.empty() && text[0] >= '0' && text[0] <= '9';
    size = parse_quantity(number_first ? text : "1 " + text, expected);
    check_range(size, "(0, inf)", expected);
  });
}

namespace {

/// Points `x, y` of a CSV file whose header names the unit: `x [mm], y [mm]`.
std::vector<Vec2> outline_of_file(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw UnitError(fmt::format("there is no file {}", file));
  std::vector<Vec2> points;
  std::string line, unit;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    const std::size_t comma = line.find(',');
    const auto refuse = [&](const char* rule) { throw UnitError(fmt::format("{}:{}: {}", file, number, rule)); };
    if (comma == std::string::npos) refuse("must hold two columns with a comma between");
    if (unit.empty()) {
      const std::size_t open = line.find('['), close = line.find(']');
      if (open == std::string::npos || close == std::string::npos)
        refuse("must be a header with the unit: x [mm], y [mm]");
      unit = line.substr(open + 1, close - open - 1);
      continue;
    }
    try {
      points.push_back({parse_quantity(line.substr(0, comma) + " " + unit, "m"),
                        parse_quantity(line.substr(comma + 1) + " " + unit, "m")});
    } catch (const UnitError& e) {
      refuse(e.what());
    }
  }
  return points;
}

}  // namespace

void Reader::read_outline(const char* key, std::vector<Vec2>& points, bool needed, const char* meaning) {
  leaf(key, needed, meaning, [&](const Node& node) {
    if (node.kind == Node::Kind::scalar) {
      points = outline_of_file(beside(node.place, node.scalar));
    } else {
      for (const Node* item : items_of(node)) {
        const std::vector<double> p = numbers_of(*item, "m", 2);
        points.push_back({p[0], p[1]});
      }
    }
    if (points.size() < 3) throw UnitError("an outline needs at least three points");
  });
}

void Reader::table(const char* key, std::vector<double>& xs, std::vector<double>& ys, const std::string& x_unit,
                   const std::string& y_unit, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    if (node.kind == Node::Kind::mapping) {  // {8 mm: 0.3, 10 mm: 0.7}
      for (const Node::Entry& e : node.entries) {
        xs.push_back(parse_quantity(e.key, x_unit, n_));
        ys.push_back(numbers_of(e.value, y_unit, 1).front());
      }
      return;
    }
    const std::string rule = fmt::format("must be a list of pairs such as [[1 {0}, 2 {1}], [3 {0}, 4 {1}]]",
                                         x_unit == "1" ? "" : x_unit, y_unit == "1" ? "" : y_unit);
    if (node.kind != Node::Kind::sequence) throw UnitError(rule);
    for (const Node& row : node.items) {
      if (row.kind != Node::Kind::sequence || row.items.size() != 2) throw UnitError(rule);
      xs.push_back(numbers_of(row.items[0], x_unit, 1).front());
      ys.push_back(numbers_of(row.items[1], y_unit, 1).front());
    }
  });
}

}  // namespace subsoil::app
