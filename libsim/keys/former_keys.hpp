#pragma once
#include <string>
#include <string_view>
#include <vector>

/// Keys and words that version 0.1 knew by another name. A scenario may still use the former name; `check` states the
/// present one. Entries go with the release after next.
namespace subsoil::sim {

/// The former name of a key or word; empty where it never had another.
std::string_view former_of(std::string_view present);
/// The present name of a key or word; empty where `former` is no former name.
std::string_view present_of(std::string_view former);

/// A former name that a file uses.
struct FormerKey {
  std::string path;  ///< with the present name
  std::string former, present;
};

}  // namespace subsoil::sim
