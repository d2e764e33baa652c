#include <fmt/format.h>

#include "apps/commands/commands.hpp"
#include "libsim/studies/calibrate/calibration.hpp"
#include "libsim/studies/laboratory/report.hpp"
#include "libsim/studies/sweep/study.hpp"

namespace subsoil::sim {
namespace {

/// "7  mu 0.43  mu_r 0.1   repose.angle 31.2"
std::string line_of(const Plan& plan, const Evaluation& e, std::size_t number) {
  std::string line = fmt::format("{:>3} ", number);
  for (std::size_t k = 0; k < plan.parameters.size(); ++k)
    line += fmt::format(" {} {:<8.4g}", plan.parameters[k].name, e.parameters[k]);
  if (!e.complete()) return line + "  " + e.failure;
  for (std::size_t k = 0; k < plan.targets.size(); ++k) {
    const HandyUnit handy = handy_unit(plan.targets[k].unit, e.found[k]);
    line += fmt::format("  {} {:.4g} {} (standard error {:.2g})", plan.targets[k].name(), e.found[k] * handy.factor,
                        handy.unit == "1" ? "" : handy.unit, e.error[k] * handy.factor);
  }
  return line;
}

}  // namespace

int calibrate_command(const CalibrateRequest& request) {
  const Plan plan = load_plan(request.plan, request.sets);
  const std::filesystem::path folder =
      request.out.empty() ? std::filesystem::path(request.plan).stem() : std::filesystem::path(request.out);
  const StudyLock lock(folder);
  const Calibrated found =
      calibrate(plan, folder / "evaluations.csv", request.threads,
                [&](const Evaluation& e, std::size_t number) { fmt::print(stderr, "{}\n", line_of(plan, e, number)); });
  write_calibration(plan, found, folder, request.pictures);
  fmt::print("{}\n{}\n", calibration_text(plan, found), folder.string());
  return exit_ok;
}

}  // namespace subsoil::sim
