#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace subsoil::sim {

/// A job array for Slurm: a task per point, then a job that gathers the table.
struct SlurmArray {
  std::string name, plan;           ///< plan: absolute path
  std::vector<std::string> sets;    ///< of the plan
  std::filesystem::path folder;     ///< absolute
  std::vector<std::size_t> points;  ///< tasks
  int threads = 1, at_once = 0;
};

/// "0-3,7,9-10"
std::string task_list(const std::vector<std::size_t>& points);
/// FOLDER/sweep.sbatch and gather.sbatch; returns both texts' paths.
std::vector<std::filesystem::path> write_slurm(const SlurmArray& array);
/// Hands both to sbatch, the second to follow the first; returns their job numbers. Throws std::invalid_argument when
/// there is no sbatch, std::runtime_error with its words when it refuses.
std::vector<std::string> submit_slurm(const std::vector<std::filesystem::path>& scripts);

}  // namespace subsoil::sim
