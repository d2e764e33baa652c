#pragma once
#include <array>
#include <cctype>
#include <string_view>

/// Characters of units and formulas.
namespace subsoil::sim {

inline bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// The name at the front: a letter or _, then letters, digits and _.
inline std::string_view name_at(std::string_view text) {
  std::size_t size = 0;
  while (size < text.size() && (is_letter(text[size]) || (size > 0 && is_digit(text[size])))) ++size;
  return text.substr(0, size);
}

/// The first character of UTF-8 text, with all its bytes.
inline std::string_view character_at(std::string_view text) {
  std::size_t size = text.empty() ? 0 : 1;
  while (size > 0 && size < text.size() && size < 4 && (static_cast<unsigned char>(text[size]) & 0xC0) == 0x80) ++size;
  return text.substr(0, size);
}

struct Typeset {
  std::string_view character;  ///< UTF-8
  char plain;
};
/// The digit or sign that a superscript at the front stands for; 0: there is none.
inline Typeset superscript_at(std::string_view text) {
  static constexpr std::array<Typeset, 12> all{{{"⁻", '-'},
                                                {"⁺", '+'},
                                                {"⁰", '0'},
                                                {"¹", '1'},
                                                {"²", '2'},
                                                {"³", '3'},
                                                {"⁴", '4'},
                                                {"⁵", '5'},
                                                {"⁶", '6'},
                                                {"⁷", '7'},
                                                {"⁸", '8'},
                                                {"⁹", '9'}}};
  for (const Typeset& s : all)
    if (text.starts_with(s.character)) return s;
  return {{}, 0};
}
/// The operator of the keyboard that a typeset one at the front stands for; 0: there is none.
inline char typeset_operator_at(std::string_view text) {
  static constexpr std::array<Typeset, 8> all{
      {{"−", '-'}, {"–", '-'}, {"—", '-'}, {"×", '*'}, {"⋅", '*'}, {"·", '*'}, {"∗", '*'}, {"÷", '/'}}};
  for (const Typeset& s : all)
    if (text.starts_with(s.character)) return s.plain;
  return 0;
}

/// Without blanks at either end.
inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace subsoil::sim
