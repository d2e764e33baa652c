#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "libsim/run/runner.hpp"

namespace subsoil::sim {

struct SweepRequest {
  std::string plan;
  std::vector<std::string> sets;  ///< path=value of the plan
  std::string out;                ///< folder; empty: named like the plan
  bool slurm = false, dry = false, again = false, gather = false;
  long point = -1;  ///< run this one alone, counted from 0: what a job of an array does
};
CLI::App* add_sweep(CLI::App& app, SweepRequest& request);
int sweep_command(const SweepRequest& request);

struct CredibilityRequest {
  std::string scenario;
  std::vector<std::string> sets;
  std::string out;  ///< folder; empty: NAME-credibility
  bool cost = false, again = false;
  int threads = 1, at_once = 0;
  double tolerance = 0.05;
  std::vector<std::string> numbers;  ///< columns whose means are judged
  std::vector<std::string> axes;     ///< words that axes to run begin with; empty: all
};
CLI::App* add_credibility(CLI::App& app, CredibilityRequest& request);
int credibility_command(const CredibilityRequest& request);

}  // namespace subsoil::sim
