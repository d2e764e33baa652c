#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "libdem/packing/settle.hpp"
#include "libsim/run/checkpoints.hpp"

namespace subsoil::sim {

/// What settling.h5 holds, and who wrote it.
struct SavedSettling {
  dem::SettleState state;
  std::string version, instruction_set;
};

/// A bed on its way to rest, DIR/settling.h5, written by wall time and when a signal ends the settling. A run that is
/// gone on with takes it up; it stays until the run has a checkpoint of its own. One file, written beside and renamed,
/// and the only one: an older one would only save less.
class SettlingCheckpoint {
 public:
  /// @param scenario what the bed is made of, as in scenario.yaml
  SettlingCheckpoint(std::filesystem::path folder, std::string scenario)
      : folder_(std::move(folder)), scenario_(std::move(scenario)) {}

  /// The one of the folder, if it is whole and of this scenario but for what changes no physics; reports why otherwise.
  std::optional<SavedSettling> read() const;
  bool due() const { return clock_.due(); }
  /// The first time also takes away the results of an earlier run and puts the scenario there, so that a folder never
  /// holds one run's scenario beside another's results.
  /// @param instruction_set of the bed's kernels
  void keep(const dem::SettleState& state, const std::string& instruction_set);

  static void remove(const std::filesystem::path& folder);

 private:
  std::filesystem::path folder_;
  std::string scenario_;
  CheckpointClock clock_;
  bool begun_ = false;
};

}  // namespace subsoil::sim
