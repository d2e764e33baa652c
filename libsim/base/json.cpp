#include "libsim/base/json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

template class nlohmann::basic_json<nlohmann::ordered_map>;

namespace subsoil::sim {

Json read_json(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("there is none");
  return Json::parse(file);
}

Json read_json_if_whole(const std::filesystem::path& path) {
  std::ifstream file(path);
  const Json json = file ? Json::parse(file, nullptr, false) : Json();
  return json.is_discarded() ? Json() : json;
}

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_rounded(double value) {
  return std::isfinite(value) ? Json(std::stod(fmt::format("{:.6g}", value))) : Json(nullptr);
}

}  // namespace subsoil::sim
