#include "apps/commands/sweep_command.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/plan_columns.hpp"
#include "apps/commands/plan_options.hpp"
#include "libsim/base/signals.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/sweep/slurm.hpp"
#include "libsim/studies/sweep/tables.hpp"

namespace subsoil::sim {
namespace {

using Best = std::optional<std::pair<std::size_t, bool>>;

Study study_of(const SweepRequest& request, const SweepPlan& plan) {
  Study study;
  study.title = plan.title.empty() ? std::filesystem::path(request.plan).stem().string() : plan.title;
  study.scenario = plan.scenario;
  for (const SweepParameter& p : plan.parameters) {
    if (p.seeds) study.packings = study.parameters.size();
    study.parameters.push_back(p.name);
  }
  study.points = sweep_points(request.plan, plan);
  study.numbers = plan.numbers.empty() ? usual_numbers(load_scenario(plan.scenario, study.points.front().sets).scenario)
                                       : plan.numbers;
  study.keep = plan.keep;
  return study;
}

Best best_of(const SweepPlan& plan, const Study& study) {
  if (plan.best.empty()) return {};
  const std::size_t blank = plan.best.find(' ');
  for (std::size_t n = 0; n < study.numbers.size(); ++n)
    if (study.numbers[n].name == plan.best.substr(blank + 1))
      return std::pair{n, plan.best.substr(0, blank) == "largest"};
  return {};
}

void write_all(const Study& study, const Best& best, const std::filesystem::path& folder) {
  const std::vector<PointResult> results = read_results(study, folder);
  write_tables(study, results, folder);
  write_sweep_page(sweep_json(study, results, best), folder / "sweep.html");
  fmt::print("{}{}\n", sweep_text(study, results, best), (folder / "sweep.html").string());
}

int submit(const SweepRequest& request, const SweepPlan& plan, const Study& study,
           const std::filesystem::path& folder) {
  const std::vector<std::size_t> open = open_points(study, folder, request.again);
  if (open.empty()) {
    fmt::print("all points are done\n");
    return exit_ok;
  }
  const auto scripts = write_slurm({.name = folder.stem().string(),
                                    .plan = std::filesystem::absolute(request.plan).string(),
                                    .sets = request.sets,
                                    .folder = std::filesystem::absolute(folder),
                                    .points = open,
                                    .threads = static_cast<int>(plan.threads),
                                    .at_once = static_cast<int>(plan.at_once.value_or(0))});
  if (request.dry) {
    fmt::print("{} tasks: {}, {}\n", open.size(), scripts[0].string(), scripts[1].string());
    return exit_ok;
  }
  const std::vector<std::string> jobs = submit_slurm(scripts);
  fmt::print("{} tasks in job {}; the table follows in job {}\n", open.size(), jobs[0], jobs[1]);
  return exit_ok;
}

}  // namespace

CLI::App* add_sweep(CLI::App& app, SweepRequest& request) {
  CLI::App* word = app.add_subcommand("sweep", "run a scenario over values of its keys, side by side or by Slurm");
  word->footer(
      "Every finished point is kept in the folder: the same command continues where it was stopped. Keys of the plan:\n"
      "docs/reference/keys.md; how to read the page: docs/reference/sweep.md");
  add_plan_options(*word, request, "scenario, parameters, numbers");
  word->add_flag("--again", request.again, "run failed points once more");
  CLI::Option* slurm = word->add_flag("--slurm", request.slurm, "submit a job array, a task per point");
  word->add_flag("--dry", request.dry, "with --slurm: write the scripts and submit nothing")->needs(slurm);
  word->add_flag("--gather", request.gather, "run nothing: write table and page of what is there")->excludes(slurm);
  word->add_option("--point", request.point, "run one point alone, counted from 0: a task of a job array")
      ->check(CLI::NonNegativeNumber)
      ->excludes(slurm);
  return word;
}

int sweep_command(const SweepRequest& request) {
  const SweepPlan plan = load_sweep(request.plan, request.sets);
  const Study study = study_of(request, plan);
  const std::filesystem::path folder =
      request.out.empty() ? std::filesystem::path(request.plan).stem() : std::filesystem::path(request.out);
  const PoolOptions pool{static_cast<int>(plan.threads), static_cast<int>(plan.at_once.value_or(0))};
  if (request.point >= 0) {  // no lock: the tasks of an array work side by side, each in its own point
    if (request.point >= static_cast<long>(study.points.size()))
      throw std::invalid_argument(
          fmt::format("--point {}: the plan has {} points, counted from 0", request.point, study.points.size()));
    return run_points(study, folder, {static_cast<std::size_t>(request.point)}, pool) ? exit_ok : exit_terminated;
  }
  const StudyLock lock(folder);
  if (request.slurm) return submit(request, plan, study, folder);
  const std::vector<std::size_t> open =
      request.gather ? std::vector<std::size_t>{} : open_points(study, folder, request.again);
  if (!open.empty()) refuse_unknown_columns(request.plan, study);
  if (!run_points(study, folder, open, pool)) {
    fmt::print(stderr, "stopped; the same command continues from here\n");
    return exit_of(caught_signal());
  }
  write_all(study, best_of(plan, study), folder);
  return exit_ok;
}

}  // namespace subsoil::sim
