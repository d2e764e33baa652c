#include "libsim/scenario/load.hpp"

#include "libsim/base/deflate.hpp"
#include "libsim/document/arithmetic.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/keys/registry.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/effects.hpp"

namespace subsoil::sim {
namespace {

/// A parameter that the command line sets and nothing names is a slip of the pen.
void refuse_unused_sets(const Node& document, Problems& problems) {
  const Node::Entry* const list = document.find("parameters");
  if (list == nullptr) return;
  for (const Node::Entry& e : list->value.entries)
    if (e.value.place.line == 0 && !parameter_is_used(e.key))
      problems.add(e.value.place, "parameters." + e.key, e.value.one_line(), "no value names this parameter");
}

Loaded read_checked(const Node& document, Problems& problems) {
  Loaded loaded;
  const ParametersInScope parameters;
  Reading reading(problems);
  read_all(document, reading, [&](Fields& fields) {
    declare(fields, loaded.scenario);
    declare_command_sections(fields);
  });
  refuse_unused_sets(document, problems);
  loaded.places = std::move(reading.places), loaded.former = std::move(reading.former);
  check(loaded.scenario, loaded.places, problems);
  check_effects(loaded.scenario, loaded.places, problems);
  if (!problems.empty()) throw ScenarioError(problems);
  for (const std::string& file : reading.input_files) loaded.scenario.contents[file] = crc32_of_file(file);
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

}  // namespace subsoil::sim
