#pragma once
#include <filesystem>
#include <string>

namespace subsoil::sim {

/// Of a command that writes one HTML page: throws std::invalid_argument where `--out` is named as something else, such
/// as x.png. `cure` states how to come by a picture.
void require_page_name(const std::filesystem::path& out, const std::string& cure);

}  // namespace subsoil::sim
