#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace subsoil {

class Archive;

namespace archive_detail {

/// Number of doubles x, y (, z (, w)) that a point or a quaternion is made of; 0: it is neither.
template <class T>
constexpr int coordinates() {
  if constexpr (requires(T v) { v.w, v.x, v.y, v.z; })
    return 4;
  else if constexpr (requires(T v) { v.x, v.y, v.z; })
    return 3;
  else if constexpr (requires(T v) { v.x, v.y; })
    return 2;
  else
    return 0;
}
template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;
template <class T>
concept Part = requires(T& part, Archive& a) {
  part.archive(a);
};
template <class T>
concept Point = !Number<T> && !Part<T> && coordinates<T>() > 0;
/// A vector of the standard library or of Eigen.
template <class T>
concept List = !Number<T> && requires(T & list) {
  list.resize(list.size());
  list[0];
};

}  // namespace archive_detail

/// Fields of a state by name. A part names its fields once, in `void archive(Archive& a) { a("time", time_); ... }`:
/// the same calls write them and read them back, so neither direction can forget what the other knows.
///
/// A field is a column of numbers or of texts. What is written under one name again is appended, and read back in that
/// order: the fields of a list of records are columns. Numbers are doubles and come back with their bits; whole
/// numbers below 2^53 are exact. Two lists of numbers, as a state file has them, lost to names: a field that is left
/// out or added in one place would shift all that follow it.
class Archive {
 public:
  using Columns = std::map<std::string, std::vector<double>, std::less<>>;
  using Texts = std::map<std::string, std::vector<std::string>, std::less<>>;

  Archive() = default;  ///< to be written
  /// To be read.
  Archive(Columns columns, Texts texts) : reads_(true) {
    for (auto& [name, column] : columns) fields_[name].numbers = std::move(column);
    for (auto& [name, column] : texts) fields_[name].texts = std::move(column);
  }
  /// What has been written, to be read from the start.
  Archive to_read() const {
    Archive out;
    out.fields_ = fields_, out.reads_ = true;
    for (auto& [name, field] : out.fields_) field.taken = field.taken_texts = 0;
    return out;
  }

  bool reads() const { return reads_; }
  bool empty() const { return fields_.empty(); }
  /// use(name, numbers) of each column of numbers, by name.
  template <class Use>
  void each_column(const Use& use) const {
    for (const auto& [name, field] : fields_)
      if (!field.numbers.empty() || field.texts.empty()) use(name, field.numbers);
  }
  Columns columns() const {
    Columns out;
    each_column([&](const std::string& name, const std::vector<double>& numbers) { out[name] = numbers; });
    return out;
  }
  Texts texts() const {
    Texts out;
    for (const auto& [name, field] : fields_)
      if (!field.texts.empty()) out[name] = field.texts;
    return out;
  }
  bool operator==(const Archive& other) const { return fields_ == other.fields_; }

  template <class T>
  Archive& operator()(std::string_view name, T& value) {
    const std::size_t length = path_.size();
    if (length > 0) path_ += '/';
    path_ += name;
    field(value);
    path_.resize(length);
    return *this;
  }
  /// As many numbers as there is room for.
  Archive& operator()(std::string_view name, std::span<double> values) {
    return group(name, [&] { numbers(values); });
  }
  /// Fields that `use()` names, under a name of their own.
  template <class Use>
  Archive& group(std::string_view name, const Use& use) {
    const std::size_t length = path_.size();
    if (length > 0) path_ += '/';
    path_ += name;
    use();
    path_.resize(length);
    return *this;
  }
  /// When read, whether there is a field of this name, or one in a group of it.
  bool has(std::string_view name) const {
    const std::string whole = path_.empty() ? std::string(name) : path_ + "/" + std::string(name), group = whole + "/";
    const auto at = fields_.lower_bound(group);
    return fields_.contains(whole) || (at != fields_.end() && at->first.starts_with(group));
  }
  /// Takes out what has this name, or lies in its group.
  void drop(std::string_view name) {
    std::erase_if(fields_, [&](const auto& field) {
      return field.first.starts_with(name) && (field.first.size() == name.size() || field.first[name.size()] == '/');
    });
  }

  /// After all has been read: nothing may be left.
  void end() const {
    if (!reads_) return;
    for (const auto& [name, field] : fields_)
      if (field.taken != field.numbers.size() || field.taken_texts != field.texts.size()) refuse(name);
  }
  [[noreturn]] static void refuse(std::string_view name) {
    throw std::invalid_argument("what the state keeps of `" + std::string(name) +
                                "` does not belong to this scenario and version");
  }

 private:
  // Numbers of a column, appended or taken.
  template <archive_detail::Number T>
  void numbers(std::span<T> values) {
    Field& field = fields_[path_];
    if (!reads_) {
      for (const T& value : values) field.numbers.push_back(static_cast<double>(value));
      return;
    }
    if (values.size() > field.numbers.size() - field.taken) refuse(path_);
    for (T& value : values) value = held<T>(field.numbers[field.taken++]);
  }
  /// Of a whole number only what its type can hold.
  template <archive_detail::Number T>
  T held(double number) const {
    if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
      using Limits = std::numeric_limits<T>;
      constexpr double end = 2.0 * static_cast<double>(Limits::max() / 2 + 1);  // a power of two
      if (!(number >= static_cast<double>(Limits::lowest()) && number < end)) refuse(path_);
    }
    return static_cast<T>(number);
  }

  template <archive_detail::Number T>
  void field(T& value) {
    numbers(std::span<T>(&value, 1));
  }
  void field(std::string& text) {
    Field& field = fields_[path_];
    if (!reads_) return field.texts.push_back(text);
    if (field.taken_texts == field.texts.size()) refuse(path_);
    text = field.texts[field.taken_texts++];
  }
  template <archive_detail::Point T>
  void field(T& point) {
    static_assert(sizeof(T) == archive_detail::coordinates<T>() * sizeof(double));
    numbers(std::span<double>(reinterpret_cast<double*>(&point), sizeof(T) / sizeof(double)));
  }
  template <archive_detail::Part T>
  void field(T& part) {
    part.archive(*this);
  }
  template <class T, std::size_t N>
  void field(std::array<T, N>& values) {
    for (T& value : values) field(value);
  }
  template <class T>
  void field(std::optional<T>& value) {
    bool given = value.has_value();
    (*this)("given", given);
    if (reads_ && given) value.emplace();
    if (reads_ && !given) value.reset();
    if (given) (*this)("value", *value);
  }
  template <class A, class B>
  void field(std::pair<A, B>& pair) {
    (*this)("first", pair.first)("second", pair.second);
  }
  template <archive_detail::List L>
  void field(L& list) {
    auto size = static_cast<std::size_t>(list.size());
    (*this)("size", size);
    if (reads_ && size > most()) refuse(path_);
    if (reads_) list.resize(static_cast<decltype(list.size())>(size));
    using Item = std::remove_reference_t<decltype(list[0])>;
    if constexpr (archive_detail::Number<Item> && requires { list.data(); }) {
      numbers(std::span<Item>(list.data(), size));
    } else {
      for (auto& item : list) field(item);
    }
  }
  void field(std::vector<bool>&) = delete;

  /// No list can be longer than the longest column: a bound before memory is asked for.
  std::size_t most() const {
    std::size_t longest = 0;
    for (const auto& [name, field] : fields_) longest = std::max({longest, field.numbers.size(), field.texts.size()});
    return longest;
  }

  struct Field {
    std::vector<double> numbers;
    std::vector<std::string> texts;
    std::size_t taken = 0, taken_texts = 0;  ///< what has been read
    bool operator==(const Field& other) const { return numbers == other.numbers && texts == other.texts; }
  };
  std::map<std::string, Field, std::less<>> fields_;
  std::string path_;
  bool reads_ = false;
};

}  // namespace subsoil
