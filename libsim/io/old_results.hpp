#pragma once
#include <filesystem>
#include <functional>

namespace subsoil::sim {

/// Takes away what a run writes, and nothing else: series, summary, frames, states, checkpoints, parts of files. The
/// scenario stays until the new one takes its place.
/// @param keep a state that the new run starts from
void remove_results(const std::filesystem::path& folder, const std::filesystem::path& keep);

/// Takes away states, checkpoints and frames. States go before the frames that they continue, names of files before the
/// files, so that what a kill leaves can be read and resumed.
/// @param is_kept whether a state stays; none where it is empty
void remove_frames_and_states(const std::filesystem::path& folder,
                              const std::function<bool(const std::filesystem::path&)>& is_kept = {});

}  // namespace subsoil::sim
