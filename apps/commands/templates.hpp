#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

/// The scenarios to start from: configs/templates, built into the program.
namespace subsoil::sim {

struct Template {
  std::string_view name;      ///< tine
  std::string_view scenario;  ///< the YAML text
  std::string_view mesh;      ///< text of the STL file that it names, NAME.stl; empty: it names none
  /// The first line of its comment, below the schema line.
  std::string_view about() const;
};

std::span<const Template> templates();
/// `subsoil new --list`.
std::string template_list();
/// {tine,rotor,...}: what stands for a name in the help.
std::string template_words();
/// The text with the schema line that yaml-language-server reads: the schema installed with the program at `program`,
/// or subsoil.schema.json beside the scenario where there is none.
std::string with_schema_line(std::string_view scenario, const std::filesystem::path& program);
/// Throws std::invalid_argument with the names there are.
const Template& template_of(std::string_view name);

}  // namespace subsoil::sim
