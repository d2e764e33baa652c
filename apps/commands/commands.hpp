#pragma once
#include <string>
#include <vector>

#include "libsim/run/runner.hpp"

/// The words of the command line; each returns the exit code of the program.
namespace subsoil::sim {

/// `subsoil check`: reads, builds and tries a scenario, prints what would run and what it would cost; writes nothing.
int check_command(const RunRequest& request);
/// `subsoil impact`: one impact by a model, at one speed or several, or its parameters from measurements.
struct ImpactRequest {
  std::vector<std::string> words;  ///< a file at most, and `--key value` of any key of a study
  std::vector<std::string> sets;   ///< path=value
  std::string out;                 ///< folder for results; empty: print only
  std::string pictures = "svg";    ///< kind of the pictures: svg, png, pdf
  std::string data;                ///< measurements to fit to
  std::vector<std::string> free;   ///< parameters that a fit may move; empty: those the data tell of
};
int impact_command(const ImpactRequest& request);
/// `subsoil test`: an laboratory test of a scenario's material.
struct TestRequest {
  std::string test, scenario;
  std::vector<std::string> sets;  ///< path=value
  std::string out;                ///< folder for results; empty: print only
  std::string pictures = "svg";   ///< kind of the pictures: svg, png, pdf
  int threads = 0;                ///< specimens side by side; 0: all cores
};
int test_command(const TestRequest& request);
/// `subsoil calibrate`: parameters of a scenario that meet measured results of laboratory tests.
struct CalibrateRequest {
  std::string plan;
  std::vector<std::string> sets;  ///< path=value
  std::string out;                ///< folder, also of what an earlier run has done; empty: named like the plan
  std::string pictures = "svg";   ///< kind of the pictures: svg, png, pdf
  int threads = 0;                ///< specimens side by side; 0: all cores
};
int calibrate_command(const CalibrateRequest& request);
/// The whole program.
int main_command(int argc, char** argv, const EngineMaker& engine = {});

/// What a run is expected to cost.
struct Estimate {
  double seconds_per_step = 0;
  double wall_time = 0;          ///< s, settling included
  double memory = 0;             ///< bytes
  double memory_of_program = 0;  ///< of these, before bed and machine are there
  double disk = 0;               ///< bytes
  long steps = 0, frames = 0;
};
Estimate estimate(const RunRequest& request);

}  // namespace subsoil::sim
