#include "apps/scenario/load.hpp"

#include "apps/scenario/checks.hpp"
#include "apps/scenario/fields/fields.hpp"
#include "apps/scenario/registry.hpp"

namespace subsoil::app {
namespace {

Loaded read_checked(const Node& document, Problems& problems) {
  Loaded loaded;
  Reading reading(problems);
  read_all(document, reading, [&](Fields& fields) {
    declare(fields, loaded.scenario);
    declare_command_sections(fields);
  });
  loaded.places = std::move(reading.places);
  check(loaded.scenario, loaded.places, problems);
  if (!problems.empty()) throw ScenarioError(problems);
  return loaded;
}

}  // namespace

void declare_command_sections(Fields& fields) {
  for (const CommandSection& section : command_sections()) {
    SectionMember member{.when = SectionMember::When::given, .declare = section.declare, .prototype = section.declare};
    fields.visit_section({section.key, section.meaning}, member);
  }
}

std::string Loaded::where(const std::string& path) const { return place_of(places, path).text() + " " + path; }

Loaded load_scenario(const std::string& file, const std::vector<std::string>& sets) {
  Problems problems;
  return read_checked(read_document(file, sets, problems), problems);
}

Loaded load_scenario_text(const std::string& text, const std::string& name, const std::vector<std::string>& sets) {
  Problems problems;
  return read_checked(parse_document(text, name, sets, problems), problems);
}

}  // namespace subsoil::app
