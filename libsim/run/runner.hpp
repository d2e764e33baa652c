#pragma once
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libdem/sphere_force.hpp"
#include "libsim/io/series.hpp"

namespace subsoil::dem {
class BedEngine;
}

namespace subsoil::sim {

struct Loaded;
struct World;
struct RunRequest;

/// Makes what steps the spheres of a world that is built, in a program that has another engine than the bed itself.
using EngineMaker = std::function<std::unique_ptr<dem::BedEngine>(const RunRequest&, const Loaded&, const World&)>;

struct RunRequest {
  std::string scenario;
  std::filesystem::path out;      ///< empty: a directory named like the scenario, in the working directory
  std::vector<std::string> sets;  ///< path=value
  int threads = 0;                ///< 0: as in the scenario
  bool force = false;
  bool strict = false;                 ///< a run with warnings ends with exit_failed
  std::vector<std::string> changes{};  ///< keys that may differ from the scenario of `from`
  std::filesystem::path from{};        ///< a state file to start from; empty: from the beginning
  std::function<void(const std::filesystem::path&)> opened{};  ///< called when the folder has scenario and series
  /// Act on the spheres from the start of the run, not while a bed settles. A run that is continued needs them again.
  std::vector<dem::NamedSphereForce> sphere_forces{};
  EngineMaker engine{};  ///< none: scenarios that ask for another engine are refused
};

/// Exit codes of a run.
enum ExitCode { exit_ok = 0, exit_bad_input = 2, exit_failed = 3, exit_interrupted = 130, exit_terminated = 143 };
/// By the signal that has ended a run or a study; none: exit_ok.
inline ExitCode exit_of(int signal) {
  return signal == SIGINT ? exit_interrupted : signal == SIGTERM ? exit_terminated : exit_ok;
}

/// Places bed and machine, without settling, and lists the columns of the series; empty where what is placed meets
/// something that the settled bed may not. Throws ScenarioError for a monitor of a column that is not there.
std::vector<SeriesColumn> place_and_list_columns(const Loaded& loaded);

/// Runs a scenario to its end. Throws ScenarioError for bad input before anything is written.
int run(const RunRequest& request);

}  // namespace subsoil::sim
