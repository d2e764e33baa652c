#pragma once
#include <string>
#include <string_view>

namespace subsoil::sim {

/// Text as content or attribute of XML and HTML. Names are the user's: what reads as markup becomes an entity, line
/// breaks and tabs become character references, since attributes lose them else. XML 1.0 knows no other control
/// characters, section 2.2: they become spaces.
inline std::string escaped_markup(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\t':
        out += "&#9;";
        break;
      case '\n':
        out += "&#10;";
        break;
      case '\r':
        out += "&#13;";
        break;
      default:
        out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  return out;
}

}  // namespace subsoil::sim
