#include "libsim/studies/laboratory/jobs.hpp"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace subsoil::sim {

void run_jobs(std::size_t count, int threads, const std::function<void(std::size_t)>& work,
              const std::function<void(std::size_t)>& done) {
  std::mutex guard;
  std::size_t next = 0, finished = 0, failed_index = count;
  std::exception_ptr failed;
  const auto worker = [&] {
    for (;;) {
      std::size_t index = 0;
      {
        const std::lock_guard lock(guard);
        if (next == count || failed) return;
        index = next++;
      }
      try {
        work(index);
        const std::lock_guard lock(guard);
        if (done) done(++finished);
      } catch (...) {
        const std::lock_guard lock(guard);
        if (index < failed_index) failed_index = index, failed = std::current_exception();
      }
    }
  };
  const std::size_t wished = threads > 0 ? static_cast<std::size_t>(threads) : std::thread::hardware_concurrency();
  std::vector<std::jthread> team;
  for (std::size_t k = 0; k < std::clamp<std::size_t>(wished, 1, std::max<std::size_t>(count, 1)); ++k)
    team.emplace_back(worker);
  team.clear();  // joins
  if (failed) std::rethrow_exception(failed);
}

}  // namespace subsoil::sim
