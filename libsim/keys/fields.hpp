#pragma once
#include <array>
#include <cmath>
#include <concepts>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "libdem/base/vec3.hpp"
#include "libsim/keys/field.hpp"
#include "libsim/keys/members.hpp"

namespace subsoil::mbd {
struct Marker;
class Function;
class Characteristic;
struct ExpressionFunction;
enum class Coordinate;
}  // namespace subsoil::mbd

/// Every key of a scenario, once: name, unit, range, meaning, and by the struct's own value the default. The reader,
/// the printer of the explicit copy, `explain`, `new` and docs/reference/keys.md are visitors of these declarations.
/// Laws, joints, drivers and forces declare themselves in their own files in the same vocabulary, without knowing this
/// class.
///
/// A visitor implements the ten functions `visit_*`; the words of the vocabulary are made of them. `quantity` (NaN:
/// required; optional<>: may be left out), `vector`, `count`, `flag`, `text`, `choice`, `section` (a mapping), `list`
/// (of mappings), `named` (mapping of name -> mapping), `elements` (of name -> one of several types), `kind` (a variant
/// chosen by the word under the key), `form` (a variant chosen by which word is present), `reference` (a name declared
/// elsewhere); `optional_*`: may be left out. The last argument of some is the cure of a value out of range.
namespace subsoil::sim {

using dem::Vec3;
using Vec2 = std::array<double, 2>;

enum class Family { material, body, joint, driver, force };

class Fields {
 public:
  virtual ~Fields() = default;

  // ---- what a visitor does -----------------------------------------------------------------------------------------
  virtual void card(const char* word, const char* meaning) = 0;
  virtual void visit_value(const Field& field, Value& value) = 0;
  virtual void visit_compound(const Field& field, Compound& compound) = 0;
  virtual void visit_section(const Field& field, SectionMember& section) = 0;
  virtual void visit_list(const Field& field, ListMember& list) = 0;
  virtual void visit_named(const Field& field, NamedMember& named) = 0;
  virtual void visit_elements(const Field& field, ElementsMember& elements) = 0;
  virtual void visit_kind(const Field& field, VariantMember& variant) = 0;
  virtual void visit_form(const Field& field, VariantMember& variant) = 0;
  virtual void visit_inline_form(VariantMember& variant) = 0;

  // ---- numbers -----------------------------------------------------------------------------------------------------
  using Text = const std::string&;
  void quantity(const char* key, double& value, Text unit, const Range& range, Text meaning, const char* cure = "");
  void quantity(const char* key, std::optional<double>& value, Text unit, const Range& range, Text meaning,
                const char* cure = "");
  /// NaN: left out.
  void optional_quantity(const char* key, double& value, Text unit, const Range& range, Text meaning,
                         const char* cure = "");
  /// Left out: it follows from others.
  void derived(const char* key, double& value, Text unit, const Range& range, Text meaning, const char* cure = "") {
    optional_quantity(key, value, unit, range, meaning, cure);
  }
  /// A number that units of the same mapping hold as n: N/m^(n+1).
  void exponent(const char* key, double& value, const Range& range, Text meaning);
  /// A number, or `word` where it is empty.
  void quantity_or(const char* key, std::optional<double>& value, const char* word, Text unit, const Range& range,
                   Text meaning);
  void quantities(const char* key, std::vector<double>& values, Text unit, const Range& range, Text meaning);
  void span(const char* key, double& least, double& largest, Text unit, const Range& range, Text meaning);
  template <class Vector>
  void vector(const char* key, Vector& value, Text unit, Text meaning) {
    numbers(key, components(value), unit, meaning, std::isnan(value[0]), false,
            [&value](const double* x) { assign(value, x); });
  }
  template <class Vector>
  void vector(const char* key, std::optional<Vector>& value, Text unit, Text meaning) {
    Numbers none{.size = components(Vector{}).size, .values = {}};
    numbers(key, value ? components(*value) : none, unit, meaning, false, true,
            [&value](const double* x) { assign(value.emplace(), x); });
  }
  /// One number acts downward (-y); or a vector.
  void downward(const char* key, Vec3& value, Text unit, Text meaning);
  template <class Int>
  requires std::integral<Int>
  void count(const char* key, Int& value, const Range& range, Text meaning) {
    whole({key, meaning}, static_cast<long>(value), range, [&value](long n) { value = static_cast<Int>(n); });
  }
  void count(const char* key, std::optional<long>& value, const Range& range, Text meaning) {
    whole({key, meaning}, value, range, [&value](long n) { value = n; });
  }
  void version(const char* key, long& value, Text meaning);
  /// Metres (or so) per unit: `unit: mm`.
  void unit(const char* key, double& size, Text expected, Text meaning);
  /// Pairs of numbers.
  void table(const char* key, std::vector<double>& xs, std::vector<double>& ys, Text x_unit, Text y_unit, Text meaning);
  void outline(const char* key, std::vector<Vec2>& points, Text meaning);
  /// Two points at least.
  void points(const char* key, std::vector<Vec2>& points, Text meaning);
  void optional_outline(const char* key, std::vector<Vec2>& points, Text meaning);

  // ---- words -------------------------------------------------------------------------------------------------------
  void flag(const char* key, bool& value, Text meaning);
  void text(const char* key, std::string& value, Text meaning);
  /// An amount in the unit of a column that is known later; parameters, which are known here alone, become numbers.
  void level(const char* key, std::string& value, Text meaning);
  /// Text, or a list that whoever reads the file joins before.
  void joined_text(const char* key, std::string& value, Text meaning);
  /// Becomes a column or a group of a file.
  void name(const char* key, std::string& value, Text meaning);
  template <class E>
  using Words = std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>;
  template <class E>
  void choice(const char* key, E& value, Words<E> words, Text meaning) {
    std::vector<E> values{value};
    chosen(key, texts<E>(words), indices<E>(values, words), meaning, false,
           [&value, all = all<E>(words)](const std::vector<std::size_t>& at) { value = all[at.front()]; });
  }
  template <class E>
  void words(const char* key, std::vector<E>& values, Words<E> words, Text meaning) {
    chosen(key, texts<E>(words), indices<E>(values, words), meaning, true,
           [&values, all = all<E>(words)](const std::vector<std::size_t>& at) {
             values.clear();
             for (const std::size_t i : at) values.push_back(all[i]);
           });
  }
  void file(const char* key, std::string& value, Text meaning);
  void optional_file(const char* key, std::string& value, Text meaning);
  void output_file(const char* key, std::string& value, Text meaning);

  // ---- names of other things; whether they exist is checked when everything is read
  // -------------------------------------
  void reference(const char* key, std::string& value, Family family, Text meaning);
  void optional_reference(const char* key, std::string& value, Family family, Text meaning);
  void joint(const char* key, std::string& value, Text meaning) { reference(key, value, Family::joint, meaning); }
  void force(const char* key, std::string& value, Text meaning) { reference(key, value, Family::force, meaning); }
  void pair(const char* key, std::array<std::string, 2>& value, Family family, Text meaning);

  // ---- functions and formulas
  // ----------------------------------------------------------------------------------------
  void function(const char* key, mbd::Function& value, Text unit, Text meaning);
  void optional_function(const char* key, mbd::Function& value, Text unit, Text meaning);
  void optional_characteristic(const char* key, mbd::Characteristic& value, Text x_unit, Text unit, Text meaning);
  void expression(const char* key, mbd::ExpressionFunction& value, Text unit, Text meaning);
  void formula(const char* key, std::string& text, std::function<double(double, double, double)>& call, Text meaning);

  // ---- bodies, and points given in the world of the start pose or in body axes
  // ---------------------------------------
  void body(const char* key, int& index, Text meaning);
  void optional_body(const char* key, int& index, Text meaning);
  void bodies(const char* key, int& a, int& b, Text meaning);
  void coordinate(const char* key, int& index, mbd::Coordinate& coordinate, Text meaning);
  void joint_point(int a, Vec2& p_a, int b, Vec2& p_b, Text meaning);
  void optional_joint_point(int a, Vec2& p_a, int b, Vec2& p_b, Text meaning);
  void end_points(int a, Vec2& p_a, int b, Vec2& p_b, Text meaning);
  void point(const char* key, int index, Vec2& p, Text meaning);
  void axis(const char* key, int a, double& angle_a, Text meaning);
  void marker(const char* key, mbd::Marker& value, Text meaning);
  void optional_marker(const char* key, mbd::Marker& value, Text meaning);
  template <std::size_t size>
  void markers(const char* key, std::array<mbd::Marker, size>& values, Text meaning) {
    take_markers(key, values, meaning);
  }

  // ---- structure ---------------------------------------------------------------------------------------------------
  template <class T>
  void section(const char* key, T& value, Text meaning) {
    const Declare declare_it = [&value](Fields& f) { declare(f, value); };
    SectionMember member{.when = SectionMember::When::always, .declare = declare_it, .prototype = declare_it};
    visit_section({key, meaning}, member);
  }
  template <class T>
  void section(const char* key, std::optional<T>& value, Text meaning) {
    SectionMember member{.when = SectionMember::When::given,
                         .there = value.has_value(),
                         .declare =
                             [&value](Fields& f) {
                               if (!value) value.emplace();
                               declare(f, *value);
                             },
                         .prototype =
                             [](Fields& f) {
                               T prototype{};
                               declare(f, prototype);
                             }};
    visit_section({key, meaning}, member);
  }
  template <class DeclareGroup>
  void group(const char* key, Text meaning, DeclareGroup declare_group) {
    const Declare declare_it = [&](Fields& f) { declare_group(f); };
    SectionMember member{
        .when = SectionMember::When::needed, .flow = true, .declare = declare_it, .prototype = declare_it};
    visit_section({key, meaning, true}, member);
  }
  template <class T>
  void list(const char* key, std::vector<T>& values, Text meaning) {
    ListOf list(values);
    visit_list({key, meaning}, list);
  }
  template <class T>
  void named(const char* key, std::vector<T>& values, Text meaning) {
    static_assert(
        requires(T & t) { t.name = std::string{}; }, "what is named keeps its name as a string");
    ListOf list(values);
    visit_named({key, meaning}, list);
  }
  template <class T>
  void elements(const char* key, std::vector<T>& values, Text meaning) {
    ElementsOf elements(values);
    visit_elements({key, meaning}, elements);
  }
  template <class Variant>
  void kind(const char* key, Variant& value, Text meaning) {
    OneOf one(value);
    visit_kind({key, meaning, true}, one);
  }
  template <class Variant>
  void form(const char* key, Variant& value, Text meaning) {
    OneOf one(value);
    visit_form({key, meaning, true}, one);
  }
  template <class Variant>
  void optional_form(const char* key, Variant& value, Text meaning) {
    OneOf one(value);
    visit_form({key, meaning}, one);
  }
  /// A variant whose word stands among the other keys of this mapping.
  template <class Variant>
  void inline_form(Variant& value) {
    OneOf one(value);
    visit_inline_form(one);
  }

 private:
  struct Numbers {
    std::size_t size = 0;
    std::vector<double> values;  // empty: none
  };
  template <class Vector>
  static Numbers components(const Vector& value) {
    Numbers n;
    n.size = std::is_same_v<Vector, Vec3> ? 3 : sizeof(Vector) / sizeof(double);
    for (std::size_t i = 0; i < n.size; ++i) {
      if constexpr (std::is_same_v<Vector, Vec3>) {
        n.values.push_back(value[static_cast<int>(i)]);
      } else {
        n.values.push_back(value[i]);
      }
    }
    return n;
  }
  template <class Vector>
  static void assign(Vector& value, const double* x) {
    if constexpr (std::is_same_v<Vector, Vec3>) {
      value = {x[0], x[1], x[2]};
    } else {
      for (double& component : value) component = *x++;
    }
  }
  template <class E>
  static std::vector<std::string> texts(Words<E> words) {
    std::vector<std::string> texts;
    for (const auto& word : words) texts.emplace_back(word.first);
    return texts;
  }
  template <class E>
  static std::vector<E> all(Words<E> words) {
    std::vector<E> values;
    for (const auto& word : words) values.push_back(word.second);
    return values;
  }
  template <class E>
  static std::vector<std::size_t> indices(const std::vector<E>& values, Words<E> words) {
    std::vector<std::size_t> at;
    for (const E& value : values)
      for (std::size_t i = 0; i < words.size(); ++i)
        if (words.begin()[i].second == value) at.push_back(i);
    return at;
  }

  void numbers(const char* key, const Numbers& held, Text unit, Text meaning, bool needed, bool zero_when_given,
               std::function<void(const double*)> assign);
  void whole(const Field& field, std::optional<long> held, const Range& range, std::function<void(long)> assign);
  void chosen(const char* key, std::vector<std::string> words, std::vector<std::size_t> held, Text meaning,
              bool several, std::function<void(const std::vector<std::size_t>&)> assign);
  void take_markers(const char* key, std::span<mbd::Marker> values, Text meaning);
};

}  // namespace subsoil::sim
