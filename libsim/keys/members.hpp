#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

/// Members of structs that hold structs, behind one interface each, so that a visitor need not know their types.
namespace subsoil::sim {

class Fields;
using Declare = std::function<void(Fields&)>;

/// A type declares itself by a member (elements and laws of the libraries) or by a function (sections of the scenario).
template <class V, class T>
void declare(V& v, T& t) {
  if constexpr (requires { t.describe(v); }) {
    t.describe(v);
  } else {
    describe(v, t);
  }
}

/// Calls use(std::type_identity<T>) for every alternative of a variant or element of a tuple.
template <class List>
struct ForEach;
template <template <class...> class List, class... T>
struct ForEach<List<T...>> {
  static constexpr std::size_t count = sizeof...(T);
  template <class Use>
  static void call(Use use) {
    (use(std::type_identity<T>{}), ...);
  }
};

/// Word and meaning on a type's card.
struct Card {
  std::string word, meaning;
};
/// The card that a declaration shows.
Card card_shown_by(const Declare& declare_type);

template <class T>
const Card& card_of() {
  static const Card card = card_shown_by([](Fields& fields) {
    T prototype{};
    declare(fields, prototype);
  });
  return card;
}

/// A mapping.
struct SectionMember {
  enum class When {
    always,  ///< its required keys are required whether it stands there or not
    given,   ///< only when it stands there
    needed   ///< it must stand there
  };
  When when = When::always;
  bool there = true;
  bool flow = false;  ///< printed on one line
  Declare declare;    ///< the member, made where it is not there yet
  Declare prototype;
};

/// A list of mappings.
class ListMember {
 public:
  virtual ~ListMember() = default;
  virtual std::size_t size() const = 0;
  virtual void append() = 0;
  virtual void declare_item(std::size_t index, Fields& fields) = 0;
  virtual void declare_prototype(Fields& fields) = 0;
};

/// A mapping of name -> mapping.
class NamedMember : public ListMember {
 public:
  virtual const std::string& name(std::size_t index) const = 0;
  virtual void set_name(std::size_t index, const std::string& name) = 0;
};

template <class T>
class ListOf final : public NamedMember {
 public:
  explicit ListOf(std::vector<T>& values) : values_(values) {}
  std::size_t size() const override { return values_.size(); }
  void append() override { values_.emplace_back(); }
  void declare_item(std::size_t index, Fields& fields) override { declare(fields, values_[index]); }
  void declare_prototype(Fields& fields) override {
    T prototype{};
    declare(fields, prototype);
  }
  const std::string& name([[maybe_unused]] std::size_t index) const override {
    if constexpr (requires(T & t) { t.name = std::string{}; }) {
      return values_[index].name;
    } else {
      static const std::string none;
      return none;
    }
  }
  void set_name([[maybe_unused]] std::size_t index, [[maybe_unused]] const std::string& name) override {
    if constexpr (requires(T & t) { t.name = name; }) values_[index].name = name;
  }

 private:
  std::vector<T>& values_;
};

/// A type whose single key's value may stand in place of the whole mapping: `radius: 10 mm` for {equal: 10 mm}.
template <class T>
concept StandsAlone = requires {
  requires T::stands_alone;
};

/// What a type declares about itself beyond the ranges of its keys. A member of one of these names that does not fit in
/// type does not compile.
template <class T>
concept HasCheck = requires(const T& t) {
  { t.check() } -> std::same_as<void>;
};
template <class T>
concept HasResolved = requires(const T& t) {
  t.resolved();
};
/// A law or model that can take what it lacks from the materials.
template <class T>
concept MentionsYield = requires(T& t) {
  t.needs_yield();
}
|| requires { &T::take_yield; }
|| requires { T::in_place_of_yield; };
template <class T>
concept TakesYield = requires(T& t, const T& law) {
  { law.needs_yield() } -> std::same_as<bool>;
  t.take_yield(1., 1.);
  { T::in_place_of_yield } -> std::convertible_to<const char*>;
};
template <class T>
concept MentionsDensity = requires(T& t) {
  t.needs_density();
}
|| requires { &T::take_density; };
template <class T>
concept TakesDensity = requires(T& t, const T& law) {
  { law.needs_density() } -> std::same_as<bool>;
  t.take_density(1., 1.);
};
template <class T>
concept MentionsMaterials = requires(T& t) {
  t.needs_materials();
}
|| requires { &T::take_materials; }
|| requires { T::in_place_of_materials; };
template <class T>
concept TakesMaterials = requires(T& t, const T& law) {
  { law.needs_materials() } -> std::same_as<bool>;
  t.take_materials(1., 1., 1., 1.);
  { T::in_place_of_materials } -> std::convertible_to<const char*>;
};

/// Throws std::invalid_argument; what it lacks and the materials may have is no fault.
template <class T>
void check_itself(const T& held) {
  static_assert(!MentionsYield<T> || TakesYield<T>, "needs_yield, take_yield and in_place_of_yield go together");
  static_assert(!MentionsDensity<T> || TakesDensity<T>, "needs_density and take_density go together");
  static_assert(!MentionsMaterials<T> || TakesMaterials<T>,
                "needs_materials, take_materials and in_place_of_materials go together");
  if constexpr (TakesYield<T>)
    if (held.needs_yield()) return;
  if constexpr (TakesDensity<T>)
    if (held.needs_density()) return;
  if constexpr (HasResolved<T>) static_cast<void>(held.resolved());
  if constexpr (HasCheck<T>) held.check();
}

/// One of several types, chosen by a word.
class VariantMember {
 public:
  virtual ~VariantMember() = default;
  virtual std::size_t count() const = 0;
  virtual const Card& card(std::size_t type) const = 0;
  virtual std::size_t held() const = 0;
  virtual void hold(std::size_t type) = 0;  ///< a new one of the type
  virtual void declare_held(Fields& fields) = 0;
  virtual void declare_prototype(std::size_t type, Fields& fields) = 0;
  virtual void check_held() const = 0;                   ///< throws std::invalid_argument
  virtual std::optional<std::size_t> alone() const = 0;  ///< the type whose value may stand by itself
};

/// The types that something may hold, as the arguments of a template. Specialised beside what holds one of them without
/// being a variant.
template <class Holder>
struct TypesOf;
template <class... T>
struct TypesOf<std::variant<T...>> {
  using type = std::variant<T...>;
};

/// The T that is held, or null.
template <class T, class Holder>
auto* held_as(Holder& holder) {
  if constexpr (requires { holder.template get_if<T>(); }) {
    return holder.template get_if<T>();
  } else {
    return std::get_if<T>(&holder);
  }
}

/// Of a variant, or of anything with get_if<T>() that takes a T.
template <class Holder>
class OneOf final : public VariantMember {
  using Types = ForEach<typename TypesOf<Holder>::type>;
  template <class Use>
  static void with(std::size_t type, Use use) {
    std::size_t i = 0;
    Types::call([&]<class T>(std::type_identity<T> t) {
      if (i++ == type) use(t);
    });
  }

 public:
  explicit OneOf(Holder& value) : value_(value) {}
  std::size_t count() const override { return Types::count; }
  const Card& card(std::size_t type) const override {
    const Card* found = nullptr;
    with(type, [&]<class T>(std::type_identity<T>) { found = &card_of<T>(); });
    return *found;
  }
  std::size_t held() const override {
    std::size_t i = 0, found = count();
    Types::call([&]<class T>(std::type_identity<T>) {
      if (held_as<T>(value_) != nullptr) found = i;
      ++i;
    });
    return found;
  }
  void hold(std::size_t type) override {
    with(type, [&]<class T>(std::type_identity<T>) { value_ = T{}; });
  }
  void declare_held(Fields& fields) override {
    Types::call([&]<class T>(std::type_identity<T>) {
      if (T* held = held_as<T>(value_)) declare(fields, *held);
    });
  }
  void declare_prototype(std::size_t type, Fields& fields) override {
    with(type, [&]<class T>(std::type_identity<T>) {
      T prototype{};
      declare(fields, prototype);
    });
  }
  void check_held() const override {
    Types::call([&]<class T>(std::type_identity<T>) {
      if (const T* held = held_as<T>(value_)) check_itself(*held);
    });
  }
  std::optional<std::size_t> alone() const override {
    std::optional<std::size_t> found;
    std::size_t i = 0;
    Types::call([&]<class T>(std::type_identity<T>) {
      if (StandsAlone<T>) found = i;
      ++i;
    });
    return found;
  }

 private:
  Holder& value_;
};

/// A mapping of name -> one of several types, each a struct with `name` and a variant `element`.
class ElementsMember {
 public:
  virtual ~ElementsMember() = default;
  virtual std::size_t size() const = 0;
  virtual const std::string& name(std::size_t index) const = 0;
  /// Use gets the variant of an item; one that is appended is kept when use returns true.
  virtual void use_item(std::size_t index, const std::function<void(VariantMember&)>& use) = 0;
  virtual void append(const std::string& name, const std::function<bool(VariantMember&)>& use) = 0;
  virtual void use_prototype(const std::function<void(VariantMember&)>& use) = 0;
};

template <class T>
class ElementsOf final : public ElementsMember {
 public:
  explicit ElementsOf(std::vector<T>& values) : values_(values) {}
  std::size_t size() const override { return values_.size(); }
  const std::string& name(std::size_t index) const override { return values_[index].name; }
  void use_item(std::size_t index, const std::function<void(VariantMember&)>& use) override {
    OneOf element(values_[index].element);
    use(element);
  }
  void append(const std::string& name, const std::function<bool(VariantMember&)>& use) override {
    T value{};
    value.name = name;
    OneOf element(value.element);
    if (use(element)) values_.push_back(std::move(value));
  }
  void use_prototype(const std::function<void(VariantMember&)>& use) override {
    T value{};
    OneOf element(value.element);
    use(element);
  }

 private:
  std::vector<T>& values_;
};

}  // namespace subsoil::sim
