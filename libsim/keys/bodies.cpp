#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmbd/base/body.hpp"
#include "libmbd/base/coordinate.hpp"
#include "libmbd/base/marker.hpp"
#include "libsim/document/units.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"

/// Bodies, markers, and points given in the world of the start pose or in body axes.
namespace subsoil::sim {
namespace {

int body_of(const Node& node, const Reading& reading) {
  const std::string& name = scalar_of(node);
  const auto found = std::find(reading.body_names.begin(), reading.body_names.end(), name);
  if (found == reading.body_names.end())
    throw Refusal("there is no body of this name" + suggestion(name, reading.body_names));
  return static_cast<int>(found - reading.body_names.begin());
}

int moving_body_of(const Node& node, const Reading& reading) {
  const int index = body_of(node, reading);
  if (index == mbd::ground) throw Refusal("must be a moving body, not the ground");
  return index;
}

std::string name_of_body(const PrintScope& scope, int index) {
  const auto i = static_cast<std::size_t>(index);
  return i < scope.bodies.size() ? scope.bodies[i] : "?";
}

class BodyIndex final : public Value {
 public:
  BodyIndex(int& index, bool may_be_ground) : index_(index), may_be_ground_(may_be_ground) {}
  void read(const Node& node, const ReadScope& scope) override {
    index_ = may_be_ground_ ? body_of(node, scope.reading) : moving_body_of(node, scope.reading);
  }
  Node print(const PrintScope& scope) const override {
    return index_ < 0 ? Node{} : Node::of(name_of_body(scope, index_));
  }
  std::string what() const override { return may_be_ground_ ? "name of a body, or ground" : "name of a body"; }
  Json schema() const override { return text_form(); }

 private:
  int& index_;
  bool may_be_ground_;
};

class TwoBodies final : public Value {
 public:
  TwoBodies(int& a, int& b) : a_(a), b_(b) {}
  void read(const Node& node, const ReadScope& scope) override {
    if (node.kind != Node::Kind::sequence || node.items.size() != 2)
      throw Refusal("must be two bodies, such as [frame, shovel] or [ground, trolley]");
    const int first = body_of(node.items[0], scope.reading), second = body_of(node.items[1], scope.reading);
    if (first == second) throw Refusal("the two bodies must differ");
    a_ = first, b_ = second;
  }
  Node print(const PrintScope& scope) const override {
    return a_ < 0 ? Node{} : sequence({name_of_body(scope, a_), name_of_body(scope, b_)});
  }
  std::string what() const override { return "[name of a body, name of a body]"; }
  Json schema() const override { return list_form(text_form(), 2); }

 private:
  int &a_, &b_;
};

/// A body and x, y or angle of it.
class BodyCoordinate final : public Value {
 public:
  BodyCoordinate(int& index, mbd::Coordinate& coordinate) : index_(index), coordinate_(coordinate) {}
  void read(const Node& node, const ReadScope& scope) override {
    const std::string& text = scalar_of(node);
    const std::size_t dot = text.rfind('.');
    const std::string axis = dot == std::string::npos ? "" : text.substr(dot + 1);
    const auto found = std::find(axes.begin(), axes.end(), axis);
    if (found == axes.end()) throw Refusal("must be body.x, body.y or body.angle");
    Node name = node;
    name.scalar = text.substr(0, dot);
    index_ = moving_body_of(name, scope.reading);
    coordinate_ = static_cast<mbd::Coordinate>(found - axes.begin());
  }
  Node print(const PrintScope& scope) const override {
    if (index_ < 0) return {};
    return Node::of(name_of_body(scope, index_) + "." + axes[static_cast<std::size_t>(coordinate_)]);
  }
  std::string what() const override { return "body.x, body.y or body.angle"; }
  Json schema() const override { return text_form(R"([.](x|y|angle)$)"); }

 private:
  static constexpr std::array<const char*, 3> axes{"x", "y", "angle"};  // in the order of mbd::Coordinate
  int& index_;
  mbd::Coordinate& coordinate_;
};

/// A marker of the machine; a body or the ground stands for the marker of its own axes.
mbd::Marker marker_of(const Node& node, const Reading& reading) {
  const std::string& name = scalar_of(node);
  std::vector<std::string> known = reading.body_names;
  for (const mbd::Marker& m : reading.markers) {
    if (m.name == name) return m;
    known.push_back(m.name);
  }
  for (std::size_t i = 0; i < reading.body_names.size(); ++i)
    if (reading.body_names[i] == name) return {.name = name, .body = static_cast<int>(i)};
  throw Refusal("there is no marker or body of this name" + suggestion(name, known));
}

class MarkerName final : public Value {
 public:
  explicit MarkerName(mbd::Marker& value) : value_(value) {}
  void read(const Node& node, const ReadScope& scope) override { value_ = marker_of(node, scope.reading); }
  Node print(const PrintScope&) const override { return value_.name.empty() ? Node{} : Node::of(value_.name); }
  std::string what() const override { return "name of a marker or body"; }
  Json schema() const override { return text_form(); }

 private:
  mbd::Marker& value_;
};

class MarkerNames final : public Value {
 public:
  explicit MarkerNames(std::span<mbd::Marker> values) : values_(values) {}
  void read(const Node& node, const ReadScope& scope) override {
    if (node.kind != Node::Kind::sequence || node.items.size() != values_.size())
      throw Refusal(fmt::format("must be a list of {} markers or bodies, such as [{}]", values_.size(),
                                values_.size() == 2 ? "base, tip" : "base, elbow, tip"));
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = marker_of(node.items[i], scope.reading);
  }
  Node print(const PrintScope&) const override {
    std::vector<std::string> names;
    for (const mbd::Marker& m : values_) names.push_back(m.name);
    return values_[0].name.empty() ? Node{} : sequence(names);
  }
  std::string what() const override { return fmt::format("{} markers or bodies", values_.size()); }
  Json schema() const override { return list_form(text_form(), values_.size()); }

 private:
  std::span<mbd::Marker> values_;
};

// ---- points --------------------------------------------------------------------------------------------------------

std::vector<Vec2> two_points(const Node& node, const Reader& reader) {
  if (node.kind != Node::Kind::sequence || node.items.size() != 2)
    throw Refusal("must be a list of two points, such as [0 0.2 m, 0.1 0 m]");
  std::vector<Vec2> points;
  for (const Node& item : node.items) {
    const std::vector<double> p = numbers_of(item, "m", 2, reader.exponent());
    points.push_back({p[0], p[1]});
  }
  return points;
}

/// One point per body, by `points`, each in its body's axes, or in the world of the start pose by another key.
class PairOfPoints : public Compound {
 public:
  PairOfPoints(int a, Vec2& p_a, int b, Vec2& p_b) : a_(a), b_(b), p_a_(p_a), p_b_(p_b) {}
  void print(Printer& printer, const Field& field) const override {
    printer.leaf("points", sequence({format_quantities(p_a_.data(), 2, "m"), format_quantities(p_b_.data(), 2, "m")}),
                 field.meaning);
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, what(), field.needed ? "required" : "left out", "",
             fmt::format("{}; in the world of the start pose", field.meaning));
    keys.add("points", "list of two points, 2 numbers m each", "left out", "",
             fmt::format("instead of `{}`: one point per body, each in its body's own axes", field.key));
  }
  void outline(Schema& schema, const Field& field) const override {
    Field alone = field;
    alone.needed = false;
    const Json two = list_form(numbers_form("m", 2), 2);
    schema.add(alone, of_world());
    schema.add({"points", fmt::format("instead of `{}`: one point per body, each in its body's own axes", field.key)},
               two);
    schema.rule(not_beside(field.key, "points"));
    if (field.needed) schema.rule(needs_one_of(keys_that_say_where(field)));
  }

 protected:
  virtual const char* what() const = 0;
  virtual Json of_world() const = 0;
  virtual std::vector<std::string> keys_that_say_where(const Field& field) const { return {field.key, "points"}; }
  void read_points(Reader& reader, const Field& field) {
    reader.leaf({"points", field.meaning}, [&](const Node& node) {
      if (reader.holds(field.key))
        throw Refusal(fmt::format("stands beside `{}`, which has the same meaning", field.key), "keep one of them");
      const std::vector<Vec2> both = two_points(node, reader);
      p_a_ = both[0], p_b_ = both[1];
    });
  }
  int a_, b_;
  Vec2 &p_a_, &p_b_;
};

/// A point that both bodies share.
class CommonPoint final : public PairOfPoints {
 public:
  using PairOfPoints::PairOfPoints;
  void read(Reader& reader, const Field& field) override {
    // Any point of a slide's line will do, so it may be left out there; a pin must say where it is.
    if (field.needed && !reader.holds("at") && !reader.holds("points") && !reader.holds("along")) {
      reader.know("at"), reader.know("points");
      reader.missing(field);
      return;
    }
    const mbd::BodyState *pose_a = reader.reading().pose_of(a_), *pose_b = reader.reading().pose_of(b_);
    const bool posed = pose_a != nullptr && pose_b != nullptr;
    const auto place = [&](mbd::Vec2 world) {
      if (posed) p_a_ = pose_a->point_in_body(world), p_b_ = pose_b->point_in_body(world);
    };
    if (posed) place(b_ != mbd::ground ? pose_b->r : pose_a->r);  // left out: the centre of mass of the moving body
    reader.leaf({"at", field.meaning}, [&](const Node& node) {
      const std::vector<double> p = numbers_of(node, "m", 2, reader.exponent());
      place({p[0], p[1]});
    });
    read_points(reader, field);
  }

 private:
  const char* what() const override { return "2 numbers m"; }
  Json of_world() const override { return numbers_form("m", 2); }
  std::vector<std::string> keys_that_say_where(const Field&) const override { return {"at", "points", "along"}; }
};

/// Two points in the world of the start pose, one of each body.
class EndPoints final : public PairOfPoints {
 public:
  using PairOfPoints::PairOfPoints;
  void read(Reader& reader, const Field& field) override {
    const mbd::BodyState *pose_a = reader.reading().pose_of(a_), *pose_b = reader.reading().pose_of(b_);
    Field ends = field;
    ends.needed = !reader.holds("points");
    reader.leaf(ends, [&](const Node& node) {
      const std::vector<Vec2> both = two_points(node, reader);
      if (pose_a == nullptr || pose_b == nullptr) return;
      p_a_ = pose_a->point_in_body({both[0][0], both[0][1]});
      p_b_ = pose_b->point_in_body({both[1][0], both[1][1]});
    });
    read_points(reader, field);
  }

 private:
  const char* what() const override { return "list of two points, 2 numbers m each"; }
  Json of_world() const override { return list_form(numbers_form("m", 2), 2); }
};

class OnePoint final : public Compound {
 public:
  OnePoint(int index, Vec2& p) : index_(index), p_(p) {}
  void read(Reader& reader, const Field& field) override {
    const mbd::BodyState* pose = reader.reading().pose_of(index_);
    reader.leaf(field, [&](const Node& node) {
      const std::vector<double> w = numbers_of(node, "m", 2, reader.exponent());
      if (pose != nullptr) p_ = pose->point_in_body({w[0], w[1]});
    });
    reader.leaf({"point", field.meaning}, [&](const Node& node) {
      if (reader.holds(field.key))
        throw Refusal(fmt::format("stands beside `{}`, which has the same meaning", field.key), "keep one");
      const std::vector<double> w = numbers_of(node, "m", 2, reader.exponent());
      p_ = {w[0], w[1]};
    });
  }
  void print(Printer& printer, const Field& field) const override {
    printer.leaf("point", Node::of(format_quantities(p_.data(), 2, "m")), field.meaning);
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "2 numbers m", "left out", "",
             fmt::format("{}; in the world of the start pose", field.meaning));
    keys.add("point", "2 numbers m", "left out", "", fmt::format("instead of `{}`: in the body's own axes", field.key));
  }
  void outline(Schema& schema, const Field& field) const override {
    schema.add(field, numbers_form("m", 2));
    schema.add({"point", fmt::format("instead of `{}`: in the body's own axes", field.key)}, numbers_form("m", 2));
    schema.rule(not_beside(field.key, "point"));
  }

 private:
  int index_;
  Vec2& p_;
};

/// A direction of a body: a world vector of the start pose, or its angle in body axes.
class Axis final : public Compound {
 public:
  Axis(int a, double& angle_a) : a_(a), angle_a_(angle_a) {}
  void read(Reader& reader, const Field& field) override {
    const std::string by_angle = field.key + " angle";
    const mbd::BodyState* pose = reader.reading().pose_of(a_);
    Field vector = field;
    vector.needed = !reader.holds(by_angle);
    reader.leaf(vector, [&](const Node& node) {
      const std::vector<double> d = numbers_of(node, "1", 2, reader.exponent());
      if (d[0] == 0 && d[1] == 0) throw Refusal("a direction must not be the zero vector");
      angle_a_ = std::atan2(d[1], d[0]) - (pose == nullptr ? 0 : pose->angle);
    });
    reader.leaf({by_angle, field.meaning},
                [&](const Node& node) { angle_a_ = numbers_of(node, "rad", 1, reader.exponent()).front(); });
  }
  void print(Printer& printer, const Field& field) const override {
    printer.leaf(field.key + " angle", Node::of(format_quantity(angle_a_, "rad")), field.meaning);
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "2 numbers", "required", "", fmt::format("{}: a world vector of any length", field.meaning));
    keys.add(field.key + " angle", "rad", "left out", "",
             fmt::format("instead of `{}`: the direction's angle in its body's own axes", field.key));
  }
  void outline(Schema& schema, const Field& field) const override {
    const std::string by_angle = field.key + " angle";
    Field alone = field;
    alone.needed = false;
    schema.add(alone, numbers_form("1", 2), "a world vector of any length");
    schema.add({by_angle, fmt::format("instead of `{}`: the direction's angle in its body's own axes", field.key)},
               number_form("rad"));
    schema.rule(needs_one_of({field.key, by_angle}));
  }

 private:
  int a_;
  double& angle_a_;
};

}  // namespace

void Fields::body(const char* key, int& index, Text meaning) {
  BodyIndex body(index, false);
  visit_value({key, meaning, true}, body);
}

void Fields::optional_body(const char* key, int& index, Text meaning) {
  BodyIndex body(index, true);
  visit_value({key, meaning}, body);
}

void Fields::bodies(const char* key, int& a, int& b, Text meaning) {
  TwoBodies bodies(a, b);
  visit_value({key, meaning, true}, bodies);
}

void Fields::coordinate(const char* key, int& index, mbd::Coordinate& coordinate, Text meaning) {
  BodyCoordinate value(index, coordinate);
  visit_value({key, meaning, true}, value);
}

void Fields::marker(const char* key, mbd::Marker& value, Text meaning) {
  MarkerName name(value);
  visit_value({key, meaning, true}, name);
}

void Fields::optional_marker(const char* key, mbd::Marker& value, Text meaning) {
  MarkerName name(value);
  visit_value({key, meaning}, name);
}

void Fields::take_markers(const char* key, std::span<mbd::Marker> values, Text meaning) {
  MarkerNames names(values);
  visit_value({key, meaning, true}, names);
}

void Fields::joint_point(int a, Vec2& p_a, int b, Vec2& p_b, Text meaning) {
  CommonPoint point(a, p_a, b, p_b);
  visit_compound({"at", meaning, true, "m"}, point);
}

void Fields::optional_joint_point(int a, Vec2& p_a, int b, Vec2& p_b, Text meaning) {
  CommonPoint point(a, p_a, b, p_b);
  visit_compound({"at", meaning}, point);
}

void Fields::end_points(int a, Vec2& p_a, int b, Vec2& p_b, Text meaning) {
  EndPoints points(a, p_a, b, p_b);
  visit_compound({"ends", meaning, true, "m"}, points);
}

void Fields::point(const char* key, int index, Vec2& p, Text meaning) {
  OnePoint point(index, p);
  visit_compound({key, meaning}, point);
}

void Fields::axis(const char* key, int a, double& angle_a, Text meaning) {
  Axis axis(a, angle_a);
  visit_compound({key, meaning, true}, axis);
}

}  // namespace subsoil::sim
