#include <fmt/format.h>

#include <algorithm>

#include "apps/scenario/expression.hpp"
#include "apps/scenario/reader.hpp"

/// The part of the reader that machines use: functions of time, characteristics, bodies, points of the start pose,
/// turns, start, watch.
namespace subsoil::app {

// ---- functions of time, characteristics ----------------------------------------------------------------------------

template <class Law, class Kinds, class... Units>
Law Reader::law_of(const Node& node, const std::string& path, const Units&... units) {
  Law law;
  const bool was_open = open_;
  const std::size_t before = reading_.problems.count();
  with_type<Kinds>(node, path, [&]<class Kind>(std::type_identity<Kind>) {
    const std::string& word = card_of<Kind>().word;
    const Node& given = node.find(word)->value;
    Kind kind;
    if constexpr (requires { Kind::word_is_key; }) {  // {expression: "sin(t)", unit: m}
      Reader reader(reading_, node, path);
      kind.describe(reader, units...);
      reader.finish();
    } else {
      Node parameters = given;
      if (given.kind == Node::Kind::sequence) {  // {table: [[0 s, 0 m], ...]}
        parameters = Node::mapping();
        parameters.place = given.place;
        parameters.add("points", given);
      }
      Reader reader(reading_, mapping_of(parameters), path + "." + word);
      kind.describe(reader, units...);
      reader.finish();
      if (node.entries.size() > 1)
        throw UnitError("only `" + word + "` may stand here; its parameters belong inside it");
    }
    if (reading_.problems.count() == before) law = Law(std::move(kind));
  });
  open_ = was_open;  // an unknown kind of law says nothing about the other keys
  return law;
}

void Reader::read_function(const char* key, Function& value, const std::string& unit, bool needed,
                           const char* meaning) {
  leaf(key, needed, with_unit(meaning, unit), [&](const Node& node) { value = function_of(node, child(key), unit); });
}

Function Reader::function_of(const Node& node, const std::string& path, const std::string& unit) {
  if (node.kind == Node::Kind::scalar) return Function(numbers_of(node, unit, 1).front());
  if (node.kind == Node::Kind::sequence) {  // terms that add up
    mbd::SumFunction sum;
    for (const Node& term : node.items) sum.terms.push_back(function_of(term, path, unit));
    return Function(std::move(sum));
  }
  return law_of<Function, mbd::FunctionKinds>(node, path, unit);
}

void Reader::optional_characteristic(const char* key, mbd::Characteristic& value, const std::string& x_unit,
                                     const std::string& unit, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    value = law_of<mbd::Characteristic, mbd::CharacteristicKinds>(mapping_of(node), child(key), x_unit, unit);
  });
}

void Reader::formula(const char* key, std::string& text, std::function<double(double, double, double)>& call,
                     const char* meaning) {
  leaf(key, true, meaning, [&](const Node& node) {
    text = scalar_of(node);
    call = make_formula(text, {"z", "v", "m"});
  });
}

void Reader::expression(const char* key, mbd::ExpressionFunction& value, const std::string& unit, const char* meaning) {
  std::string given;
  double size = 1;
  leaf("unit", unit != "1", fmt::format("the unit of the formula's value, such as {}", unit), [&](const Node& node) {
    given = scalar_of(node);
    size = parse_quantity("1 " + given, unit);
  });
  leaf(key, true, meaning, [&](const Node& node) { value = make_expression(scalar_of(node), given, size); });
}

// ---- bodies and points ---------------------------------------------------------------------------------------------

void Reader::remember(const Body& body) {
  reading_.body_names.push_back(body.name);
  reading_.body_poses.emplace_back(mbd::Vec2{body.at[0], body.at[1]}, body.angle, mbd::Vec2{}, 0.0);
}

int Reader::body_of(const Node& node) const {
  const std::string& name = scalar_of(node);
  const auto found = std::find(reading_.body_names.begin(), reading_.body_names.end(), name);
  if (found == reading_.body_names.end())
    throw UnitError("there is no body of this name" + suggestion(name, reading_.body_names));
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

/// A marker of the machine; a body or the ground stands for the marker of its own axes.
mbd::Marker Reader::marker_of(const Node& node) const {
  const std::string& name = scalar_of(node);
  std::vector<std::string> known = reading_.body_names;
  for (const mbd::Marker& m : reading_.markers) {
    if (m.name == name) return m;
    known.push_back(m.name);
  }
  for (std::size_t i = 0; i < reading_.body_names.size(); ++i)
    if (reading_.body_names[i] == name) return {.name = name, .body = static_cast<int>(i)};
  throw UnitError("there is no marker or body of this name" + suggestion(name, known));
}

void Reader::take_markers(const Node& node, std::span<mbd::Marker> values) const {
  if (node.kind != Node::Kind::sequence || node.items.size() != values.size())
    throw UnitError(fmt::format("must be a list of {} markers or bodies, such as [{}]", values.size(),
                                values.size() == 2 ? "base, tip" : "base, elbow, tip"));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = marker_of(node.items[i]);
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
    if (posed) p_a = pose_a->point_in_body(world), p_b = pose_b->point_in_body(world);
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
    p_a = pose_a->point_in_body({both[0][0], both[0][1]});
    p_b = pose_b->point_in_body({both[1][0], both[1][1]});
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
    if (pose != nullptr) p = pose->point_in_body({w[0], w[1]});
  });
  leaf("point", false, meaning, [&](const Node& node) {
    if (node_.find(key) != nullptr)
      throw UnitError(fmt::format("stands beside `{}`, which says the same; keep one", key));
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

// ---- turns, start, watch
// --------------------------------------------------------------------------------------------------

void Reader::turns(const char* key, Rotation& rotation, const char* meaning) {
  leaf(key, false, meaning, [&](const Node& node) {
    if (node_.find("axis") != nullptr || node_.find("angle") != nullptr) {
      throw UnitError("stands beside `axis` and `angle`, which say the same; keep one of them");
    }
    const std::vector<double> a = numbers_of(node, "rad", 3);
    const auto turn = [](const Vec3& v) { return dem::Quaternion::from_rotation_vector(v); };
    const dem::Quaternion q = turn({0, 0, a[2]}) * turn({0, a[1], 0}) * turn({a[0], 0, 0});
    const Vec3 v{q.x, q.y, q.z};
    const double sine = dem::norm(v);
    if (sine > 0) rotation = {v * (1 / sine), 2 * std::atan2(sine, q.w)};
  });
}

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
      for (std::size_t i = 0; i < watch_words.size(); ++i) {
        const char* word = watch_words[i];
        if (e.value.find(word) == nullptr) {
          reader.known_.push_back(word);
          continue;
        }
        ++found;
        watch.kind = static_cast<Watch::Kind>(i);
        reader.reference(word, watch.of, Family::body, "what is watched");
      }
      if (found != 1) no_type(e.value, path, found, {watch_words.begin(), watch_words.end()});
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
