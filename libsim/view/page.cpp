#include "libsim/view/page.hpp"

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

std::string page_text(const std::string& title, const Json& data, const PageParts& parts) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += "<title>" + escaped(title) + "</title>\n<style>\n" + parts.styles + "</style>\n</head>\n<body>\n";
  out += "<main id=\"page\"><noscript>This page draws itself: allow scripts.</noscript></main>\n";
  out += "<script type=\"application/json\" id=\"data\">" + embedded(data) + "</script>\n";
  for (const std::string& script : parts.scripts) out += "<script>" + script + "</script>\n";
  return out + "</body>\n</html>\n";
}

std::string scene_page(const Json& scene) {
  std::string own;
  for (const char* part : {view_data_js, view_soil_js, view_machine_js, view_stage_js, view_glyphs_js, view_overlay_js,
                           view_panel_js, view_viewer_js})
    own += part;
  return page_text("subsoil: " + scene.at("title").get<std::string>(), scene,
                   {std::string(view_uplot_css) + "\n" + view_style_css,
                    {std::string("/* uPlot\n") + view_uplot_license + "*/\n" + view_uplot_js,
                     std::string("/* three.js\n") + view_three_license + "*/\n" + view_three_js, own}});
}

}  // namespace subsoil::sim
