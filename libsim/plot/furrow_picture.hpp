#pragma once
#include <filesystem>

namespace subsoil::sim {

/// `subsoil plot RUN --furrow`: the cross-section that a pass left, across the travel: the surface before and after
/// over the mean displacement by place, and over the rise of porosity. The kind of file by suffix (.png .svg .pdf).
/// Throws std::runtime_error where the run tells of no furrow, with the reason.
void draw_furrow(const std::filesystem::path& run, const std::filesystem::path& out);

}  // namespace subsoil::sim
