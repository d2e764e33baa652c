#include <stdlib.h>
#include <unistd.h>

#include "apps/commands/commands.hpp"
#include "apps/memory.hpp"

namespace {

/// Threads that wait for each other sleep instead of spinning, unless the user says otherwise. On a machine with other
/// work spinning costs a run most of its time; on a quiet one sleeping costs nothing that can be measured
/// (docs/performance.md). OpenMP reads the word once, when the program is loaded: so it starts itself anew.
void wait_passively(char** argv) {
  if (getenv("OMP_WAIT_POLICY") != nullptr) return;
  setenv("OMP_WAIT_POLICY", "passive", 1);
  execv("/proc/self/exe", argv);  // where this fails the program goes on as it is
}

}  // namespace

int main(int argc, char** argv) {
  wait_passively(argv);
  subsoil::app::recycle_arrays();
  return subsoil::app::main_command(argc, argv);
}
