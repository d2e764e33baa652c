#include "libsim/keys/json_forms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace subsoil::sim {
namespace {

constexpr const char* plain_number = R"([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)";
/// Digits, signs and blanks alone: a unit is missing.
constexpr const char* with_unit = R"(^(?!\s*[-+]?[.]?[0-9][-+0-9.eE\s]*$))";

/// So many numbers, then a unit where one is needed; a regular expression.
std::string vector_pattern(std::size_t count, bool unit) {
  return fmt::format(R"(^\s*(?:{0}\s+){{{1}}}{0}\s*(?![-+.0-9\s]){2})", plain_number, count - 1, unit ? R"(\S)" : "");
}

}  // namespace

Json text_form() { return {{"type", {"string", "number", "boolean"}}}; }

Json text_form(const std::string& pattern) { return {{"type", "string"}, {"pattern", pattern}}; }

Json number_form(const std::string& unit) {
  if (unit == "1") return {{"type", {"number", "string"}}};
  return text_form(with_unit);
}

Json number_form(const std::string& unit, const Range& range) {
  Json form = number_form(unit);
  if (unit != "1") return form;
  if (std::isfinite(range.low())) form[range.open_low() ? "exclusiveMinimum" : "minimum"] = range.low();
  if (std::isfinite(range.high())) form[range.open_high() ? "exclusiveMaximum" : "maximum"] = range.high();
  return form;
}

Json numbers_form(const std::string& unit, std::size_t count) {
  const Json one = number_form(unit);
  return either({count < 2 ? one : text_form(vector_pattern(count, unit != "1")), list_form(one, count)});
}

Json words_form(const std::vector<std::string>& words) {
  Json form{{"enum", words}};
  Json& all = form["enum"];
  for (const std::string& word : words) {  // what YAML makes of some of them
    if (word == "yes") all.push_back(true);
    if (word == "no") all.push_back(false);
    if (!word.empty() && std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; }))
      all.push_back(std::stol(word));
  }
  return form;
}

Json list_form(const Json& item, std::size_t count) {
  Json form{{"type", "array"}, {"items", item}};
  if (count > 0) form["minItems"] = count, form["maxItems"] = count;
  return form;
}

Json either(const std::vector<Json>& forms) { return {{"anyOf", forms}}; }

Json needs_one_of(const std::vector<std::string>& keys) {
  Json all = Json::array();
  for (const std::string& key : keys) all.push_back({{"required", Json::array({key})}});
  return {{"anyOf", all}};
}

Json not_beside(const std::string& key, const std::string& other) {
  return {{"not", {{"required", Json::array({key, other})}}}};
}

}  // namespace subsoil::sim
