#pragma once
#include <mpi.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/mpi/rank.hpp"
#include "libdem/particles/particles.hpp"
#include "libsim/io/part_writer.hpp"

namespace subsoil::mpi {

/// Rows of a snapshot in rising id.
void sort_by_id(dem::Snapshot& s, std::vector<double>* density = nullptr);
/// Of all processes on rank 0, in rising id. Collective.
void gather_snapshot(dem::Snapshot& s, MPI_Comm all);

/// Spheres of frames on one process: those of the last two instants, and the file that they go to. Every process writes
/// what it had at the earlier of both; between them it asks the others only for those of its spheres that have gone to
/// them meanwhile. All members are collective.
class Parts {
 public:
  Parts(MPI_Comm all, const std::filesystem::path& directory, const sim::RunOptions& options, double quantum);

  /// A step of the rank, whose beginning is a new instant.
  dem::EngineSums step(Rank& rank, dem::EngineStep step);
  /// On rank 0 the XDMF of all parts. This and the next throw DiskFault there if any process fails.
  std::string write(const sim::PartPlace& place, const sim::Between& between);
  void publish();
  void drop() { writer_->drop(); }
  dem::Snapshot last_instant() const;  ///< the last instant, on rank 0
  /// The last instant is this, of rank 0.
  void restore(const dem::Snapshot& spheres, const Rank& rank);

 private:
  struct Instant {
    dem::Snapshot spheres;
    std::vector<double> density;  ///< kg/m3
  };
  dem::Snapshot between(const sim::Between& between) const;
  template <class Action>
  void together(const Action& action);

  MPI_Comm all_;
  std::optional<sim::PartWriter> writer_;
  Instant before_, now_;
};

}  // namespace subsoil::mpi
