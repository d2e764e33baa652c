#pragma once
#include <mpi.h>

#include <memory>
#include <string>

#include "libdem/bed_engine.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/setup/world.hpp"

/// Soil on many processes. Rank 0 runs the whole program, machine, series and summary, with a bed whose spheres this
/// engine steps; the others serve it (`serve`). One step is a broadcast of where boundaries stand, LIGGGHTS' messages
/// between neighbours, and a sum of wrenches and energies.
namespace subsoil::mpi {

/// On rank 0: the engine of a world that is built.
std::unique_ptr<dem::BedEngine> make_engine(MPI_Comm all, const sim::RunRequest& request, const sim::Loaded& loaded,
                                            const sim::World& world);
/// On rank 0: nothing more will come.
void dismiss(MPI_Comm all);
/// On the other ranks: does what rank 0 orders until it is dismissed.
void serve(MPI_Comm all);

}  // namespace subsoil::mpi
