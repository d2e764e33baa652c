#include "libsim/io/soil_columns.hpp"

#include <algorithm>
#include <cmath>

#include "libsim/io/rounding.hpp"

namespace subsoil::sim {
namespace {

constexpr int kMantissaBits = 14;        // relative error 2^-15 = 3e-5
constexpr double kPositionShare = 1e-4;  // of the smallest radius: a hundredth of a percent of the overlaps that matter

bool inside(const FrameBox& box, const dem::Vec3& p) {
  return p.x >= box.low.x && p.x <= box.high.x && p.y >= box.low.y && p.y <= box.high.y && p.z >= box.low.z &&
         p.z <= box.high.z;
}

}  // namespace

double position_quantum(std::span<const double> radii) {
  return radii.empty() ? 0 : power_of_two_below(kPositionShare * *std::min_element(radii.begin(), radii.end()));
}

float rounded_value(double value) { return round_mantissa(static_cast<float>(value), kMantissaBits); }

std::vector<std::size_t> rows_in(const std::optional<FrameBox>& region, std::span<const dem::Vec3> position) {
  std::vector<std::size_t> rows;
  rows.reserve(position.size());
  for (std::size_t i = 0; i < position.size(); ++i)
    if (!region || inside(*region, position[i])) rows.push_back(i);
  return rows;
}

XdmfArray put_vectors(ArrayFile& file, const std::string& path, std::span<const dem::Vec3> all,
                      std::span<const std::size_t> rows, const std::string& unit, double quantum) {
  const auto value = [&](std::size_t i) { return all[rows[i / 3]][static_cast<int>(i % 3)]; };
  if (file.precision() != FramePrecision::rounded) return file.put_real(path, rows.size(), 3, unit, value);
  if (unit == "m") {
    const auto on_grid = [&](std::size_t i) { return std::nearbyint(value(i) / quantum) * quantum; };
    // Beyond 2^24 quanta from the origin a float cannot tell neighbours on the grid apart.
    double farthest = 0;
    for (const std::size_t row : rows)
      for (int d = 0; d < 3; ++d) farthest = std::max(farthest, std::abs(all[row][d]));
    if (farthest > quantum * 0x1p24) return file.put<double>(path, rows.size(), 3, unit, on_grid);
    return file.put<float>(path, rows.size(), 3, unit, on_grid);
  }
  return file.put<float>(path, rows.size(), 3, unit, [&](std::size_t i) { return rounded_value(value(i)); });
}

XdmfGrid put_motion(ArrayFile& file, const std::string& group, const Frame& frame, std::span<const std::size_t> rows,
                    const RunOptions& options, double quantum) {
  struct VectorColumn {
    const char *name, *unit;
    std::span<const dem::Vec3> data;
  };
  XdmfGrid grid{"soil", put_vectors(file, group + "/position", frame.position, rows, "m", quantum), {}, {}};
  for (const VectorColumn& column : {VectorColumn{"velocity", "m/s", frame.velocity},
                                     {"spin", "rad/s", frame.spin},
                                     {"force", "N", frame.force},
                                     {"torque", "N m", frame.torque}})
    if (options.columns.contains(column.name))
      grid.attributes.push_back(
          {column.name, put_vectors(file, group + "/" + column.name, column.data, rows, column.unit, quantum)});
  const auto put_counts = [&](const char* name, std::span<const int> counts) {
    grid.attributes.push_back({name, file.put<std::int32_t>(group + "/" + name, rows.size(), 1, "",
                                                            [&](std::size_t i) { return counts[rows[i]]; })});
  };
  if (options.columns.contains("contacts")) put_counts("contacts", frame.contacts);
  if (!frame.bonds.empty()) put_counts("bonds", frame.bonds);
  return grid;
}

std::vector<XdmfAttribute> put_particles(ArrayFile& file, const std::string& group, const ParticleTable& table,
                                         std::span<const std::int64_t> ids, std::span<const std::size_t> entries) {
  const std::size_t n = entries.size();
  const auto whole = [&](const char* name, const auto& values) {
    return file.put<std::int32_t>(group + "/" + name, n, 1, "", [&](std::size_t i) { return values[entries[i]]; });
  };
  const auto real = [&](const char* name, const char* unit, const std::vector<double>& values) {
    return file.put_real(group + "/" + name, n, 1, unit, [&](std::size_t i) { return values[entries[i]]; });
  };
  std::vector<XdmfAttribute> out;
  out.push_back({"id", file.put<std::int64_t>(group + "/id", n, 1, "", [&](std::size_t i) { return ids[i]; })});
  out.push_back({"radius", real("radius", "m", table.radius)});
  out.push_back({"density", real("density", "kg/m^3", table.density)});
  out.push_back({"material", whole("material", table.material)});
  if (!table.clump.empty()) out.push_back({"clump", whole("clump", table.clump)});
  if (!table.fibre.empty()) out.push_back({"fibre", whole("fibre", table.fibre)});
  return out;
}

}  // namespace subsoil::sim
