#include "libsim/report/page.hpp"

#include <fmt/format.h>

namespace subsoil::sim {
namespace {

/// Text for HTML.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

/// JSON inside a script element must not hold "</" or "<!--".
std::string embedded(const Json& data) {
  const std::string text = json_text(data);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string page_text(const std::string& title, const Json& data, const std::string& script) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += "<title>" + escaped(title) + "</title>\n<style>\n" + page_uplot_css + "\n" + page_style_css +
         "</style>\n</head>\n<body>\n";
  out += "<main id=\"page\"><noscript>This page draws itself: allow scripts.</noscript></main>\n";
  out += "<script type=\"application/json\" id=\"data\">" + embedded(data) + "</script>\n";
  out += std::string("<script>/* uPlot\n") + page_uplot_license + "*/\n" + page_uplot_js + "</script>\n";
  out += std::string("<script>\n") + page_film_js + "</script>\n<script>\n" + script + "</script>\n</body>\n</html>\n";
  return out;
}

}  // namespace subsoil::sim
