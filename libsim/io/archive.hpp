#pragma once
#include <cstddef>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "libdem/base/vec3.hpp"

namespace subsoil::sim {

/// What a run has added up, as numbers and texts in the order in which its parts hand them over: the same calls write
/// it into a state and read it back, so neither can forget what the other knows. Numbers are doubles and come back with
/// their bits; whole numbers below 2^53 are exact.
class Archive {
 public:
  Archive() = default;  ///< to be written
  /// To be read.
  Archive(std::vector<double> numbers, std::vector<std::string> texts)
      : numbers_(std::move(numbers)), texts_(std::move(texts)), reads_(true) {}

  bool reads() const { return reads_; }
  const std::vector<double>& numbers() const { return numbers_; }
  const std::vector<std::string>& texts() const { return texts_; }

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void operator()(T& value) {
    if (!reads_) return numbers_.push_back(static_cast<double>(value));
    if (number_ == numbers_.size()) refuse();
    value = static_cast<T>(numbers_[number_++]);
  }
  void operator()(std::string& text) {
    if (!reads_) return texts_.push_back(text);
    if (text_ == texts_.size()) refuse();
    text = texts_[text_++];
  }
  void operator()(dem::Vec3& v) { (*this)(v.x), (*this)(v.y), (*this)(v.z); }
  template <class T>
  void operator()(std::optional<T>& value) {
    bool is = value.has_value();
    (*this)(is);
    if (reads_ && is) value.emplace();
    if (reads_ && !is) value.reset();
    if (is) (*this)(*value);
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    list(values);
  }
  template <class T>
  void operator()(std::deque<T>& values) {
    list(values);
  }
  template <class A, class B>
  void operator()(std::pair<A, B>& pair) {
    (*this)(pair.first), (*this)(pair.second);
  }
  /// A class with `void archive(Archive&)`.
  template <class T>
  requires requires(T& part, Archive& a) { part.archive(a); }
  void operator()(T& part) { part.archive(*this); }
  template <class First, class Second, class... Rest>
  void operator()(First& first, Second& second, Rest&... rest) {
    (*this)(first), (*this)(second), ((*this)(rest), ...);
  }

  /// After all has been read: nothing may be left.
  void end() const {
    if (reads_ && (number_ != numbers_.size() || text_ != texts_.size())) refuse();
  }

 private:
  template <class List>
  void list(List& values) {
    std::size_t size = values.size();
    (*this)(size);
    if (reads_ && size > numbers_.size() + texts_.size()) refuse();
    if (reads_) values.resize(size);
    for (auto& value : values) (*this)(value);
  }
  [[noreturn]] static void refuse() {
    throw std::runtime_error("what the state keeps of the run's sums does not belong to this scenario and version");
  }

  std::vector<double> numbers_;
  std::vector<std::string> texts_;
  bool reads_ = false;
  std::size_t number_ = 0, text_ = 0;
};

}  // namespace subsoil::sim
