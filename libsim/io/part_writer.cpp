#include "libsim/io/part_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "libsim/io/disk.hpp"
#include "libsim/io/soil_columns.hpp"

namespace subsoil::sim {

std::string part_file(long first, int rank) { return fmt::format("frames/{:06}.rank-{:02}.h5", first, rank); }
std::string frames_file(long first) { return fmt::format("frames/{:06}.h5", first); }
std::string frame_group(long frame) { return fmt::format("/frames/{:06}", frame); }

PartWriter::PartWriter(const std::filesystem::path& directory, int rank, RunOptions options, double quantum)
    : directory_(directory),
      rank_(rank),
      options_(std::move(options)),
      quantum_(quantum),
      file_(directory, options_.precision, options_.compression) {
  if (!std::filesystem::is_directory(directory_ / "frames"))
    throw std::invalid_argument(
        fmt::format("{}: process {} does not see this folder; choose an --out on a disk that all nodes share, or "
                    "`output: {{frames: gathered}}`, which the first process alone writes",
                    (directory_ / "frames").string(), rank));
}

std::string PartWriter::write(const PartPlace& place, const ParticleTable& own, const Frame& frame) {
  file_.forget();
  if (!file_.is_open()) {
    const std::string name = part_file(place.first, rank_);
    require_space(directory_ / name, bytes_ + bytes_ / 8);
    file_.begin(name);
    h5::create_group(file_.id(), "/frames");
  }
  const std::string group = frame_group(place.frame);
  const std::vector<std::size_t> rows = rows_in(options_.region, frame.position);
  std::vector<std::int64_t> ids;
  for (const std::size_t row : rows) ids.push_back(own.id[row]);
  XdmfGrid grid = put_motion(file_, group, frame, rows, options_, quantum_);
  grid.name = fmt::format("soil {:02}", rank_);
  grid.cells = file_.put_point_numbers(group + "/point numbers", rows.size());
  const std::vector<XdmfAttribute> particles = put_particles(file_, group, own, ids, rows);
  grid.attributes.insert(grid.attributes.end(), particles.begin(), particles.end());
  h5::create_group(file_.id(), group);
  file_.name_all();
  file_.check();
  return rows.empty() ? "" : grid_xml(grid);
}

void PartWriter::publish() {
  if (file_.is_open()) bytes_ = std::max(bytes_, file_.end());
}

}  // namespace subsoil::sim
