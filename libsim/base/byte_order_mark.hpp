#pragma once
#include <string_view>

namespace subsoil::sim {

/// The text without the byte order mark that editors and spreadsheets put before UTF-8.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

}  // namespace subsoil::sim
