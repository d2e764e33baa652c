#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libsim/scenario/load.hpp"
#include "libsim/studies/laboratory/compress.hpp"
#include "libsim/studies/laboratory/penetrate.hpp"
#include "libsim/studies/laboratory/pull.hpp"
#include "libsim/studies/laboratory/repose.hpp"
#include "libsim/studies/laboratory/shatter.hpp"
#include "libsim/studies/laboratory/shear.hpp"
#include "libsim/studies/laboratory/tilt.hpp"

/// `subsoil test`: a material put through laboratory tests. A scenario of any kind names materials and contacts; its
/// section `test` states what of them is tested and how.
namespace subsoil::sim {

/// What a sample is made of.
struct SampleWords {
  std::string material, walls;
  RadiusDistribution radius;
  ShareOf shares = ShareOf::number;
  long seed = 1, packings = 3;
  double lowered = 0.1, at_most = 10;
  std::vector<ClumpSection> shapes{};  ///< of the scenario, and how many of its bed's grains are of them
  std::vector<ClumpShare> clumps{};

  template <class V>
  void describe(V& v) {
    v.optional_reference("material", material, Family::material, "of the grains; left out: the bed's");
    v.optional_reference("walls", walls, Family::material, "of floors, lids and tools; left out: the container's");
    v.optional_form("radius", radius, "of the grains, or a distribution; left out: the bed's");
    v.choice("shares", shares, {{"number", ShareOf::number}, {"mass", ShareOf::mass}},
             "what the distribution of radii counts");
    v.count("packings", packings, "[1, 1000]", "random packings; every number has an error bar over them");
    v.count("seed", seed, "[0, inf)", "of the first packing; the next ones follow");
    v.quantity("lowered", lowered, "1", "[0, 1]",
               "factor on friction and rolling while a packing is made: 0 dense, 1 loose");
    v.quantity("at most", at_most, "s", "(0, inf)", "a packing or slope that is not at rest by then stops the test");
  }
};

/// The section `test`.
struct LaboratoryTests {
  SampleWords sample;
  Repose repose;
  Shear shear;
  Compress compress;
  Penetrate penetrate;
  Pull pull;
  Tilt tilt;
  Shatter shatter;

  template <class V>
  void describe(V& v) {
    sample.describe(v);
    each(*this, [&](const char* word, auto& test, const char* meaning) { v.section(word, test, meaning); });
  }
  /// The list of tests: use(word, test, meaning).
  template <class Tests, class Use>
  static void each(Tests& tests, Use use) {
    use("repose", tests.repose, "angle of repose");
    use("shear", tests.shear, "direct shear box: friction angle and cohesion");
    use("compress", tests.compress, "uniaxial compression: constrained modulus, unloading, lateral stress");
    use("penetrate", tests.penetrate, "cone or plate pushed in: resistance over depth, cone index, sinkage");
    use("pull", tests.pull, "direct tension in an eight-shaped mould: tensile strength");
    use("tilt", tests.tilt, "box tilted until its packing slides");
    use("shatter", tests.shatter, "a clod struck: share of the largest piece");
  }
};
std::vector<std::string> test_words();
/// What a test gives, without values. Throws std::invalid_argument with the nearest word.
std::vector<Number> test_numbers(const std::string& word);

struct LoadedTests {
  Loaded loaded;  ///< the scenario, cut down to what tests use
  LaboratoryTests tests;
};

/// Reads and checks a scenario with `path=value` overrides. Throws ScenarioError with all faults.
LoadedTests load_tests(const std::string& file, const std::vector<std::string>& sets);

/// Runs one test by its word over all packings; `progress` receives how many specimens of how many are done.
Findings run_test(const LoadedTests& loaded, const std::string& word, int threads,
                  const std::function<void(std::size_t done, std::size_t all)>& progress = {});

}  // namespace subsoil::sim
