#pragma once
#include <cstddef>
#include <functional>

namespace subsoil::sim {

/// Calls work(0) ... work(count - 1) on so many threads (0: all cores), each index once, in no order; results must not
/// depend on it. `done` is called after each, one at a time. After a throw no new one begins; the exception of the
/// lowest index is thrown again.
void run_jobs(std::size_t count, int threads, const std::function<void(std::size_t)>& work,
              const std::function<void(std::size_t finished)>& done = {});

}  // namespace subsoil::sim
