#pragma once

#include "libsim/base/json.hpp"
#include "libsim/post/chains.hpp"
#include "libsim/post/frames_file.hpp"

namespace subsoil::sim {

struct FilmOptions {
  double middle = 0;   ///< z of the section, m
  double bytes = 9e6;  ///< before compression
  std::size_t most_frames = 160;
  double largest_reading = 6e7;  ///< spheres read over all frames; more only cost time
  std::vector<double> stills;    ///< times of the still frames; these are in the film, and get force chains
  RestForce force;               ///< of the chains; where no law is known they show overlaps
};

/// The pass as a section: spheres whose centre lies within a mean radius of the plane z = middle, and the machine's
/// surfaces seen along z. Packed for the page: numbers of 8 and 16 bits, byte planes, zlib, base64. Keys of the result:
///   times, counts (spheres per frame), box [x0, y0, x1, y1], slab [z0, z1], spheres (x, y of 16 bits in the box; vx,
///   vy of 8 bits over +-v max; radius, depth before the pass and material of 8 bits), surfaces (shape; vertices of 16
///   bits per frame), stills: frame, and pairs of spheres that press or pull each other as (row, row, size of 8 bits,
///   128 +- 127 of `largest`; `unit` N, or 1 for overlaps over the smaller radius); `resolution`: what the rounding of
///   the frames' positions leaves uncertain of a mean chain, in the same unit.
Json film(const FramesFile& file, const FilmOptions& options);

}  // namespace subsoil::sim
