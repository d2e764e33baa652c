#pragma once
#include <filesystem>
#include <string>

namespace subsoil::sim {

struct MovieOptions {
  double rate = 25;        ///< pictures per second
  int width = 960;         ///< pixels
  std::size_t most = 500;  ///< pictures; of more frames, evenly spread
  std::string follow{};    ///< of a machine alone: body that stays in its place
};

/// `subsoil plot RUN --movie FILE`: the frames of a run as a film, .mp4 (H.264) or .webm (VP9), drawn by gnuplot and
/// joined by ffmpeg. Of soil: the section one mean diameter thick through the middle of what moves, seen along z,
/// spheres coloured by speed, moving surfaces before them. Of a machine alone: the pictures of its strip.
/// Throws std::invalid_argument for another suffix, std::runtime_error with the cure where ffmpeg is missing, and with
/// the reason where the run has no frames or no course over time.
void movie(const std::filesystem::path& run, const std::filesystem::path& out, const MovieOptions& = {});

/// True when ffmpeg is found on PATH.
bool ffmpeg_found();

}  // namespace subsoil::sim
