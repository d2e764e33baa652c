#include "apps/commands/fmu_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "apps/commands/command_pages.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/run/runner.hpp"

namespace subsoil::sim {
namespace {

namespace fs = std::filesystem;

/// The shared object beside the program, or where it is installed.
fs::path library_of_fmus() {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path places[] = {folder / "fmu" / "subsoil_fmu.so", folder / SUBSOIL_FMU_FOLDER / "subsoil_fmu.so"};
  for (const fs::path& place : places)
    if (fs::exists(place)) return place.lexically_normal();
  throw std::runtime_error(
      fmt::format("{}: is not there; it goes into every FMU: build the target `subsoil_fmu`, or install the program "
                  "again",
                  places[1].lexically_normal().string()));
}

}  // namespace

CLI::App* add_fmu(CLI::App& app, FmuWords& words) {
  CLI::App* word =
      app.add_subcommand("fmu", "write a co-simulation FMU of soil, or of a machine, for other simulators");
  word->footer(
      "A scenario without machine gives an FMU of soil: motions of its boundaries are inputs, wrenches outputs. One "
      "with a machine gives drivers, set points and valves as inputs, monitors and bodies as outputs.\n"
      "How to use it: docs/reference/fmu.md");
  FmuRequest& r = words.request;
  word->add_option("scenario", r.scenario, "scenario file (YAML)")->required()->type_name(takes_yaml);
  word->add_option("--out", r.out, "the FMU; default: NAME.fmu of the scenario")->type_name("FILE");
  word->add_option("--fmi", words.version, "version of the Functional Mock-up Interface")
      ->check(CLI::IsMember({"2", "3"}));
  word->add_option("--step", words.step,
                   "communication step, such as \"1 ms\"; the soil step divides it; default: "
                   "about 20 soil steps");
  const auto repeated = [&](const char* flag, std::vector<std::string>& list, const char* type, const char* text) {
    word->add_option(flag, list, text)->allow_extra_args(false)->type_name(type);
  };
  repeated("--tool", r.tools, "NAME",
           "boundary that the importer moves (may be repeated); default: all without a machine, none with one");
  repeated("--parameter", r.parameters, "KEY", "key of the scenario that becomes a parameter (may be repeated)");
  repeated("--force-on", r.forces_on, "BODY", "body of the machine that takes a force as input (may be repeated)");
  repeated("--set", r.sets, "PATH=VALUE", "override a value of the scenario: path=value (may be repeated)");
  word->add_option("--threads", r.threads, "threads of the bed while it settles; default: as `subsoil run`")
      ->check(CLI::Range(1, 1024));
  return word;
}

int fmu_command(const FmuWords& words) {
  FmuRequest request = words.request;
  request.version = words.version == "2" ? 2 : 3;
  if (request.out.empty()) request.out = fs::path(request.scenario).stem().string() + ".fmu";
  if (!words.step.empty()) try {
      request.step = parse_quantity(words.step, "s");
      if (!(*request.step > 0)) throw std::invalid_argument("must be above 0");
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("--step {}: {}", words.step, error.what()));
    }
  request.library = library_of_fmus();
  const FmuReport report = write_fmu(request);
  for (const std::string& warning : report.warnings) spdlog::warn("warning: {}", warning);
  fmt::print("{}: FMI {}.0, co-simulation, Linux x86-64, {:.1f} MB\n", request.out.string(), request.version,
             static_cast<double>(report.bytes) * 1e-6);
  if (report.spheres > 0) fmt::print("soil: {} spheres, soil step {:.6g} s\n", report.spheres, report.soil_step);
  if (!report.tools.empty()) fmt::print("tools: {}\n", fmt::join(report.tools, ", "));
  fmt::print("{} inputs, {} outputs, {} parameters; communication step {:.6g} s\n", report.inputs, report.outputs,
             report.parameters, report.step);
  return exit_ok;
}

}  // namespace subsoil::sim
