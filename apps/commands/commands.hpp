#pragma once
#include <string>
#include <vector>

#include "apps/run/runner.hpp"

/// The words of the command line; each returns the exit code of the program.
namespace subsoil::app {

/// `subsoil check`: reads, builds and tries a scenario, says what would run and what it would cost; writes nothing.
int check_command(const RunRequest& request);
/// The whole program.
int main_command(int argc, char** argv);

/// What a run is expected to cost.
struct Estimate {
  double seconds_per_step = 0;
  double wall_time = 0;  ///< s, settling included
  double memory = 0;     ///< bytes
  double disk = 0;       ///< bytes
  long steps = 0, frames = 0;
};
Estimate estimate(const RunRequest& request);

}  // namespace subsoil::app
