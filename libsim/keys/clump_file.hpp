#pragma once
#include <filesystem>
#include <vector>

#include "libdem/particles/clump.hpp"

namespace subsoil::sim {

/// Spheres of one clump in a text file as other programs write it: x y z radius in every line, separated by blanks
/// (LIGGGHTS, YADE) or commas (CLUMP, MercuryDPM, DEME). A first line `#format id_x_y_z_r_matId` (YADE) or `x,y,z,r`
/// (DEME) names the columns, of which others are ignored. `#` begins a comment.
///
/// Metres, by `unit` metres per unit of the file. Throws std::invalid_argument that names file, line, value, rule and
/// cure.
std::vector<dem::ClumpMember> load_clump(const std::filesystem::path& path, double unit);

}  // namespace subsoil::sim
