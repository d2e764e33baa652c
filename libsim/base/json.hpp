#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "libsim/base/json_fwd.hpp"

/// Members, reader and printer of JSON are compiled in json.cpp alone: every file that uses them would take seconds.
extern template class nlohmann::basic_json<nlohmann::ordered_map>;

namespace subsoil::sim {

/// The document in a file; throws a std::exception that states what is wrong with it, "there is none" without a file.
Json read_json(const std::filesystem::path& path);
/// The same; null in place of an error.
Json read_json_if_whole(const std::filesystem::path& path);
/// A document as text: in one line, or with `indent` blanks for each level. Bytes that are no UTF-8 become U+FFFD.
std::string json_text(const Json& json, int indent = -1);
/// A number; null for one that is not finite, which JSON cannot hold.
Json json_number(double value);
/// The same with six digits.
Json json_rounded(double value);

}  // namespace subsoil::sim
