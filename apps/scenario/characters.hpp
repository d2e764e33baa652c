#pragma once
#include <cctype>

/// Characters of units and formulas.
namespace subsoil::app {

inline bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace subsoil::app
