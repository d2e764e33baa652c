#pragma once
#include <filesystem>

#include "libsim/run/runner.hpp"

namespace subsoil::sim {

/// Continues the run whose results are in a folder, from the latest of its states and checkpoints that is whole, and
/// ends as the run would have ended that was never stopped, to the last bit. Without one it restarts. Throws
/// ScenarioError when the folder holds no run. `threads`, `sets` of no physics and `strict` of the request count.
int resume(const std::filesystem::path& folder, const RunRequest& request);

/// Of all runs of this process, wall time, s: from one checkpoint to the next; 0: none. 600 unless set.
void set_checkpoint_interval(double seconds);

}  // namespace subsoil::sim
