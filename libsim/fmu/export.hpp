#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace subsoil::sim {

struct FmuRequest {
  std::string scenario;
  std::vector<std::string> sets;  ///< path=value
  std::filesystem::path out;
  std::filesystem::path library;  ///< the shared object that goes into the FMU
  int version = 3;                ///< of FMI: 2 or 3
  std::optional<double> step;     ///< s, of communication; the soil step divides it
  std::vector<std::string> tools, parameters, forces_on;
  int threads = 0;
};

struct FmuReport {
  std::size_t inputs = 0, outputs = 0, parameters = 0, spheres = 0;
  std::vector<std::string> tools;
  std::vector<std::string> warnings;  ///< of the scenario, as `subsoil check` prints them
  double step = 0, soil_step = 0;     ///< s; 0: no soil
  std::uintmax_t bytes = 0;
};

/// Builds the scenario, prepares its bed, and writes the FMU. Throws ScenarioError and std::invalid_argument for what
/// the request names wrongly.
FmuReport write_fmu(const FmuRequest& request);

}  // namespace subsoil::sim
