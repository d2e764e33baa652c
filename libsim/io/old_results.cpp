#include "libsim/io/old_results.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "libsim/io/disk.hpp"

namespace subsoil::sim {
namespace {

/// Names of what is in the folder, in order: a folder's own order is another one on each disk.
std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

void remove_or_refuse(const std::filesystem::path& path) {
  std::error_code fault;
  std::filesystem::remove_all(path, fault);
  if (fault) refuse_write(path, fault.value());
}

}  // namespace

void remove_results(const std::filesystem::path& folder, const std::filesystem::path& keep) {
  const auto is_kept = [&](const std::filesystem::path& path) {
    std::error_code ignored;
    return !keep.empty() && std::filesystem::equivalent(path, keep, ignored);
  };
  // In this order, so that a resume after a kill in between never takes the rest for a run that has ended, or for one
  // that a state continues.
  remove_or_refuse(folder / "summary.json");
  remove_frames_and_states(folder, is_kept);
  for (const std::string& name : names_in(folder))
    if (name == "series.csv" || name.ends_with(".part")) remove_or_refuse(folder / name);
}

void remove_frames_and_states(const std::filesystem::path& folder,
                              const std::function<bool(const std::filesystem::path&)>& is_kept) {
  for (const std::string& name : names_in(folder)) {
    const bool state = (name.starts_with("state-") || name.starts_with("checkpoint-")) && name.ends_with(".h5");
    if (state && !(is_kept && is_kept(folder / name))) remove_or_refuse(folder / name);
  }
  for (const char* name : {"run.xdmf2", "run.xdmf", "run.h5", "frames"}) remove_or_refuse(folder / name);
}

}  // namespace subsoil::sim
