#include "libsim/run/settling_checkpoint.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "libsim/base/version.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/bed_state_file.hpp"
#include "libsim/io/old_results.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/continuation.hpp"

namespace subsoil::sim {
namespace {

constexpr std::int64_t kSettlingFormat = 4;

std::filesystem::path settling_file(const std::filesystem::path& folder) { return folder / "settling.h5"; }

bool changes_physics(const std::string& before, const std::string& now) {
  const std::vector<Difference> found = differences(before, now);
  return std::any_of(found.begin(), found.end(),
                     [](const Difference& d) { return d.kind != Difference::Kind::harmless; });
}

}  // namespace

std::optional<SavedSettling> SettlingCheckpoint::read() const {
  const std::filesystem::path file = settling_file(folder_);
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const StateReader in(file);
    in.require_format(kSettlingFormat, {"bed/", "settling/", "scenario", "version", "instruction set"});
    if (changes_physics(in.text("scenario"), scenario_)) {
      spdlog::warn("warning: {} is of another scenario: the bed settles from the start", file.string());
      return std::nullopt;
    }
    dem::SettleState state;
    Archive settling = in.archive("settling");
    state.archive(settling);
    settling.end();
    state.bed = bed_state_of(in);
    return SavedSettling{std::move(state), in.text("version"), in.text("instruction set")};
  } catch (const std::exception& error) {
    spdlog::warn("warning: {}: {}; the bed settles from the start", file.string(), error.what());
    return std::nullopt;
  }
}

void SettlingCheckpoint::keep(const dem::SettleState& state, const std::string& instruction_set) {
  if (!std::exchange(begun_, true)) {
    remove_results(folder_, {});
    write_atomically(folder_ / "scenario.yaml", scenario_);
  }
  StateWriter out(settling_file(folder_));
  out.put_format(kSettlingFormat);
  out.put_text("scenario", scenario_);
  out.put_text("version", version());
  out.put_text("instruction set", instruction_set);
  Archive settling;
  const_cast<dem::SettleState&>(state).archive(settling);  // to write changes nothing
  out.put("settling", settling);
  put_bed_state(out, state.bed);
  out.commit();
  clock_.restart();
}

void SettlingCheckpoint::remove(const std::filesystem::path& folder) {
  std::error_code ignored;
  std::filesystem::remove(settling_file(folder), ignored);
}

}  // namespace subsoil::sim
