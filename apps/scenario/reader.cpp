#include "apps/scenario/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace subsoil::app {
namespace fs = std::filesystem;

const std::array<const char*, 6>& watch_words();  // printer.cpp

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

void Reader::finish() {
  if (open_) return;
  for (const Node::Entry& e : node_.entries) {
    if (std::find(known_.begin(), known_.end(), e.key) != known_.end()) continue;
    const std::string rule = "unknown key" + suggestion(e.key, known_);
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

/// `range` is an interval "(0, 1]", perhaps followed by "; cure".
void Reader::check_range(double value, const std::string& range, const std::string& unit) {
  const std::size_t comma = range.find(','), end = range.find_first_of(")]", comma);
  const double low = std::stod(range.substr(1, comma - 1)), high = std::stod(range.substr(comma + 1, end - comma - 1));
  const bool above = range[0] == '[' ? value >= low : value > low;
  const bool below = range[end] == ']' ? value <= high : value < high;
  if (above && below) return;
  const std::string interval = range.substr(0, end + 1), cure = range.substr(end + 1);
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
  const bool is_n = std::string_view(key) == "n";
  leaf(key, std::isnan(value), with_unit(meaning, unit), [&](const Node& node) {
    if (n_missing_ && unit.find("(n") != std::string::npos) return;  // n itself is reported
    const double read = numbers_of(node, unit, 1).front();
    check_range(read, range, unit);
    value = read;
  });
  if (is_n && std::isnan(value)) n_missing_ = true;
  if (is_n && !std::isnan(value)) n_ = value;
}

void Reader::quantity(const char* key, std::optional<double>& value, const std::string& unit, const char* range,
                      const char* meaning) {
  double read = 0;
  quantity(key, read, unit, range, meaning);
  if (node_.find(key) != nullptr) value = read;
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
  leaf(key, true, "a scenario starts with `subsoil: 1`", [&](const Node& node) {
    value = whole_number(node, "[1, 1]; this program reads format 1");
  });
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
std::vector<Vec2> read_outline(const std::string& file) {
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
      if (open == std::string::npos || close == std::string::npos) refuse("must be a header with the unit: x [mm], y [mm]");
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

void Reader::outline(const char* key, std::vector<Vec2>& points, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    if (node.kind == Node::Kind::scalar) {
      points = read_outline(beside(node.place, node.scalar));
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

// ---- functions of time ---------------------------------------------------------------------------------------------

void Reader::read_function(const char* key, Function& value, const std::string& unit, bool needed,
                           const char* meaning) {
  leaf(key, needed, with_unit(meaning, unit),
       [&](const Node& node) { value = function_of(node, child(key), unit); });
}

Function Reader::function_of(const Node& node, const std::string& path, const std::string& unit) {
  if (node.kind == Node::Kind::scalar) return Function(numbers_of(node, unit, 1).front());
  if (node.kind == Node::Kind::sequence) {  // terms that add up
    mbd::SumFunction sum;
    for (const Node& term : node.items) sum.terms.push_back(function_of(term, path, unit));
    return Function(std::move(sum));
  }
  Function function;
  const std::size_t before = reading_.problems.lines().size();
  with_type<mbd::FunctionKinds>(node, path, [&]<class Kind>(std::type_identity<Kind>) {
    const std::string& word = card_of<Kind>().word;
    const Node& given = node.find(word)->value;
    Node parameters = given;
    if (given.kind == Node::Kind::sequence) {  // {table: [[0 s, 0 m], ...]}
      parameters = Node::mapping();
      parameters.place = given.place;
      parameters.add("points", given);
    }
    Kind kind;
    Reader reader(reading_, mapping_of(parameters), path + "." + word);
    kind.describe(reader, unit);
    reader.finish();
    if (node.entries.size() > 1) throw UnitError(fmt::format("only `{}` may stand here; its parameters belong inside it", word));
    if (reading_.problems.lines().size() == before) function = Function(std::move(kind));
  });
  open_ = false;  // an unknown kind of function says nothing about the other keys
  return function;
}

// ---- bodies and points ---------------------------------------------------------------------------------------------

void Reader::remember(const Body& body) {
  reading_.body_names.push_back(body.name);
  reading_.body_poses.emplace_back(mbd::Vec2{body.at[0], body.at[1]}, body.angle, mbd::Vec2{}, 0.0);
}

int Reader::body_of(const Node& node) const {
  const std::string& name = scalar_of(node);
  const auto found = std::find(reading_.body_names.begin(), reading_.body_names.end(), name);
  if (found == reading_.body_names.end()) throw UnitError("there is no body of this name" + suggestion(name, reading_.body_names));
  return static_cast<int>(found - reading_.body_names.begin());
}

const mbd::BodyState* Reader::pose_of(int index) const {
  const auto i = static_cast<std::size_t>(index);
  return index >= 0 && i < reading_.body_poses.size() ? &reading_.body_poses[i] : nullptr;
}

void Reader::body(const char* key, int& index, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    index = body_of(node);
    if (index == mbd::ground) throw UnitError("must be a moving body, not the ground");
  });
}

void Reader::bodies(const char* key, int& a, int& b, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    if (node.kind != Node::Kind::sequence || node.items.size() != 2) {
      throw UnitError("must be two bodies, such as [frame, shovel] or [ground, trolley]");
    }
    const int first = body_of(node.items[0]), second = body_of(node.items[1]);
    if (first == second) throw UnitError("the two bodies must differ");
    a = first, b = second;
  });
}

void Reader::coordinate(const char* key, int& index, mbd::Coordinate& coordinate, const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    const std::string& text = scalar_of(node);
    const std::size_t dot = text.rfind('.');
    const std::string axis = dot == std::string::npos ? "" : text.substr(dot + 1);
    if (axis != "x" && axis != "y" && axis != "angle") throw UnitError("must be body.x, body.y or body.angle");
    Node name = node;
    name.scalar = text.substr(0, dot);
    index = body_of(name);
    if (index == mbd::ground) throw UnitError("must be a moving body, not the ground");
    coordinate = axis == "x" ? mbd::Coordinate::x : axis == "y" ? mbd::Coordinate::y : mbd::Coordinate::angle;
  });
}

std::vector<Vec2> Reader::two_points(const Node& node) {
  if (node.kind != Node::Kind::sequence || node.items.size() != 2) {
    throw UnitError("must be a list of two points, such as [0 0.2 m, 0.1 0 m]");
  }
  std::vector<Vec2> points;
  for (const Node& item : node.items) {
    const std::vector<double> p = numbers_of(item, "m", 2);
    points.push_back({p[0], p[1]});
  }
  return points;
}

void Reader::joint_point(int a, Vec2& p_a, int b, Vec2& p_b, const char* meaning) {
  // Any point of a slide's line will do, so it may be left out there; a pin must say where it is.
  if (node_.find("at") == nullptr && node_.find("points") == nullptr && node_.find("along") == nullptr) {
    known_.insert(known_.end(), {"at", "points"});
    missing("at", with_unit(meaning, "m"));
    return;
  }
  optional_joint_point(a, p_a, b, p_b, meaning);
}

void Reader::optional_joint_point(int a, Vec2& p_a, int b, Vec2& p_b, const char* meaning) {
  const mbd::BodyState *pose_a = pose_of(a), *pose_b = pose_of(b);
  const bool posed = pose_a != nullptr && pose_b != nullptr;
  const auto place = [&](mbd::Vec2 world) {
    if (posed) p_a = pose_a->local(world), p_b = pose_b->local(world);
  };
  if (posed) place(b != mbd::ground ? pose_b->r : pose_a->r);  // left out: the centre of mass of the moving body
  leaf("at", false, meaning, [&](const Node& node) {
    const std::vector<double> p = numbers_of(node, "m", 2);
    place({p[0], p[1]});
  });
  leaf("points", false, meaning, [&](const Node& node) {
    if (node_.find("at") != nullptr) throw UnitError("stands beside `at`, which says the same; keep one of them");
    const std::vector<Vec2> both = two_points(node);
    p_a = both[0], p_b = both[1];
  });
}

void Reader::end_points(int a, Vec2& p_a, int b, Vec2& p_b, const char* meaning) {
  const mbd::BodyState *pose_a = pose_of(a), *pose_b = pose_of(b);
  leaf("ends", node_.find("points") == nullptr, with_unit(meaning, "m"), [&](const Node& node) {
    const std::vector<Vec2> both = two_points(node);
    if (pose_a == nullptr || pose_b == nullptr) return;
    p_a = pose_a->local({both[0][0], both[0][1]});
    p_b = pose_b->local({both[1][0], both[1][1]});
  });
  leaf("points", false, meaning, [&](const Node& node) {
    if (node_.find("ends") != nullptr) throw UnitError("stands beside `ends`, which says the same; keep one of them");
    const std::vector<Vec2> both = two_points(node);
    p_a = both[0], p_b = both[1];
  });
}

void Reader::point(const char* key, int index, Vec2& p, const char* meaning) {
  const mbd::BodyState* pose = pose_of(index);
  leaf(key, false, meaning, [&](const Node& node) {
    const std::vector<double> w = numbers_of(node, "m", 2);
    if (pose != nullptr) p = pose->local({w[0], w[1]});
  });
  leaf("point", false, meaning, [&](const Node& node) {
    if (node_.find(key) != nullptr) throw UnitError(fmt::format("stands beside `{}`, which says the same; keep one", key));
    const std::vector<double> w = numbers_of(node, "m", 2);
    p = {w[0], w[1]};
  });
}

void Reader::axis(const char* key, int a, double& angle_a, const char* meaning) {
  const std::string by_angle = std::string(key) + " angle";
  const mbd::BodyState* pose = pose_of(a);
  leaf(key, node_.find(by_angle) == nullptr, meaning, [&](const Node& node) {
    const std::vector<double> d = numbers_of(node, "1", 2);
    if (d[0] == 0 && d[1] == 0) throw UnitError("a direction must not be the zero vector");
    angle_a = std::atan2(d[1], d[0]) - (pose == nullptr ? 0 : pose->angle);
  });
  leaf(by_angle.c_str(), false, meaning, [&](const Node& node) { angle_a = numbers_of(node, "rad", 1).front(); });
}

// ---- start, watch --------------------------------------------------------------------------------------------------

void Reader::start(const char* key, Start& start, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    if (node.kind == Node::Kind::scalar) {
      if (node.scalar != "pose") throw UnitError("must be `pose` or {towing equilibrium: 0.5 m/s}");
      return;
    }
    Reader reader(reading_, mapping_of(node), child(key));
    start.kind = StartKind::towing_equilibrium;
    start.speed = required;
    reader.quantity("towing equilibrium", start.speed, "m/s", "(-inf, inf)", "speed along x of all bodies");
    reader.finish();
  });
}

void Reader::watches(const char* key, std::vector<Watch>& watches, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    for (const Node::Entry& e : mapping_of(node).entries) {
      Watch& watch = watches.emplace_back();
      watch.name = e.key;
      check_name(e, child(key));
      const std::string path = child(key) + "." + e.key;
      reading_.places[path] = e.value.place;
      if (e.value.kind == Node::Kind::scalar) {
        watch.of = e.value.scalar;
        continue;
      }
      if (e.value.kind != Node::Kind::mapping) {
        fault(e.value, path, "must be a column such as shovel.angle, or {driver: H10}");
        continue;
      }
      Reader reader(reading_, e.value, path);
      int found = 0;
      for (std::size_t i = 0; i < watch_words().size(); ++i) {
        const char* word = watch_words()[i];
        if (e.value.find(word) == nullptr) {
          reader.known_.push_back(word);
          continue;
        }
        ++found;
        watch.kind = static_cast<Watch::Kind>(i);
        reader.reference(word, watch.of, Family::body, "what is watched");
      }
      if (found != 1) no_type(e.value, path, found, {watch_words().begin(), watch_words().end()});
      reader.open_ = found != 1;
      reader.leaf("along", false, "direction", [&](const Node& along) {
        const std::vector<double> d = numbers_of(along, "1", 0);
        if (d.size() != 2 && d.size() != 3) throw UnitError("must be two or three numbers");
        watch.along = {d[0], d[1], d.size() == 3 ? d[2] : 0};
        if (watch.along == Vec3{}) throw UnitError("a direction must not be the zero vector");
      });
      reader.finish();
    }
  });
}

}  // namespace subsoil::app
