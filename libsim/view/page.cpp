#include "libsim/view/page.hpp"

#include "libsim/base/markup.hpp"

namespace subsoil::sim {
namespace {

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
  out += "<title>" + escaped_markup(title) + "</title>\n<style>\n" + parts.styles + "</style>\n</head>\n<body>\n";
  out += "<main id=\"page\"><noscript>This page draws itself: allow scripts.</noscript></main>\n";
  const auto add = [&](const std::string& id, const Json& json) {
    out += "<script type=\"application/json\" id=\"" + id + "\">" + embedded(json) + "</script>\n";
  };
  add("data", data);
  for (const auto& [id, json] : parts.more) add(id, json);
  for (const std::string& script : parts.scripts) out += "<script>" + script + "</script>\n";
  return out + "</body>\n</html>\n";
}

namespace {

std::string titled_scene_page(const std::string& title, const Json& scene) {
  std::string own;
  for (const char* part : {view_data_js, view_chains_js, view_soil_js, view_machine_js, view_stage_js, view_glyphs_js,
                           view_overlay_js, view_panel_js})
    own += part;
  if (scene.is_object() && scene.contains("served")) own += view_served_js;  // the one part that asks for something
  own += view_viewer_js;
  return page_text(title, scene,
                   {std::string(view_uplot_css) + "\n" + view_style_css,
                    {std::string("/* uPlot\n") + view_uplot_license + "*/\n" + view_uplot_js,
                     std::string("/* three.js\n") + view_three_license + "*/\n" + view_three_js, own}});
}

}  // namespace

std::string scene_page(const Json& scene) {
  return titled_scene_page("subsoil: " + scene.at("title").get<std::string>(), scene);
}

Json scene_page_frame() {
  const std::string mark = "the scene", page = titled_scene_page("subsoil", mark), place = json_text(mark);
  const std::size_t at = page.find(place);
  return {{"before", page.substr(0, at)}, {"after", page.substr(at + place.size())}};
}

}  // namespace subsoil::sim
