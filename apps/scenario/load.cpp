#include "apps/scenario/load.hpp"

#include "apps/laboratory/tests.hpp"
#include "apps/scenario/checks.hpp"
#include "apps/scenario/reader.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/measures.hpp"

namespace subsoil::app {
namespace {

Loaded read_checked(const Node& document, Problems& problems) {
  Loaded loaded;
  Reading reading{
      .problems = problems, .places = {}, .body_names = {"ground"}, .body_poses = {mbd::BodyState{}}, .markers = {}};
  reading.places[""] = document.place;
  Reader reader(reading, document, "");
  declare(reader, loaded.scenario);
  std::optional<ElementTests> tests;  // of the same material; a run checks the section and leaves it
  reader.section("test", tests, "laboratory tests");
  reader.finish();
  loaded.places = std::move(reading.places);
  check(loaded.scenario, loaded.places, problems);
  if (!problems.empty()) throw ScenarioError(problems);
  return loaded;
}

}  // namespace

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
