#include <spdlog/spdlog.h>
#include <stdlib.h>

#include <chrono>
#include <iostream>
#include <sstream>
#include <string_view>
#include <thread>

#include "apps/commands/commands.hpp"
#include "libsim/base/memory.hpp"

namespace {

/// Threads that wait for each other sleep instead of spinning, unless the user says otherwise. On a machine with other
/// work spinning costs a run most of its time; on a quiet one sleeping costs nothing that can be measured
/// (docs/performance.md). OpenMP reads the word once, when its library is initialised: this comes before, since the
/// library is linked into the program and other constructors have no priority.
[[gnu::constructor(101)]] void wait_passively() { setenv("OMP_WAIT_POLICY", "passive", 0); }

/// Whether `mpirun` started this process beside a first one, which reads the same files and says the same of them.
bool stands_beside_the_first() {
  const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");
  return rank != nullptr && std::string_view(rank) != "0";
}

}  // namespace

int main(int argc, char** argv) {
  subsoil::sim::recycle_arrays();
  if (!stands_beside_the_first()) return subsoil::sim::main_command(argc, argv);
  std::ostringstream kept;
  std::streambuf* const speaks = std::cerr.rdbuf(kept.rdbuf());
  spdlog::set_level(spdlog::level::off);
  const int code = subsoil::sim::main_command(argc, argv);
  std::cerr.rdbuf(speaks);
  if (code == subsoil::sim::exit_ok) return code;
  // A fault of the files is the first process's to say, whose end ends this one. One that is still here after that has
  // a fault of its own, such as a program that its node lacks.
  std::this_thread::sleep_for(std::chrono::seconds(10));
  std::cerr << kept.str();
  return code;
}
