#include <fmt/format.h>

#include <algorithm>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/commands.hpp"
#include "apps/commands/plan_columns.hpp"
#include "apps/commands/sweep_command.hpp"
#include "libsim/base/live_line.hpp"
#include "libsim/base/signals.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/studies/credibility/verdict.hpp"
#include "libsim/studies/sweep/tables.hpp"

namespace subsoil::sim {
namespace {

Study study_of(const CredibilityRequest& request, const Loaded& loaded, const Axes& axes) {
  Study study;
  study.title = "Credibility of " + (loaded.scenario.title.empty() ? request.scenario : loaded.scenario.title);
  study.scenario = request.scenario;
  study.parameters = {"axis"};
  for (const Axis& a : axes.axes) {
    SweepPoint point{{a.name}, {std::numeric_limits<double>::quiet_NaN()}, request.sets};
    point.sets.insert(point.sets.end(), a.sets.begin(), a.sets.end());
    point.sets.push_back("output.state=none");
    study.points.push_back(std::move(point));
  }
  for (const std::string& column : request.numbers) {
    SweepNumber n;
    n.name = n.column = column;
    study.numbers.push_back(n);
  }
  if (study.numbers.empty()) study.numbers = usual_numbers(loaded.scenario);
  if (study.numbers.empty())
    throw ScenarioError(loaded.where("output.monitor") + ": has no monitor; name columns to judge with --numbers");
  return study;
}

/// Every variant must be a scenario before the first one runs.
void check_points(const Study& study, const Axes& axes) {
  for (std::size_t k = 0; k < study.points.size(); ++k) try {
      static_cast<void>(load_scenario(study.scenario, study.points[k].sets));
    } catch (const ScenarioError& error) {
      throw ScenarioError(fmt::format("{}: the axis `{}` makes a scenario that is refused:\n{}", study.scenario,
                                      axes.axes[k].name, error.what()));
    }
}

/// A trial of the scenario as given, times the factors of each axis.
void print_cost(const CredibilityRequest& request, const Axes& axes, std::size_t places) {
  const Estimate base =
      estimate({.scenario = request.scenario, .out = {}, .sets = request.sets, .threads = request.threads, .from = {}});
  double total = 0;
  fmt::print("{:<22} {:>9} {:>7} {:>12} {:>10}\n", "run", "spheres", "steps", "about", "memory");
  for (const Axis& a : axes.axes) {
    const double time = base.wall_time * a.spheres * a.steps;
    total += time;
    fmt::print("{:<22} {:>9} {:>7} {:>12} {:>7.0f} MB\n", a.name, fmt::format("x {:g}", a.spheres),
               fmt::format("x {:.3g}", a.steps), clock_text(time),
               (base.memory_of_program + (base.memory - base.memory_of_program) * a.spheres) * 1e-6);
  }
  fmt::print("{:<22} {:>30} on {} core(s) at once: about {}\n", "all", clock_text(total),
             request.threads * static_cast<int>(places), clock_text(total / static_cast<double>(places)));
}

void write_verdicts(const Json& json, const std::filesystem::path& path) {
  std::string text = "axis,number,as given,changed,change,uncertainty,verdict\n";
  for (const auto& r : json["rows"]) {
    std::string line;
    for (const char* key : {"axis", "number", "base", "changed", "change", "uncertainty", "verdict"})
      line += fmt::format("{}{}", line.empty() ? "" : ",", csv::quoted(r[key].get<std::string>()));
    text += line;
    text += '\n';
  }
  write_atomically(path, text);
}

void print_verdicts(const Json& json) {
  for (const auto& r : json["rows"])
    fmt::print("{:<12} {:<9} -> {:<9} {:>9} +- {:<8} {}: {}\n", r["number"].get<std::string>(),
               r["base"].get<std::string>(), r["changed"].get<std::string>(), r["change"].get<std::string>(),
               r["uncertainty"].get<std::string>(), r["axis"].get<std::string>(), r["verdict"].get<std::string>());
  for (const auto& line : json["lines"]) fmt::print("{}\n", line.get<std::string>());
}

}  // namespace

CLI::App* add_credibility(CLI::App& app, CredibilityRequest& request) {
  CLI::App* word = app.add_subcommand(
      "credibility", "how far a scenario's numbers depend on step, stiffness, radius, bin, packing and coupling");
  word->footer(
      "Says first what it will cost. Every finished run is kept in the folder: the same command goes on where it was\n"
      "stopped. What the verdicts mean: docs/reference/credibility.md");
  word->add_option("scenario", request.scenario, "scenario file (YAML)")->required()->type_name(takes_yaml);
  word->add_option("--set", request.sets, "override a value of the scenario: path=value (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
  word->add_option("--numbers", request.numbers,
                   "columns whose means are judged; default: draft and pull, else soil.draft, else every monitor")
      ->delimiter(',');
  word->add_option("--axes", request.axes,
                   "only these: step, stiffness, radius, bin, packing, coupling step; default: all")
      ->delimiter(',');
  word->add_option("--tolerance", request.tolerance, "share within which a number counts as converged")
      ->check(CLI::Range(1e-6, 1.0));
  word->add_option("--out", request.out, "folder; default: ./<name of the scenario>-credibility");
  word->add_option("--threads", request.threads, "cores of each run")->check(CLI::PositiveNumber);
  word->add_option("--at-once", request.at_once, "runs side by side at most; default: as many as the cores allow")
      ->check(CLI::PositiveNumber);
  word->add_flag("--cost", request.cost, "print what it would cost and run nothing");
  word->add_flag("--again", request.again, "run failed axes once more");
  return word;
}

int credibility_command(const CredibilityRequest& request) {
  const Loaded loaded = load_scenario(request.scenario, request.sets);
  Axes axes = credibility_axes(loaded);
  keep_axes(axes, request.axes);
  const Study study = study_of(request, loaded, axes);
  refuse_unknown_columns(study, [&](const SweepNumber&) { return request.scenario + ": --numbers"; });
  check_points(study, axes);
  const PoolOptions pool{request.threads, request.at_once};
  const std::filesystem::path folder =
      request.out.empty() ? std::filesystem::path(request.scenario).stem().string() + "-credibility" : request.out;
  const bool fresh = request.cost || !std::filesystem::exists(folder / "points");
  if (fresh) print_cost(request, axes, pool_places(usable_cores(), pool).size());
  if (request.cost) return exit_ok;
  const StudyLock lock(folder);
  if (!run_points(study, folder, open_points(study, folder, request.again), pool)) {
    fmt::print(stderr, "stopped; the same command continues from here\n");
    return exit_of(caught_signal());
  }
  const std::vector<PointResult> results = read_results(study, folder);
  write_tables(study, results, folder);
  Json data = sweep_json(study, results, {});
  data["credibility"] = credibility_json(axes, study, judge(axes, study, results, request.tolerance));
  write_verdicts(data["credibility"], folder / "credibility.csv");
  write_sweep_page(data, folder / "credibility.html");
  print_verdicts(data["credibility"]);
  fmt::print("{}\n", (folder / "credibility.html").string());
  return exit_ok;
}

}  // namespace subsoil::sim
