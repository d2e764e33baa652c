#include "libsim/studies/laboratory/tests.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "libsim/document/arithmetic.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/studies/laboratory/jobs.hpp"

namespace subsoil::sim {
namespace {

/// What keeps a sample from being that of the scenario's bed.
struct BedOfTests {
  std::vector<std::string> layers{};  ///< their materials
  bool own_radii = false;             ///< of layers, or clumps among their grains
};

BedOfTests bed_of(const Scenario& s, const Places& places) {
  BedOfTests bed;
  if (!s.soil || !s.soil->bed) return bed;
  for (std::size_t k = 0; k < s.soil->bed->layers.size(); ++k) {
    const std::string& name = s.soil->bed->layers[k].material;
    if (std::find(bed.layers.begin(), bed.layers.end(), name) == bed.layers.end()) bed.layers.push_back(name);
    bed.own_radii = bed.own_radii || !s.soil->bed->layers[k].clumps.empty() ||
                    places.contains(fmt::format("soil.bed.layers[{}].radius", k));
  }
  return bed;
}

/// What the test leaves out comes from the scenario's bed; then the bed becomes the test's own.
void take_bed(Scenario& s, SampleWords& words, const Places& places) {
  if (s.soil && s.soil->bed) {
    if (words.material.empty()) words.material = s.soil->bed->material;
    if (!places.contains("test.radius")) {
      if (places.contains("soil.bed.radius")) words.radius = s.soil->bed->radius, words.shares = s.soil->bed->shares;
      words.clumps = s.soil->bed->clumps;
      if (!words.clumps.empty()) words.shapes = s.soil->clumps;
    }
  }
  if (words.walls.empty() && s.soil && s.soil->container) words.walls = s.soil->container->material;
  Soil soil;
  soil.container.emplace().size = {1, 1, 1};
  soil.container->at = {};
  soil.container->material = words.walls;
  soil.bed.emplace().fill = Fill::random;
  soil.bed->material = words.material;
  soil.bed->radius = words.radius;
  soil.bed->clumps = words.clumps, soil.clumps = words.shapes;
  s.soil = soil;
  s.boundaries.clear();
  s.machine.reset();
  s.analysis = Analysis::dynamics;
  s.output = {};
}

/// Places of the keys that a test uses; those of the bed and of the end stand for its own.
Places kept(const Places& places) {
  Places out;
  const Place top = places.at("");
  for (const auto& [path, place] : places)
    for (const char* head : {"materials", "contacts", "test", "gravity", "time", "soil.clumps", "soil.bed.clumps"})
      if (path.starts_with(head)) out.emplace(path, place);
  out[""] = top;
  const auto radius = places.contains("test.radius") ? places.find("test.radius") : places.find("soil.bed.radius");
  if (radius != places.end()) out["soil.bed.radius"] = radius->second;
  out.try_emplace("time.end", top);  // a test ends by itself
  return out;
}

/// What is wrong with keys beside each other, whatever the grains are.
template <class Refuse>
void check_ranges(const LaboratoryTests& tests, const Refuse& refuse) {
  const auto& loads = tests.shear.loads;
  if (loads.size() < 2)
    refuse("test.shear.loads", "must be two loads or more, for a line through their points");
  else if (const auto [least, largest] = std::minmax_element(loads.begin(), loads.end()); *least == *largest)
    refuse("test.shear.loads", "are all equal: two must differ, for a line through their points");
  if (tests.tilt.from >= tests.tilt.until)
    refuse("test.tilt.from", "must be below `until`: up to there the box is tilted quickly, and nothing is measured");
}

void check_tests(const LoadedTests& loaded, const BedOfTests& bed, Problems& problems) {
  const Places& places = loaded.loaded.places;
  const auto refuse = [&](const std::string& path, const std::string& rule) {
    problems.add(place_of(places, path), path, rule);
  };
  const SampleWords& words = loaded.tests.sample;
  if (words.material.empty() && !bed.layers.empty())
    refuse("test.material",
           fmt::format("is missing: the material of the grains; the bed has layers, name one of theirs: {}",
                       fmt::join(bed.layers, ", ")));
  else if (words.material.empty())
    refuse("test.material", "is missing: the material of the grains; the scenario has no bed to take it from");
  if (words.walls.empty())
    refuse("test.walls", "is missing: the material of the walls; the scenario has no container to take it from");
  if (bed.own_radii && !places.contains("test.radius"))
    refuse("test.radius", "is missing: radius of the grains, in m; the layers of the bed have grains of their own");
  else if (!places.contains("soil.bed.radius") && !only_clumps(words.clumps))
    refuse("test.radius", "is missing: radius of the grains, in m; the scenario has no bed to take it from");
  std::vector<std::string> known;
  for (const Material& m : loaded.loaded.scenario.materials) known.push_back(m.name);
  for (const auto& [path, name] : {std::pair{"test.material", words.material}, std::pair{"test.walls", words.walls}})
    if (!name.empty() && std::find(known.begin(), known.end(), name) == known.end())
      problems.add(place_of(places, path), path, name, "there is no material of this name" + suggestion(name, known));
  const Vec3& g = loaded.loaded.scenario.gravity;
  if (!(g.x == 0 && g.z == 0 && g.y < 0)) refuse("gravity", "must act downward (-y) for laboratory tests");
  check_ranges(loaded.tests, refuse);
}

}  // namespace

std::vector<std::string> test_words() {
  std::vector<std::string> words;
  LaboratoryTests tests;
  LaboratoryTests::each(tests, [&](const char* word, auto&, const char*) { words.emplace_back(word); });
  return words;
}

std::vector<Number> test_numbers(const std::string& word) {
  std::vector<Number> numbers;
  LaboratoryTests tests;
  LaboratoryTests::each(tests, [&](const char* name, auto& test, const char*) {
    if (word == name) numbers = test.numbers();
  });
  if (numbers.empty())
    throw std::invalid_argument("there is no laboratory test of this name" + suggestion(word, test_words()));
  return numbers;
}

LoadedTests load_tests(const std::string& file, const std::vector<std::string>& sets) {
  Problems problems;
  const Node document = read_document(file, sets, problems);
  LoadedTests loaded;
  const ParametersInScope parameters;
  Reading reading(problems);
  read_all(document, reading, [&](Fields& fields) {
    declare(fields, loaded.loaded.scenario);
    fields.section("test", loaded.tests, "laboratory tests of a material");
  });
  if (!problems.empty()) throw ScenarioError(problems);
  const BedOfTests bed = bed_of(loaded.loaded.scenario, reading.places);
  take_bed(loaded.loaded.scenario, loaded.tests.sample, reading.places);
  loaded.loaded.places = kept(reading.places);
  check_tests(loaded, bed, problems);
  if (problems.empty()) check(loaded.loaded.scenario, loaded.loaded.places, problems);
  if (!problems.empty()) throw ScenarioError(problems);
  return loaded;
}

Findings run_test(const LoadedTests& loaded, const std::string& word, int threads,
                  const std::function<void(std::size_t, std::size_t)>& progress) {
  const Sample sample = make_sample(loaded.loaded, loaded.tests.sample);
  const auto packings = static_cast<std::size_t>(loaded.tests.sample.packings);
  Findings found;
  LaboratoryTests::each(loaded.tests, [&](const char* name, const auto& test, const char*) {
    if (word != name) return;
    std::vector<Outcome> outcomes(test.specimens(packings));
    const auto run = [&](std::size_t i) {
      try {
        outcomes[i] = test.run(sample, i);
      } catch (const std::invalid_argument& error) {
        throw ScenarioError(loaded.loaded.where("test." + word) + ": " + error.what());
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(fmt::format("{}, specimen {} of {}: {}", word, i + 1, outcomes.size(), error.what()));
      }
    };
    run_jobs(outcomes.size(), threads, run, [&](std::size_t done) {
      if (progress) progress(done, outcomes.size());
    });
    found = test.findings(sample, packings, outcomes);
  });
  if (found.test.empty()) throw std::invalid_argument(word + ": no laboratory test" + suggestion(word, test_words()));
  return found;
}

}  // namespace subsoil::sim
