#pragma once
#include <filesystem>
#include <string>

#include "libsim/base/json.hpp"

namespace subsoil::sim {

/// Files of page/ as they stood at the build (embed.cmake).
extern const char* const page_style_css;
extern const char* const page_film_js;
extern const char* const page_report_js;
extern const char* const page_sweep_js;

/// A page that opens without network: styles, plotting library, scripts and data in one text. `script` draws `data`.
std::string report_page(const std::string& title, const Json& data, const std::string& script);

}  // namespace subsoil::sim
