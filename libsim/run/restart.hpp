#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/io/run_writer.hpp"
#include "libsim/run/energy_start.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// What the results in the folder had come to when a state was written: what a run that continues there appends to.
struct RunProgress {
  Archive sums;                    ///< means, extremes, windows, schedules (Runner)
  std::uint64_t series_bytes = 0;  ///< of series.csv
  WrittenFrames frames;
  ParticleTable particles;                  ///< of the frames
  std::optional<EnergyStart> energy_start;  ///< that the summary's energies count from; none: not yet known
  bool exact = true;                        ///< a run that continues from here has the same bits
};

/// A run's full state: bed with contact histories, machine with its past and ruts, coupling, datum of the container.
struct SavedRun {
  dem::Bed::State bed;
  std::shared_ptr<const dem::MovingBed> moving;  ///< null: there is none
  std::vector<dem::InletState> inlets;           ///< in the order of the scenario
  std::optional<mbd::Snapshot> machine;          ///< none: there is none
  coupling::ExchangeState exchange;
  SoilReport soil;
  double container_shift = 0;
  double time = 0;       ///< s
  std::string scenario;  ///< explicit text of the one that wrote it; empty: of a version that did not keep it
  std::string begun_by;  ///< text of the one whose drivers began the run; empty: the same
  bool has_bed = false;
  double soil_step = 0;         ///< s; 0 without a bed
  std::string version, kernel;  ///< of the program, and its instruction set
  bool exact = true;
  std::optional<RunProgress> progress;
};

/// The state as it is now, in memory, without the scenario's text and the run's progress.
/// @param checkpoint takes the bed, whose arrays stay empty; null: they are filled
SavedRun take_state(const World& world, const coupling::Simulation& simulation,
                    dem::Bed::Checkpoint* checkpoint = nullptr);

/// Writes a state, complete or not at all. Throws DiskFault.
void write_run(const std::filesystem::path& path, const SavedRun& saved);
void save_run(const std::filesystem::path& path, const Scenario& scenario, const std::string& begun_by,
              const World& world, const coupling::Simulation& simulation, const RunProgress& progress);

/// A file that is no state, a damaged one, or one of another format; what() begins with its name.
struct StateFault : std::runtime_error {
  StateFault(std::filesystem::path its_file, const std::string& text)
      : std::runtime_error(text), file(std::move(its_file)) {}
  std::filesystem::path file;
};

/// Throws StateFault.
SavedRun read_run(const std::filesystem::path& file);

/// Throws ScenarioError when the state has soil or a machine and the scenario has not, or the other way round.
void refuse_other(const SavedRun& saved, const Scenario& scenario, const std::filesystem::path& file);

/// The saved spheres as a bed maker would give them.
std::vector<dem::SphereSpec> spheres_of(const SavedRun& saved);

/// Puts a world built from the same scenario (without soil placed) into the saved state.
/// @param checkpoint of this world's bed; null: the bed is taken from the arrays
void restore(const SavedRun& saved, World& world, coupling::Simulation& simulation,
             const dem::Bed::Checkpoint* checkpoint = nullptr);

}  // namespace subsoil::sim
