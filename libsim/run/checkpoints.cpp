#include "libsim/run/checkpoints.hpp"

#include <vector>

#include "libsim/io/state_file.hpp"
#include "libsim/run/resume.hpp"
#include "libsim/run/settling_checkpoint.hpp"

namespace subsoil::sim {
namespace {

double interval = 600;  // s

/// Of a folder, the latest first.
std::vector<std::filesystem::path> checkpoints_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> out;
  for (const std::filesystem::path& file : states_in(folder))
    if (file.filename().string().starts_with("checkpoint-")) out.push_back(file);
  return out;
}

}  // namespace

void set_checkpoint_interval(double seconds) { interval = seconds; }

bool CheckpointClock::due() const {
  return interval > 0 && std::chrono::duration<double>(Clock::now() - last_).count() >= interval;
}

std::filesystem::path Checkpoints::next(double time) const { return checkpoint_path(folder_, time); }

void Checkpoints::keep_two() {
  clock_.restart();
  SettlingCheckpoint::remove(folder_);
  const std::vector<std::filesystem::path> found = checkpoints_in(folder_);
  std::error_code ignored;
  for (std::size_t k = 2; k < found.size(); ++k) std::filesystem::remove(found[k], ignored);
}

void Checkpoints::remove() const {
  std::error_code ignored;
  std::vector<std::filesystem::path> all;  // with those that a kill left half written
  for (const auto& entry : std::filesystem::directory_iterator(folder_, ignored))
    if (entry.path().filename().string().starts_with("checkpoint-")) all.push_back(entry.path());
  for (const std::filesystem::path& file : all) std::filesystem::remove(file, ignored);
  SettlingCheckpoint::remove(folder_);
}

}  // namespace subsoil::sim
