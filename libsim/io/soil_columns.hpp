#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libsim/io/array_file.hpp"
#include "libsim/io/frame.hpp"
#include "libsim/io/xdmf.hpp"

/// The spheres of a frame as arrays of a file.
namespace subsoil::sim {

/// What positions are rounded to, m: a power of two, so that rounded coordinates are exact floats; 0 without spheres.
double position_quantum(std::span<const double> radii);
/// Of a real number on cells or spheres.
float rounded_value(double value);

/// Which of them go into the file.
std::vector<std::size_t> rows_in(const std::optional<FrameBox>& region, std::span<const dem::Vec3> position);
XdmfArray put_vectors(ArrayFile& file, const std::string& path, std::span<const dem::Vec3> all,
                      std::span<const std::size_t> rows, const std::string& unit, double quantum);
/// Positions and the columns that are wished for, of some rows of a frame; cells are the caller's.
XdmfGrid put_motion(ArrayFile& file, const std::string& group, const Frame& frame, std::span<const std::size_t> rows,
                    const RunOptions& options, double quantum);
/// Ids, and of the table's entries what never changes.
std::vector<XdmfAttribute> put_particles(ArrayFile& file, const std::string& group, const ParticleTable& table,
                                         std::span<const std::int64_t> ids, std::span<const std::size_t> entries);

}  // namespace subsoil::sim
