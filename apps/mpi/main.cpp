#include <mpi.h>
#include <spdlog/spdlog.h>
#include <stdlib.h>

#include <csignal>
#include <cstdio>
#include <exception>

#include "apps/commands/commands.hpp"
#include "apps/mpi/engine.hpp"
#include "libsim/base/memory.hpp"

/// subsoil-mpi: the program `subsoil` with an engine on many processes. A program of its own, under the GPL of
/// LIGGGHTS, which it links; `subsoil` goes on as it where a scenario says `engine: liggghts`.
namespace {

[[gnu::constructor(101)]] void wait_passively() { setenv("OMP_WAIT_POLICY", "passive", 0); }

/// A rank that only serves: rank 0 speaks, and obeys signals.
int serve_quietly() {
  std::signal(SIGINT, SIG_IGN), std::signal(SIGTERM, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // as rank 0 does
  spdlog::set_level(spdlog::level::off);
  try {
    subsoil::mpi::serve(MPI_COMM_WORLD);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "failed: %s\n", error.what());
    MPI_Abort(MPI_COMM_WORLD, subsoil::sim::exit_failed);
    return subsoil::sim::exit_failed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  subsoil::sim::recycle_arrays();
  int rank = 0, code = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) {
    code = subsoil::sim::main_command(argc, argv, [](const auto& request, const auto& loaded, const auto& world) {
      return subsoil::mpi::make_engine(MPI_COMM_WORLD, request, loaded, world);
    });
    subsoil::mpi::dismiss(MPI_COMM_WORLD);
  } else {
    code = serve_quietly();
  }
  MPI_Finalize();
  return code;
}
