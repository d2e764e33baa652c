#include <fmt/format.h>
#include <unistd.h>

#include "apps/commands/commands.hpp"
#include "libsim/studies/laboratory/report.hpp"
#include "libsim/studies/laboratory/tests.hpp"

namespace subsoil::sim {

int test_command(const TestRequest& request) {
  const LoadedTests loaded = load_tests(request.scenario, request.sets);
  const bool live = isatty(STDERR_FILENO) != 0;
  const Findings found = run_test(loaded, request.test, request.threads, [&](std::size_t done, std::size_t all) {
    if (live) fmt::print(stderr, "\r{} of {} specimens{}", done, all, done == all ? "\n" : "");
  });
  fmt::print("{}", findings_table(found));
  if (request.out.empty()) return exit_ok;
  write_findings(found, request.out, request.pictures);
  fmt::print("{}\n", request.out);
  return exit_ok;
}

}  // namespace subsoil::sim
