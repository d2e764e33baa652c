#include "apps/commands/templates.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "libsim/document/document.hpp"

namespace subsoil::sim {

std::string_view Template::about() const {
  const std::size_t end = scenario.find('\n');
  return scenario.substr(2, end - 2);
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
