#include "apps/commands/page_option.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace subsoil::sim {

void require_page_name(const std::filesystem::path& out, const std::string& cure) {
  const std::string end = out.extension().string();
  if (!end.empty() && end != ".html" && end != ".htm")
    throw std::invalid_argument(
        fmt::format("--out {}: must end in .html, since the command writes a page; {}", out.string(), cure));
  const std::filesystem::path folder = out.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder))
    throw std::invalid_argument(fmt::format("--out {}: there is no folder {}; make it, or write the page elsewhere",
                                            out.string(), folder.string()));
}

}  // namespace subsoil::sim
