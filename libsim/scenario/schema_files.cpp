#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/registry.hpp"
#include "libsim/keys/schema.hpp"
#include "libsim/scenario/load.hpp"

/// The JSON Schemas of scenarios and of the files of other commands.
namespace subsoil::sim {
namespace {

struct SchemaFile {
  std::string name, title;
  Declare declare;
};

std::vector<SchemaFile> schema_files() {
  std::vector<SchemaFile> files{{"scenario", "a scenario of subsoil", [](Fields& fields) {
                                   Scenario prototype;
                                   declare(fields, prototype);
                                   declare_command_sections(fields);
                                 }}};
  files.push_back({"part", "a file that scenarios of subsoil include", files.front().declare});
  for (const CommandFile& file : command_files())
    files.push_back({file.command, fmt::format("the file of `subsoil {}`", file.command), file.declare});
  return files;
}

}  // namespace

std::vector<std::string> schema_names() {
  std::vector<std::string> names;
  for (const SchemaFile& file : schema_files()) names.push_back(file.name);
  return names;
}

std::string schema_text(const std::string& name) {
  const std::vector<SchemaFile> files = schema_files();
  const auto file = std::find_if(files.begin(), files.end(), [&](const SchemaFile& f) { return f.name == name; });
  if (file == files.end()) throw std::invalid_argument("no schema of this name" + suggestion(name, schema_names()));
  SchemaShared shared{.part = true};
  const auto write = [&] {
    Schema schema(shared, "");
    file->declare(schema);
    return schema.object();
  };
  Json root = write();  // its parts are definitions now
  if (name != "part") {
    shared.part = false;
    root = write();
  }
  Json text{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", file->title}};
  if (name == "part")
    text["allOf"] = Json::array({root});
  else
    text.update(root);
  text["definitions"] = shared.definitions;
  return json_text(text) + "\n";
}

}  // namespace subsoil::sim
