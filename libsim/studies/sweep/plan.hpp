#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libsim/document/document.hpp"
#include "libsim/keys/ranges.hpp"
#include "libsim/scenario/scenario.hpp"
#include "libsim/studies/sweep/number.hpp"

/// What `subsoil sweep` is asked: keys of a scenario with values, and the numbers that are wanted of every run.
namespace subsoil::sim {

/// One thing that changes. Values, factors, levels and seeds are lists; `between` alone is a range.
struct SweepParameter {
  std::string name, keys, values_text, unit;
  std::vector<double> factors, between;
  std::optional<long> levels, seeds;
  Scale scale = Scale::linear;
  std::vector<std::string> paths;   ///< of `keys`
  std::vector<std::string> values;  ///< of a list, as a scenario writes them; of factors: the factors

  template <class V>
  void describe(V& v) {
    v.joined_text("keys", keys,
                  "path of the value in the scenario, several with ; between: contacts[0].mu; contacts[1].mu");
    v.joined_text("values", values_text,
                  "list of values as the scenario would write them: [8 mm, 10 mm], or with ; between");
    v.quantities("factors", factors, "1", "(0, inf)",
                 "in place of values: multiples of what the scenario has at the keys");
    v.quantities("between", between, "1", "(-inf, inf)",
                 "least and largest, in `unit`: a range that Latin hypercube points fill, or with `levels` a list");
    v.count("levels", levels, "[2, 1000]", "so many values at equal distances in `between`, its ends among them");
    v.count("seeds", seeds, "[1, 1000]", "the values 1, 2, ... so many: packings, with the key soil.bed.seed");
    v.text("unit", unit, "of `between`; left out: a number");
    v.choice("scale", scale, {{"linear", Scale::linear}, {"log", Scale::log}}, "of `between`");
  }
  bool is_range() const { return between.size() == 2 && !levels; }
  /// Of u in [0, 1], in `unit`.
  double at(double u) const;
};

enum class Keep { numbers, all };

struct SweepPlan {
  long version = 1;
  std::string title, scenario, set, best;
  std::vector<SweepParameter> parameters;
  std::vector<SweepNumber> numbers;
  long points = 10, seed = 1, threads = 1;
  std::optional<long> at_once;
  Keep keep = Keep::numbers;

  template <class V>
  void describe(V& v) {
    v.version("subsoil", version, "version of the format: 1");
    v.text("title", title, "one line about what this is");
    v.file("scenario", scenario, "scenario that every point changes, beside the plan");
    v.joined_text("set", set, "path=value for all points, several with ; between, or a list");
    v.named("parameters", parameters, "what changes; every combination of the lists runs at every point of the ranges");
    v.named("numbers", numbers,
            "what is wanted of every run; left out: means of draft and pull where they are monitored, else of "
            "soil.draft, else of every monitor");
    v.text("best", best, "`least NUMBER` or `largest NUMBER`: the point that the report puts first");
    v.count("points", points, "[1, 100000]", "of the Latin hypercube that fills the ranges");
    v.count("seed", seed, "[0, inf)", "of the Latin hypercube");
    v.count("threads", threads, "[1, 1024]", "cores of each run; no two runs share one");
    v.count("at once", at_once, "[1, 100000]", "runs side by side at most; left out: as many as the cores allow");
    v.choice("keep", keep, {{"numbers", Keep::numbers}, {"all", Keep::all}},
             "numbers: of a finished run scenario, series and summary; all: frames and states too");
  }
};

/// Reads and checks a plan. Throws ScenarioError with all faults.
SweepPlan load_sweep(const std::string& file, const std::vector<std::string>& sets = {});

/// One run of a sweep.
struct SweepPoint {
  std::vector<std::string> values;  ///< per parameter, as shown
  std::vector<double> places;       ///< per parameter: the number in it (of several the first), NaN of a word
  std::vector<std::string> sets;    ///< path=value of the run
};

/// All points in a fixed order; the first parameter changes slowest, the ranges slowest of all. Throws ScenarioError,
/// at the plan's place, for a key or value that the scenario refuses: before anything runs.
std::vector<SweepPoint> sweep_points(const std::string& file, const SweepPlan& plan);

/// u of `points` x `dimensions` in (0, 1): each of the equal strata of every dimension holds one point. McKay, Beckman,
/// Conover, Technometrics 21 (1979) 239.
std::vector<std::vector<double>> latin_hypercube(long points, std::size_t dimensions, long seed);

/// The single value at a path of a scenario with its defaults, multiplied by a factor: `contacts.soil-soil.K_X` ->
/// "20000 N/m". Of several numbers each is multiplied. Throws std::invalid_argument where there is no number.
std::string scaled_value(const Node& scenario, const std::string& path, double factor);
/// The tree that scaled_value looks at.
Node explicit_tree(const Scenario& scenario);

}  // namespace subsoil::sim
