#include "libsim/document/quantity.hpp"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>

#include "libsim/document/arithmetic.hpp"
#include "libsim/document/characters.hpp"
#include "libsim/document/grammar.hpp"

namespace subsoil::sim {
namespace {

/// Takes a number off the front of `text`; nothing when there is none. The whole decimal number, or a refusal.
std::optional<double> take_number(std::string_view& text) {
  std::string_view rest = text;
  if (rest.starts_with('+')) rest.remove_prefix(1);
  std::string_view unsigned_part = rest;
  if (rest.size() != text.size() && rest.starts_with('-')) return {};
  if (unsigned_part.starts_with('-')) unsigned_part.remove_prefix(1);
  const bool number =
      !unsigned_part.empty() && (is_digit(unsigned_part[0]) ||
                                 (unsigned_part[0] == '.' && unsigned_part.size() > 1 && is_digit(unsigned_part[1])));
  if (!number) return {};
  if (unsigned_part.starts_with("0x") || unsigned_part.starts_with("0X")) {
    throw UnitError("hexadecimal numbers are not read; write a decimal number");
  }
  double value = 0;
  const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (code == std::errc::result_out_of_range && std::abs(std::strtod(std::string(rest).c_str(), nullptr)) < 1) {
    value = 0;  // below the smallest double
  } else if (code != std::errc{} || !std::isfinite(value)) {
    throw UnitError("a number is too large for double precision");
  }
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  if (rest.starts_with(',')) throw UnitError("a comma stands in a number; write 1.5, and blanks between numbers");
  text = rest;
  return value;
}

struct Sentence {
  std::vector<double> numbers;
  std::string_view unit;  // empty: none
};

Sentence split(std::string_view text) {
  Sentence sentence;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    std::string_view after = rest;
    const std::optional<double> number = take_number(after);
    const bool unit_one = !sentence.numbers.empty() && number == 1.0 && trimmed(after).starts_with('/');
    if (!number || unit_one) break;  // `5 1/s`: the 1 belongs to the unit
    sentence.numbers.push_back(*number);
    std::string_view next = after;
    if (take_number(next)) throw UnitError("two numbers stand without a blank between them");
    rest = trimmed(after);
  }
  if (sentence.numbers.empty()) {
    std::string word{rest.substr(0, rest.find_first_of(" \t"))};
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    while (!word.empty() && (word[0] == '-' || word[0] == '+' || word[0] == '.')) word.erase(0, 1);
    if (word.starts_with("nan") || word.starts_with("inf")) throw UnitError("must be a finite number");
    throw UnitError("a number must come first, then its unit");
  }
  sentence.unit = rest;
  return sentence;
}

/// One number by arithmetic, of the dimension wanted.
std::vector<double> calculated(std::string_view text, std::string_view expected, std::size_t count,
                               std::optional<double> n) {
  const Amount amount = evaluate_arithmetic(text, n);
  check_dimension(Unit{1, 1, amount.powers}, text, parse_unit(expected, n), expected);
  if (count > 1)
    throw UnitError(fmt::format("is one number; needed are {}, each in a list of its own: [2*a, 30 mm]", count));
  return {amount.value};
}

/// Numbers and one unit.
std::vector<double> written(std::string_view text, std::string_view expected, std::size_t count,
                            std::optional<double> n) {
  Sentence sentence = split(text);
  const Unit wanted = parse_unit(expected, n);
  if (sentence.unit.empty()) {
    if (!wanted.powers.empty()) {
      throw UnitError(fmt::format("has no unit; needed is {}", example(wanted, expected)));
    }
  } else {
    const Unit given = parse_unit(sentence.unit, n);
    check_dimension(given, sentence.unit, wanted, expected);
    for (double& value : sentence.numbers) value = given.to_si(value);
  }
  for (const double value : sentence.numbers) {
    if (!std::isfinite(value)) throw UnitError("a number is too large for double precision in SI units");
  }
  if (count != 0 && sentence.numbers.size() != count) {
    throw UnitError(count == 1 ? fmt::format("holds {} numbers; needed is one", sentence.numbers.size())
                               : fmt::format("holds {} numbers; needed are {}", sentence.numbers.size(), count));
  }
  return sentence.numbers;
}

}  // namespace

std::vector<double> parse_quantities(std::string_view text, std::string_view expected, std::size_t count,
                                     std::optional<double> n) {
  const std::string_view clean = trimmed(text);
  if (is_arithmetic(clean)) return calculated(clean, expected, count, n);
  if (has_parameters() && !clean.empty() && std::isalpha(static_cast<unsigned char>(clean[0])) != 0)
    return calculated(clean, expected, count, n);  // refused by the name that it misses
  try {
    return written(text, expected, count, n);
  } catch (const UnitError&) {
    // It may still be a quotient or difference, such as 1/3 or 50 mm - 3 mm; the refusal is that of the plain value.
    try {
      if (clean.find_first_of("/*+-^") != std::string_view::npos) return calculated(clean, expected, count, n);
    } catch (const UnknownName&) {
      if (has_parameters()) throw;
    } catch (const UnitError&) {
    }
    throw;
  }
}

double parse_quantity(std::string_view text, std::string_view expected, std::optional<double> n) {
  return parse_quantities(text, expected, 1, n).front();
}

double parse_quantity_in(std::string_view text, std::string_view unit) {
  return parse_unit(unit).from_si(parse_quantity(text, unit));
}

double parse_number(std::string_view text) { return parse_quantity(text, "1"); }

}  // namespace subsoil::sim
