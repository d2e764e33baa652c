#include "libsim/studies/sweep/pool.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "libsim/base/signals.hpp"

namespace subsoil::sim {
namespace {

using Clock = std::chrono::steady_clock;

struct Running {
  pid_t process = -1;  ///< -1: the place is free
  std::size_t job = 0;
  Clock::time_point start;
};

/// In the new process: never returns.
[[noreturn]] void become(const PoolJob& job, const std::vector<int>& cores, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(143);  // it died before the line above
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int core : cores) CPU_SET(static_cast<std::size_t>(core), &set);
  sched_setaffinity(0, sizeof set, &set);
  setenv("OMP_NUM_THREADS", std::to_string(cores.size()).c_str(), 1);
  const int log = open(job.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (log >= 0) dup2(log, STDOUT_FILENO), dup2(log, STDERR_FILENO);
  std::vector<char*> words;
  std::vector<std::string> all{"subsoil"};
  all.insert(all.end(), job.arguments.begin(), job.arguments.end());
  for (std::string& word : all) words.push_back(word.data());
  words.push_back(nullptr);
  execv("/proc/self/exe", words.data());
  _exit(127);
}

}  // namespace

std::vector<int> usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof set, &set) == 0)
    for (int core = 0; core < CPU_SETSIZE; ++core)
      if (CPU_ISSET(static_cast<std::size_t>(core), &set)) cores.push_back(core);
  return cores.empty() ? std::vector<int>{0} : cores;
}

std::vector<std::vector<int>> pool_places(const std::vector<int>& cores, const PoolOptions& options) {
  const auto each = static_cast<std::size_t>(std::max(1, options.threads));
  if (cores.size() < each) return {cores};
  std::size_t count = cores.size() / each;
  if (options.at_once > 0) count = std::min(count, static_cast<std::size_t>(options.at_once));
  std::vector<std::vector<int>> places(count);
  for (std::size_t k = 0; k < count * each; ++k) places[k / each].push_back(cores[k]);
  return places;
}

bool run_pool(const std::vector<PoolJob>& jobs, const PoolOptions& options,
              const std::function<void(std::size_t, const PoolEnd&)>& ended,
              const std::function<void(const std::vector<std::size_t>&)>& waiting) {
  const std::vector<std::vector<int>> places = pool_places(usable_cores(), options);
  const SignalGuard signals(SignalGuard::Second::waits);
  std::vector<Running> running(places.size());
  std::size_t next = 0;
  const auto any = [&] {
    return std::any_of(running.begin(), running.end(), [](const Running& r) { return r.process > 0; });
  };
  const auto start = [&](std::size_t place) {
    std::filesystem::create_directories(jobs[next].log.parent_path());
    const pid_t parent = getpid(), process = fork();
    if (process < 0) throw std::runtime_error("a run cannot be started: the system refuses another process");
    if (process == 0) become(jobs[next], places[place], parent);
    running[place] = {process, next++, Clock::now()};
  };
  const auto collect = [&](Running& r) {
    int status = 0;
    if (r.process <= 0 || waitpid(r.process, &status, WNOHANG) != r.process) return;
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    r.process = -1;
    if (caught_signal() == 0) ended(r.job, {code, std::chrono::duration<double>(Clock::now() - r.start).count()});
  };
  while (next < jobs.size() || any()) {
    for (std::size_t k = 0; k < places.size() && caught_signal() == 0; ++k)
      if (running[k].process <= 0 && next < jobs.size()) start(k);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    for (Running& r : running) collect(r);
    if (caught_signal() != 0) break;
    std::vector<std::size_t> now;
    for (const Running& r : running)
      if (r.process > 0) now.push_back(r.job);
    if (!now.empty() && waiting) waiting(now);
  }
  for (const Running& r : running)
    if (r.process > 0) kill(r.process, SIGTERM);
  for (const Running& r : running)
    if (r.process > 0) waitpid(r.process, nullptr, 0);
  return caught_signal() == 0;
}

}  // namespace subsoil::sim
