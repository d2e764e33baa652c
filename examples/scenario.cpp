// Runs a scenario file from a program of one's own, with another speed, and reads its summary.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "libsim/run/runner.hpp"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::filesystem::path out = std::filesystem::temp_directory_path() / "subsoil-example-scenario";
  subsoil::sim::RunRequest request;
  request.scenario = argv[1];
  request.out = out;
  request.force = true;
  request.sets = {"boundaries.plate.moves.0.velocity=0 -0.1 0 m/s"};
  const int code = subsoil::sim::run(request);
  if (code != subsoil::sim::exit_ok) return code;
  const nlohmann::json summary = nlohmann::json::parse(std::ifstream(out / "summary.json"));
  std::printf("ended: %s\n", summary.dump().substr(0, 200).c_str());
  return summary.empty() ? 1 : 0;
}
