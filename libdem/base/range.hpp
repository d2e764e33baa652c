#pragma once
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>

namespace subsoil::dem {

/// An interval of numbers: "(0, 1]". Made of a string literal when the program is compiled, so that declarations of
/// laws and elements need not name the type, and a range that is none ("[0 1)", "(2, 1)") does not compile.
class Range {
 public:
  template <std::size_t size>
  consteval Range(const char (&literal)[size]) : text_(literal, size - 1) {  // NOLINT: declarations give the literal
    const std::size_t comma = text_.find(',');
    if (comma == std::string_view::npos) throw "a range is written (low, high], with a comma";
    const char open = text_.front(), close = text_.back();
    if ((open != '(' && open != '[') || (close != ')' && close != ']')) throw "a range stands in ( or [ and ) or ]";
    open_low_ = open == '(', open_high_ = close == ')';
    low_ = number(text_.substr(1, comma - 1));
    high_ = number(text_.substr(comma + 1, text_.size() - comma - 2));
    if (!(low_ <= high_)) throw "a range begins with its lower bound";
  }

  constexpr double low() const { return low_; }
  constexpr double high() const { return high_; }
  constexpr bool open_low() const { return open_low_; }    ///< the bound itself is outside
  constexpr bool open_high() const { return open_high_; }  ///< the bound itself is outside
  constexpr std::string_view text() const { return text_; }

  /// False for NaN.
  constexpr bool contains(double x) const {
    return (open_low_ ? x > low_ : x >= low_) && (open_high_ ? x < high_ : x <= high_);
  }

 private:
  /// Digits with at most one point; "inf". Up to 15 digits: whole numbers divided by a power of ten are then exact to
  /// the last bit.
  static constexpr double number(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    const bool negative = !text.empty() && text.front() == '-';
    if (negative) text.remove_prefix(1);
    double value = 0, scale = 1;
    if (text == "inf") {
      value = std::numeric_limits<double>::infinity();
    } else {
      if (text.empty() || text.size() > 15) throw "a bound is a decimal number or inf";
      bool behind = false;
      for (const char c : text) {
        if (c == '.' && !behind) {
          behind = true;
          continue;
        }
        if (c < '0' || c > '9') throw "a bound is a decimal number or inf";
        value = 10 * value + (c - '0');
        if (behind) scale *= 10;
      }
    }
    return (negative ? -value : value) / scale;
  }

  std::string_view text_;
  double low_ = 0, high_ = 0;
  bool open_low_ = false, open_high_ = false;
};

}  // namespace subsoil::dem
