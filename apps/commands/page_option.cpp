#include "apps/commands/page_option.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace subsoil::sim {

void require_page_name(const std::filesystem::path& out, const std::string& cure) {
  const std::string end = out.extension().string();
  if (end.empty() || end == ".html" || end == ".htm") return;
  throw std::invalid_argument(
      fmt::format("--out {}: must end in .html, since the command writes a page; {}", out.string(), cure));
}

}  // namespace subsoil::sim
