#include "apps/commands/design_command.hpp"

#include <fmt/format.h>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/plan_columns.hpp"
#include "apps/commands/plan_options.hpp"
#include "libsim/base/signals.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/studies/design/optimum.hpp"
#include "libsim/studies/design/sensitivity.hpp"

namespace subsoil::sim {
namespace {

CLI::App* add_design(CLI::App& app, DesignRequest& request, const char* name, const char* meaning) {
  CLI::App* word = app.add_subcommand(name, meaning);
  word->footer(
      "Every finished run is kept in the folder: the same command continues where it was stopped. Keys of the plan:\n"
      "docs/reference/keys.md; methods: docs/reference/optimise.md");
  add_plan_options(*word, request, "scenario, parameters, numbers");
  word->add_option("--threads", request.threads, "cores of each run; default: that of the plan")
      ->check(CLI::Range(1, 1024));
  return word;
}

/// Runs a study of a plan in its folder, then writes what it found; `find` gets the study and the folder.
template <class Plan, class Find>
int study_in_folder(const DesignRequest& request, const Plan& plan, Find find) {
  const std::filesystem::path folder =
      request.out.empty() ? std::filesystem::path(request.plan).stem() : std::filesystem::path(request.out);
  const StudyLock lock(folder);
  refuse_unknown_columns(request.plan, study_of(plan));
  const auto threads = request.threads > 0 ? request.threads : static_cast<int>(plan.threads);
  GrowingStudy study(study_of(plan), folder, {threads, static_cast<int>(plan.at_once.value_or(0))});
  try {
    find(study, folder);
  } catch (const StudyInterrupted&) {
    fmt::print(stderr, "stopped; the same command continues from here\n");
    return exit_of(caught_signal());
  }
  return exit_ok;
}

}  // namespace

CLI::App* add_optimise(CLI::App& app, DesignRequest& request) {
  return add_design(app, request, "optimise", "find the design of a scenario that makes a number least or largest");
}

CLI::App* add_sensitivity(CLI::App& app, DesignRequest& request) {
  return add_design(app, request, "sensitivity", "derivatives of a run's numbers with respect to its parameters");
}

int optimise_command(const DesignRequest& request) {
  const OptimisePlan plan = load_optimise(request.plan, request.sets);
  bool found_one = false;
  const int code = study_in_folder(request, plan, [&](GrowingStudy& study, const std::filesystem::path& folder) {
    const Optimum found = find_optimum(plan, study);
    write_optimum(plan, found, study, folder);
    fmt::print("{}", optimum_text(plan, found, study));
    found_one = found.best && found.rows[*found.best].feasible;
    fmt::print("{}\n", (folder / (found.best ? "best.yaml" : "optimise.csv")).string());
  });
  return code == exit_ok && !found_one ? exit_failed : code;
}

int sensitivity_command(const DesignRequest& request) {
  const SensitivityPlan plan = load_sensitivity(request.plan, request.sets);
  return study_in_folder(request, plan, [&](GrowingStudy& study, const std::filesystem::path& folder) {
    const Sensitivity found = find_sensitivity(plan, study);
    write_sensitivity(plan, found, folder);
    fmt::print("{}{}\n", sensitivity_text(plan, found), (folder / "sensitivity.csv").string());
  });
}

}  // namespace subsoil::sim
