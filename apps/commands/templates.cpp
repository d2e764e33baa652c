#include "apps/commands/templates.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "libsim/document/document.hpp"

namespace subsoil::sim {
namespace {

constexpr std::string_view schema_line = "# yaml-language-server: $schema=";

std::string_view without_schema_line(std::string_view text) {
  return text.starts_with(schema_line) ? text.substr(text.find('\n') + 1) : text;
}

}  // namespace

std::string_view Template::about() const {
  const std::string_view text = without_schema_line(scenario);
  const std::size_t end = text.find('\n');
  return text.substr(2, end - 2);
}

std::string template_list() {
  std::string out;
  for (const Template& t : templates()) out += fmt::format("{:<16} {}\n", t.name, t.about());
  return out;
}

std::string template_words() {
  std::string out;
  for (const Template& t : templates()) out += fmt::format("{}{}", out.empty() ? "{" : ",", t.name);
  return out + "}";
}

std::string with_schema_line(std::string_view scenario, const std::filesystem::path& program) {
  const std::filesystem::path installed = program.parent_path().parent_path() / "share/subsoil/subsoil.schema.json";
  const std::string schema = std::filesystem::exists(installed) ? installed.string() : "subsoil.schema.json";
  return fmt::format("{}{}\n{}", schema_line, schema, without_schema_line(scenario));
}

const Template& template_of(std::string_view name) {
  std::vector<std::string> known;
  for (const Template& t : templates()) {
    if (t.name == name) return t;
    known.emplace_back(t.name);
  }
  throw std::invalid_argument(
      fmt::format("{}: no template of this name{}", name, suggestion(std::string(name), known)));
}

}  // namespace subsoil::sim
