#include <stdlib.h>

#include "apps/commands/commands.hpp"
#include "apps/memory.hpp"

namespace {

/// Threads that wait for each other sleep instead of spinning, unless the user says otherwise. On a machine with other
/// work spinning costs a run most of its time; on a quiet one sleeping costs nothing that can be measured
/// (docs/performance.md). OpenMP reads the word once, when its library is initialised: this comes before, since the
/// library is linked into the program and other constructors have no priority.
[[gnu::constructor(101)]] void wait_passively() { setenv("OMP_WAIT_POLICY", "passive", 0); }

}  // namespace

int main(int argc, char** argv) {
  subsoil::app::recycle_arrays();
  return subsoil::app::main_command(argc, argv);
}
