#pragma once
#include <cmath>
#include <concepts>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "apps/scenario/declarations.hpp"
#include "apps/scenario/document.hpp"
#include "apps/scenario/printer.hpp"
#include "apps/scenario/units.hpp"
#include "libmbd/body.hpp"

/// The visitor of the declarations that fills structs from a document. Every fault goes to the list of problems with
/// its place; reading goes on, so that one run names them all.
namespace subsoil::app {

/// What a reading shares: faults, the place of every path read, the bodies and markers met so far.
struct Reading {
  Problems& problems;
  std::map<std::string, Place> places;
  std::vector<std::string> body_names;     // [0] is ground
  std::vector<mbd::BodyState> body_poses;  // start pose
  std::vector<mbd::Marker> markers;
  std::vector<Material> materials{};
};

class Reader {
 public:
  Reader(Reading& reading, const Node& node, std::string path)
      : reading_(reading), node_(node), path_(std::move(path)) {}

  /// Refuses keys that no declaration has asked for. Call once, at the end.
  void finish();

  // -- values --
  void card(const char*, const char*) {}
  void quantity(const char* key, double& value, const std::string& unit, const char* range, const char* meaning);
  void quantity(const char* key, std::optional<double>& value, const std::string& unit, const char* range,
                const char* meaning);
  void optional_quantity(const char* key, double& value, const std::string& unit, const char* range,
                         const char* meaning);
  void derived(const char* key, double& value, const std::string& unit, const char* range, const char* meaning) {
    optional_quantity(key, value, unit, range, meaning);
  }
  void quantity_or(const char* key, std::optional<double>& value, const char* word, const char* unit, const char* range,
                   const char* meaning);
  void quantities(const char* key, std::vector<double>& values, const char* unit, const char* range,
                  const char* meaning);
  void span(const char* key, double& least, double& largest, const char* unit, const char* range, const char* meaning);
  template <class Vector>
  void vector(const char* key, Vector& value, const char* unit, const char* meaning) {
    constexpr std::size_t size = std::is_same_v<Vector, Vec3> ? 3 : sizeof(Vector) / sizeof(double);
    leaf(key, std::isnan(value[0]), with_unit(meaning, unit), [&](const Node& node) {
      const std::vector<double> numbers = numbers_of(node, unit, size);
      for (std::size_t i = 0; i < size; ++i) at(value, i) = numbers[i];
    });
  }
  template <class Vector>
  void vector(const char* key, std::optional<Vector>& value, const char* unit, const char* meaning) {
    Vector read{};
    vector(key, read, unit, meaning);
    if (node_.find(key) != nullptr) value = read;
  }
  void downward(const char* key, Vec3& value, const char* unit, const char* meaning);
  template <class Int>
  requires std::integral<Int>
  void count(const char* key, Int& value, const char* range, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) { value = static_cast<Int>(whole_number(node, range)); });
  }
  void count(const char* key, std::optional<long>& value, const char* range, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) { value = whole_number(node, range); });
  }
  void version(const char* key, long& value, const char* meaning);
  void flag(const char* key, bool& value, const char* meaning);
  void text(const char* key, std::string& value, const char* meaning);
  void name(const char* key, std::string& value, const char* meaning);
  template <class E>
  void choice(const char* key, E& value, std::initializer_list<std::pair<const char*, std::type_identity_t<E>>> words,
              const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) { value = choose<E>(node, words); });
  }
  template <class E>
  void words(const char* key, std::vector<E>& values,
             std::initializer_list<std::pair<const char*, std::type_identity_t<E>>> words, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) {
      values.clear();
      for (const Node* item : items_of(node)) values.push_back(choose<E>(*item, words));
    });
  }
  void faces(const char* key, Faces& faces, const char* meaning);
  void file(const char* key, std::string& value, const char* meaning) { input_file(key, value, true, meaning); }
  void optional_file(const char* key, std::string& value, const char* meaning) {
    input_file(key, value, false, meaning);
  }
  void output_file(const char* key, std::string& value, const char* meaning);
  void unit(const char* key, double& size, const char* expected, const char* meaning);
  void outline(const char* key, std::vector<Vec2>& points, const char* meaning) {
    read_outline(key, points, true, meaning);
  }
  void optional_outline(const char* key, std::vector<Vec2>& points, const char* meaning) {
    read_outline(key, points, false, meaning);
  }
  void table(const char* key, std::vector<double>& xs, std::vector<double>& ys, const std::string& x_unit,
             const std::string& y_unit, const char* meaning);
  void function(const char* key, Function& value, const std::string& unit, const char* meaning) {
    read_function(key, value, unit, !value.is_set(), meaning);
  }
  void optional_function(const char* key, Function& value, const std::string& unit, const char* meaning) {
    read_function(key, value, unit, false, meaning);
  }
  void optional_characteristic(const char* key, mbd::Characteristic& value, const std::string& x_unit,
                               const std::string& unit, const char* meaning);
  void formula(const char* key, std::string& text, std::function<double(double, double, double)>& call,
               const char* meaning);
  void expression(const char* key, mbd::ExpressionFunction& value, const std::string& unit, const char* meaning);

  // -- names of other things; whether they exist is checked when everything is read --
  void reference(const char* key, std::string& value, Family, const char* meaning) {
    leaf(key, true, meaning, [&](const Node& node) { value = scalar_of(node); });
  }
  void optional_reference(const char* key, std::string& value, Family, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) { value = scalar_of(node); });
  }
  void joint(const char* key, std::string& value, const char* meaning) {
    reference(key, value, Family::joint, meaning);
  }
  void force(const char* key, std::string& value, const char* meaning) {
    reference(key, value, Family::force, meaning);
  }
  void pair(const char* key, std::array<std::string, 2>& value, Family, const char* meaning);
  void combinations(const char* key, const std::array<std::string, 2>& between, std::vector<Combination>& combine,
                    const char* meaning);

  // -- bodies, and points given in the world of the start pose or in body axes --
  void body(const char* key, int& index, const char* meaning);
  void optional_body(const char* key, int& index, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) { index = body_of(node); });
  }
  void bodies(const char* key, int& a, int& b, const char* meaning);
  void coordinate(const char* key, int& index, mbd::Coordinate& coordinate, const char* meaning);
  void joint_point(int a, Vec2& p_a, int b, Vec2& p_b, const char* meaning);
  void optional_joint_point(int a, Vec2& p_a, int b, Vec2& p_b, const char* meaning);
  void end_points(int a, Vec2& p_a, int b, Vec2& p_b, const char* meaning);
  void point(const char* key, int index, Vec2& p, const char* meaning);
  void axis(const char* key, int a, double& angle_a, const char* meaning);

  void marker(const char* key, mbd::Marker& value, const char* meaning) {
    leaf(key, true, meaning, [&](const Node& node) { value = marker_of(node); });
  }
  void optional_marker(const char* key, mbd::Marker& value, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) { value = marker_of(node); });
  }
  template <std::size_t count>
  void markers(const char* key, std::array<mbd::Marker, count>& values, const char* meaning) {
    leaf(key, true, meaning, [&](const Node& node) { take_markers(node, values); });
  }

  // -- structure --
  template <class T>
  void section(const char* key, T& value, const char* meaning) {
    known_.push_back(key);
    const Node::Entry* entry = node_.find(key);
    if (entry == nullptr) {  // its required keys are then missing by their full path
      Node nothing = Node::mapping();
      nothing.place = node_.place;
      read_mapping(nothing, child(key), value);
    } else {
      leaf(key, true, meaning, [&](const Node& node) { read_mapping(node, child(key), value); });
    }
  }
  template <class T>
  void section(const char* key, std::optional<T>& value, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) { read_mapping(node, child(key), value.emplace()); });
  }
  template <class Declare>
  void group(const char* key, const char* meaning, Declare declare_group) {
    leaf(key, true, meaning, [&](const Node& node) {
      Reader reader(reading_, mapping_of(node), child(key));
      declare_group(reader);
      reader.finish();
    });
  }
  template <class T>
  void list(const char* key, std::vector<T>& values, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) {
      if (node.kind != Node::Kind::sequence) throw UnitError("must be a list: lines that start with `- `");
      for (std::size_t i = 0; i < node.items.size(); ++i) {
        read_mapping(node.items[i], child(key) + "[" + std::to_string(i) + "]", values.emplace_back());
      }
    });
  }
  template <class T>
  void named(const char* key, std::vector<T>& values, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) {
      for (const Node::Entry& e : mapping_of(node).entries) {
        T& value = values.emplace_back();
        value.name = e.key;
        check_name(e, child(key));
        read_mapping(e.value, child(key) + "." + e.key, value);
        if constexpr (std::is_same_v<T, Body> || std::is_same_v<T, mbd::Marker> || std::is_same_v<T, Material>)
          remember(value);
      }
    });
  }
  template <class T>
  void elements(const char* key, std::vector<T>& values, const char* meaning) {
    leaf(key, false, meaning, [&](const Node& node) {
      for (const Node::Entry& e : mapping_of(node).entries) {
        T value;
        value.name = e.key;
        check_name(e, child(key));
        const std::string path = child(key) + "." + e.key;
        reading_.places[path] = e.value.place;
        if (read_form(e.value, path, value.element)) values.push_back(std::move(value));
      }
    });
  }
  void kind(const char* key, GivenLaw& value, const char* meaning);  // given_law.cpp
  template <class Variant>
  void kind(const char* key, Variant& value, const char* meaning) {
    open_ = node_.find(key) == nullptr;
    leaf(key, true, meaning, [&](const Node& node) {
      const std::string word = scalar_of(node);
      bool found = false;
      ForEach<Variant>::call([&]<class T>(std::type_identity<T>) {
        if (card_of<T>().word != word) return;
        found = true;
        value = read_checked<T>(*this);
      });
      if (!found) {
        open_ = true;  // whose parameters the other keys are cannot be told
        throw UnitError("unknown " + std::string(key) + suggestion(word, words_of<Variant>()));
      }
    });
  }
  template <class Variant>
  void form(const char* key, Variant& value, const char* meaning) {
    take_form(key, value, true, meaning);
  }
  template <class Variant>
  void optional_form(const char* key, Variant& value, const char* meaning) {
    take_form(key, value, false, meaning);
  }
  template <class Variant>
  void take_form(const char* key, Variant& value, bool needed, const char* meaning) {
    leaf(key, needed, meaning, [&](const Node& node) {
      if constexpr (std::is_same_v<Variant, RadiusDistribution>) {
        if (node.kind == Node::Kind::scalar) {
          value = EqualRadius{numbers_of(node, "m", 1).front()};
          check_range(std::get<EqualRadius>(value).radius, "(0, inf)", "m");
          return;
        }
      }
      read_form(node, child(key), value);
    });
  }
  /// A variant whose word stands among the other keys of this mapping.
  template <class Variant>
  void inline_form(Variant& value) {
    with_type<Variant>(node_, path_, [&]<class T>(std::type_identity<T>) { value = read_checked<T>(*this); });
  }
  void turns(const char* key, Rotation& rotation, const char* meaning);
  void start(const char* key, Start& start, const char* meaning);
  void watches(const char* key, std::vector<Watch>& watches, const char* meaning);

 private:
  template <class Vector>
  static double& at(Vector& value, std::size_t i) {
    if constexpr (std::is_same_v<Vector, Vec3>) {
      return value[static_cast<int>(i)];
    } else {
      return value[i];
    }
  }
  std::string child(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  static std::string with_unit(const std::string& meaning, const std::string& unit);
  void fault(const Node& node, const std::string& path, const std::string& rule);

  /// Finds a key and lets `use` take its value; turns what it throws into a problem at the value's place.
  template <class Use>
  void leaf(const char* key, bool needed, const std::string& meaning, Use use) {
    known_.push_back(key);
    const Node::Entry* entry = node_.find(key);
    if (entry == nullptr) {
      if (needed) missing(key, meaning);
      return;
    }
    reading_.places[child(key)] = entry->value.place;
    if (entry->value.kind == Node::Kind::null) {
      reading_.problems.add(entry->place, child(key), "has no value; give one, or leave the key out");
      return;
    }
    try {
      use(entry->value);
    } catch (const std::invalid_argument& e) {
      fault(entry->value, child(key), e.what());
    }
  }
  void missing(const std::string& key, const std::string& meaning);
  std::string cure_for(const std::string& key) const;

  template <class T>
  void read_mapping(const Node& node, const std::string& path, T& value) {
    reading_.places[path] = node.place;
    if (node.kind != Node::Kind::mapping) {
      fault(node, path, "must be a mapping: `key: value` lines, or {key: value, ...}");
      return;
    }
    Reader reader(reading_, node, path);
    declare(reader, value);
    reader.finish();
  }

  /// Reads a T from `reader`'s mapping and lets the type check itself, once nothing else is wrong with it.
  template <class T>
  T read_checked(Reader& reader) {
    T value{};
    const std::size_t before = reading_.problems.count();
    declare(reader, value);
    if (reading_.problems.count() != before) return value;
    if constexpr (requires { value.needs_yield(); })
      if (value.needs_yield()) return value;  // the materials have it, if anybody
    try {
      if constexpr (requires { value.resolved(); }) static_cast<void>(value.resolved());
      if constexpr (requires { value.check(); }) value.check();
    } catch (const std::invalid_argument& e) {
      reading_.problems.add(reader.node_.place, reader.path_, e.what());
    }
    return value;
  }

  /// Finds the one alternative whose word is a key of `node`; says what is wrong otherwise.
  template <class Variant, class Use>
  bool with_type(const Node& node, const std::string& path, Use use) {
    int found = 0;
    ForEach<Variant>::call([&]<class T>(std::type_identity<T>) {
      if (node.find(card_of<T>().word) != nullptr) ++found;
    });
    if (found != 1) {
      no_type(node, path, found, words_of<Variant>());
      open_ = true;
      return false;
    }
    ForEach<Variant>::call([&]<class T>(std::type_identity<T> type) {
      if (node.find(card_of<T>().word) != nullptr) use(type);
    });
    return true;
  }
  template <class Variant>
  bool read_form(const Node& node, const std::string& path, Variant& value) {
    if (node.kind != Node::Kind::mapping) {
      fault(node, path, "must be a mapping: `key: value` lines, or {key: value, ...}");
      return false;
    }
    Reader reader(reading_, node, path);
    const bool known = reader.with_type<Variant>(
        node, path, [&]<class T>(std::type_identity<T>) { value = reader.read_checked<T>(reader); });
    reader.finish();
    return known;
  }
  void no_type(const Node& node, const std::string& path, int found, const std::vector<std::string>& words);

  template <class E>
  E choose(const Node& node, const std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>& words) {
    const std::string word = scalar_of(node);
    std::vector<std::string> known;
    for (const auto& [text, value] : words) {
      if (word == text) return value;
      known.emplace_back(text);
    }
    throw UnitError("unknown word" + suggestion(word, known));
  }

  static const std::string& scalar_of(const Node& node);
  static const Node& mapping_of(const Node& node);
  static std::vector<const Node*> items_of(const Node& node);
  std::vector<double> numbers_of(const Node& node, const std::string& unit, std::size_t count) const;
  static long whole_number(const Node& node, const char* range);
  static void check_range(double value, const std::string& range, const std::string& unit,
                          const std::string& meaning = {});
  void check_name(const Node::Entry& entry, const std::string& path);
  void read_outline(const char* key, std::vector<Vec2>& points, bool needed, const char* meaning);
  void input_file(const char* key, std::string& value, bool needed, const char* meaning);
  void read_function(const char* key, Function& value, const std::string& unit, bool needed, const char* meaning);
  Function function_of(const Node& node, const std::string& path, const std::string& unit);
  /// A law (function of time, characteristic) from `{word: {parameters}}` or `{table: [[...]]}`, one kind of `Kinds`.
  template <class Law, class Kinds, class... Units>
  Law law_of(const Node& node, const std::string& path, const Units&... units);
  void remember(const Body& body);
  void remember(const mbd::Marker& marker) { reading_.markers.push_back(marker); }
  void remember(const Material& material) { reading_.materials.push_back(material); }
  double combine(const Combinable& what, CombinationRule rule, const std::array<std::string, 2>& between) const;
  mbd::Marker marker_of(const Node& node) const;
  void take_markers(const Node& node, std::span<mbd::Marker> values) const;
  int body_of(const Node& node) const;
  const mbd::BodyState* pose_of(int index) const;
  std::vector<Vec2> two_points(const Node& node);

  Reading& reading_;
  const Node& node_;
  std::string path_;
  std::vector<std::string> known_;
  std::map<std::string, double> combined_;  // quantities that rules supply, for those that this mapping leaves out
  std::optional<double> n_;                 // the quantity `n` of this mapping, for powers such as (n+1)
  bool n_missing_ = false;
  bool open_ = false;  // the type is unknown, so unknown keys are not reported
};

}  // namespace subsoil::app
