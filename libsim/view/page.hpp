#pragma once
#include <string>
#include <utility>
#include <vector>

#include "libsim/base/json.hpp"

namespace subsoil::sim {

/// Files of page/ and vendor/ as they stood at the build (embed.cmake).
extern const char* const view_three_js;
extern const char* const view_three_license;
extern const char* const view_uplot_js;
extern const char* const view_uplot_css;
extern const char* const view_uplot_license;
extern const char* const view_style_css;
extern const char* const view_data_js;
extern const char* const view_chains_js;
extern const char* const view_soil_js;
extern const char* const view_machine_js;
extern const char* const view_stage_js;
extern const char* const view_glyphs_js;
extern const char* const view_overlay_js;
extern const char* const view_panel_js;
extern const char* const view_served_js;
extern const char* const view_viewer_js;

/// What a page is made of beside its data. Scripts run in their order.
struct PageParts {
  std::string styles;
  std::vector<std::string> scripts;
  std::vector<std::pair<std::string, Json>> more{};  ///< further data, each in an element of this id
};

/// A page that opens without network: styles, data and scripts in one text. Scripts find the data as JSON in the
/// element `data` and draw into the element `page`.
std::string page_text(const std::string& title, const Json& data, const PageParts& parts);

/// The page that draws a scene (scene.hpp).
std::string scene_page(const Json& scene);

/// What stands `before` and `after` the scene in the page that draws it, for pages that hold such pages.
Json scene_page_frame();

}  // namespace subsoil::sim
