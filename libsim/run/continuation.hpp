#pragma once
#include <string>
#include <vector>

#include "libsim/run/restart.hpp"
#include "libsim/setup/world.hpp"

/// Whether a run may continue from a state: how the scenario differs from the one that the state was written by.
namespace subsoil::sim {

struct Difference {
  enum class Kind {
    harmless,   ///< changes no physics: end, output, limits, threads
    physics,    ///< a value that may change on the way, if it is wished for
    impossible  ///< what the state holds has been made by it
  };
  std::string key, before, now;  ///< texts of the explicit scenarios; empty: not there
  Kind kind;
};

/// Between two explicit scenarios (write_scenario), key by key.
std::vector<Difference> differences(const std::string& before, const std::string& now);

/// Throws ScenarioError that lists what stands in the way: impossible differences, and changes of physics that none of
/// `wished` names (a key, or one above it). A wish that nothing answers to is refused too.
void refuse_changes(const std::vector<Difference>& found, const std::vector<std::string>& wished,
                    const std::string& state);

/// Throws ScenarioError that lists what of the soil differs: the bed of the state was made by it. Machine, boundaries,
/// step and laws may differ.
void refuse_other_bed(const std::vector<Difference>& found, const std::string& state);

/// The explicit text of the scenario whose drivers began the run of the state.
const std::string& begun_by(const SavedRun& saved);

bool drivers_differ(const std::vector<Difference>& found);

/// Lets drivers that have another rate than the state was written with continue from the pose and the velocity there.
/// Throws ScenarioError where the machine of the scenario would jump in pose or velocity. `world` is not restored yet:
/// restoring closes constraints, whatever is open.
void continue_drivers(World& world, SavedRun& saved, const std::vector<Difference>& found, const std::string& state);

/// Throws ScenarioError when a given path stands elsewhere at the state's time than the state does: it would jump.
/// `world` is restored.
void refuse_surface_jumps(const World& world, double time, const std::string& state);

}  // namespace subsoil::sim
