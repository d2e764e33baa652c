#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "libsim/base/json.hpp"
#include "libsim/keys/field.hpp"
#include "libsim/keys/range.hpp"

/// JSON Schemas of single values, as YAML hands them over: a plain number or word, or text.
namespace subsoil::sim {

/// Text of any kind; YAML takes some of it for a number or a truth value.
Json text_form();
/// Text that a regular expression describes.
Json text_form(const std::string& pattern);
/// A number with its unit, or a formula. A unit that is missing is seen, one of a wrong dimension is not.
Json number_form(const std::string& unit);
/// The same; plain numbers outside the range are refused.
Json number_form(const std::string& unit, const Range& range);
/// `1 2 3 mm` or [1 mm, 2 mm, 3 mm]; count 0: any number of them.
Json numbers_form(const std::string& unit, std::size_t count);
Json words_form(const std::vector<std::string>& words);
/// count 0: of any length.
Json list_form(const Json& item, std::size_t count = 0);
Json either(const std::vector<Json>& forms);
/// A rule for mappings: at least one of these keys.
Json needs_one_of(const std::vector<std::string>& keys);
/// A rule for mappings: not both.
Json not_beside(const std::string& key, const std::string& other);

}  // namespace subsoil::sim
