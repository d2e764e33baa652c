#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "libsim/base/json.hpp"

namespace subsoil::sim {

/// Files of page/ as they stood at the build (embed.cmake).
extern const char* const page_style_css;
extern const char* const page_figures_js;
extern const char* const page_report_js;
extern const char* const page_sweep_js;

/// A page that opens without network: styles, plotting library, scripts and data in one text. `script` draws `data`.
/// `more`: further data, each in an element of this id.
std::string report_page(const std::string& title, const Json& data, const std::string& script,
                        std::vector<std::pair<std::string, Json>> more = {});

}  // namespace subsoil::sim
