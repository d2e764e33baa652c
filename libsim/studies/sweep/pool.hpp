#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// Runs as processes of their own, side by side on cores that no two of them share.
namespace subsoil::sim {

struct PoolJob {
  std::vector<std::string> arguments;  ///< of this program, such as run till.yaml --out points/0001
  std::filesystem::path log;           ///< stdout and stderr
};

/// How a process ended.
struct PoolEnd {
  int code = 0;          ///< exit code; 128 + the signal when one ended it
  double wall_time = 0;  ///< s
};

struct PoolOptions {
  int threads = 1;  ///< cores of each process
  int at_once = 0;  ///< processes side by side at most; 0: as many as the cores allow
};

/// Cores that this process may use, which a batch system or taskset may have cut down.
std::vector<int> usable_cores();
/// The cores of each place in the pool: usable cores cut into stretches of `threads`; one place of all where they are
/// too few.
std::vector<std::vector<int>> pool_places(const std::vector<int>& cores, const PoolOptions& options);

/// Runs all jobs in their order. Each process is bound to the cores of its place, OMP_NUM_THREADS with it, and is ended
/// by the kernel when this process dies. `ended(job, end)` is called after each; `waiting(running)` several times a
/// second with the jobs that run. Returns false when SIGINT or SIGTERM came: running processes have then been asked to
/// end, and `ended` is not called for them.
bool run_pool(const std::vector<PoolJob>& jobs, const PoolOptions& options,
              const std::function<void(std::size_t job, const PoolEnd& end)>& ended,
              const std::function<void(const std::vector<std::size_t>& running)>& waiting);

}  // namespace subsoil::sim
