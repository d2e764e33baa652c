#include "libsim/post/frames_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "libdem/particles/particles.hpp"
#include "libsim/io/joined_frame.hpp"

namespace subsoil::sim {

FramesFile::FramesFile(const std::filesystem::path& path) : file_(h5::open_file(path)) {
  if (!h5::exists(file_, "/frames")) throw std::runtime_error("has no group /frames: no output of a run");
  for (std::size_t k = 0; h5::exists(file_, group(k)); ++k) {
    if (h5::exists(file_, group(k) + "/written") && h5::read<std::uint8_t>(file_, group(k) + "/written").at(0) == 0)
      break;  // a place that the run did not come to
    const h5::Handle place = h5::open_group(file_, group(k));
    times_.push_back(h5::number_attribute(place, "time"));
  }
  read_particles();
  read_surfaces();
}

std::string FramesFile::group(std::size_t frame) const { return fmt::format("/frames/{:06}", frame); }

void FramesFile::read_particles() {
  if (!h5::exists(file_, "/particles/id")) return;
  id_ = h5::read<std::int64_t>(file_, "/particles/id");
  radius_ = h5::read<float>(file_, "/particles/radius");
  density_ = h5::read<float>(file_, "/particles/density");
  material_ = h5::read<std::int32_t>(file_, "/particles/material");
  if (h5::exists(file_, "/particles/material names")) materials_ = h5::read_text(file_, "/particles/material names");
  if (h5::exists(file_, "/particles/solid volume")) volume_ = h5::read<double>(file_, "/particles/solid volume");
  if (h5::exists(file_, "/particles/clump")) clump_ = h5::read<std::int32_t>(file_, "/particles/clump");
  if (h5::exists(file_, "/particles/fibre")) fibre_ = h5::read<std::int32_t>(file_, "/particles/fibre");
  if (!fibre_.empty() && fibre_.size() != id_.size())
    throw std::runtime_error("/particles: id and fibre differ in length");
  if (!clump_.empty() && clump_.size() != id_.size())
    throw std::runtime_error("/particles: id and clump differ in length");
  if (!volume_.empty() && volume_.size() != id_.size())
    throw std::runtime_error("/particles: id and solid volume differ in length");
  if (radius_.size() != id_.size() || density_.size() != id_.size() || material_.size() != id_.size())
    throw std::runtime_error("/particles: id, radius, density and material differ in length");
  if (h5::exists(file_, "/particles/at rest")) repeat_period();
}

double FramesFile::volume(std::size_t index) const {
  return volume_.empty() ? dem::sphere_volume(radius_[index]) : volume_[index];
}

/// The table of a moving bed is of one period: here of all that some frame shows.
void FramesFile::repeat_period() {
  at_rest_ = h5::read<double>(file_, "/particles/at rest");
  period_ = h5::read<double>(file_, "/particles/period").at(0);
  const std::size_t n = id_.size();
  if (n == 0 || at_rest_.size() != 3 * n)
    throw std::runtime_error("/particles/at rest: must have a place of each sphere");
  if (!times_.empty()) first_rear_ = window(0)[0];
  std::int64_t last = static_cast<std::int64_t>(n) - 1;
  for (std::size_t frame = times_.size(); frame-- > 0;)  // ids rise from frame to frame, and in a frame
    if (holds(frame, "id")) {
      const auto ids = h5::read<std::int64_t>(file_, group(frame) + "/id");
      if (ids.empty()) continue;
      last = std::max(last, ids.back());
      break;
    }
  if (last > 1000000000) throw std::runtime_error("/frames: an id above 1e9");
  for (auto id = static_cast<std::int64_t>(n); id <= last; ++id) {
    const auto like = static_cast<std::size_t>(id) % n;
    id_.push_back(id), radius_.push_back(radius_[like]), density_.push_back(density_[like]);
    material_.push_back(material_[like]);
    if (!volume_.empty()) volume_.push_back(volume_[like]);
    if (!fibre_.empty()) fibre_.push_back(fibre_[like]);
    if (!clump_.empty())  // numbered by their first sphere
      clump_.push_back(clump_[like] < 0 ? -1 : static_cast<std::int32_t>(clump_[like] + id - std::int64_t(like)));
  }
}

FrameSpheres FramesFile::undisturbed(std::size_t frame) const {
  FrameSpheres out = spheres(frame, false);
  const std::size_t n = at_rest_.size() / 3;
  for (std::size_t i = 0; i < out.index.size(); ++i) {
    const std::size_t like = out.index[i] % n, block = out.index[i] / n;
    out.position[3 * i] = static_cast<float>(at_rest_[3 * like] + static_cast<double>(block) * period_);
    for (std::size_t d = 1; d < 3; ++d) out.position[3 * i + d] = static_cast<float>(at_rest_[3 * like + d]);
  }
  return out;
}

std::array<double, 2> FramesFile::window(std::size_t frame) const {
  const std::vector<double> ends = h5::read<double>(file_, group(frame) + "/window");
  if (ends.size() != 2) throw std::runtime_error(group(frame) + "/window: must be two numbers");
  return {ends[0], ends[1]};
}

void FramesFile::read_surfaces() {
  if (!h5::exists(file_, "/surfaces")) return;
  for (const std::string& name : h5::names_in(file_, "/surfaces")) {
    FrameSurface s;
    s.name = name;
    const std::string folder = "/surfaces/" + name;
    if (!h5::exists(file_, folder + "/vertices")) continue;
    s.vertices = h5::read<float>(file_, folder + "/vertices");
    if (h5::exists(file_, folder + "/triangles")) {
      const std::vector<std::int32_t> flat = h5::read<std::int32_t>(file_, folder + "/triangles");
      for (std::size_t i = 0; i + 2 < flat.size(); i += 3) s.triangles.push_back({flat[i], flat[i + 1], flat[i + 2]});
    }
    if (h5::exists(file_, folder + "/segments")) {
      const std::vector<std::int32_t> flat = h5::read<std::int32_t>(file_, folder + "/segments");
      for (std::size_t i = 0; i + 1 < flat.size(); i += 2) s.segments.push_back({flat[i], flat[i + 1]});
    }
    s.moves = !times_.empty() && holds(0, "surfaces/" + name);
    s.wall = h5::exists(file_, folder + "/wall");
    surfaces_.push_back(std::move(s));
  }
}

bool FramesFile::holds(std::size_t frame, const std::string& name) const {
  return JoinedFrame(file_, group(frame)).holds(name);
}

FrameSpheres FramesFile::spheres(std::size_t frame, bool with_velocity) const {
  FrameSpheres out;
  const std::string folder = group(frame);
  const JoinedFrame joined(file_, folder);
  if (!joined.holds("position")) return out;
  out.position = joined.read<float>("position");
  if (with_velocity && joined.holds("velocity")) out.velocity = joined.read<float>("velocity");
  const std::size_t n = out.position.size() / 3;
  out.index.reserve(n);
  if (!joined.holds("id")) {
    if (n != id_.size()) throw std::runtime_error(folder + " has other spheres than /particles and no ids");
    for (std::size_t i = 0; i < n; ++i) out.index.push_back(static_cast<std::uint32_t>(i));
    return out;
  }
  for (const std::int64_t id : joined.read<std::int64_t>("id")) {
    const auto found = std::lower_bound(id_.begin(), id_.end(), id);
    if (found == id_.end() || *found != id) throw std::runtime_error(folder + ": an id is not in /particles");
    out.index.push_back(static_cast<std::uint32_t>(found - id_.begin()));
  }
  if (out.index.size() != n) throw std::runtime_error(folder + ": ids and positions differ in length");
  return out;
}

dem::Bounds FramesFile::extent(std::span<const std::size_t> frames, bool with_radii) const {
  dem::Bounds box;
  for (const std::size_t frame : frames) {
    const FrameSpheres s = spheres(frame, false);
    for (std::size_t i = 0; i < s.index.size(); ++i) {
      const dem::Vec3 at{s.position[3 * i], s.position[3 * i + 1], s.position[3 * i + 2]};
      const double r = with_radii ? radius_[s.index[i]] : 0;
      box.include({at - dem::Vec3{r, r, r}, at + dem::Vec3{r, r, r}});
    }
  }
  return box;
}

double FramesFile::travelled(std::size_t frame) const { return is_moving_bed() ? window(frame)[0] - first_rear_ : 0; }

void FramesFile::put_in_window(std::size_t frame, std::vector<float>& places) const {
  if (!is_moving_bed()) return;
  const auto back = static_cast<float>(travelled(frame));
  for (std::size_t i = 0; i < places.size(); i += 3) places[i] -= back;
}

std::vector<std::int32_t> FramesFile::counts(std::size_t frame, const std::string& name) const {
  return JoinedFrame(file_, group(frame)).read<std::int32_t>(name);
}

std::vector<float> FramesFile::numbers(std::size_t frame, const std::string& name) const {
  return JoinedFrame(file_, group(frame)).read<float>(name);
}

FrameContacts FramesFile::contact_forces(std::size_t frame) const {
  const std::string folder = group(frame) + "/contact forces";
  FrameContacts out{h5::read<float>(file_, folder + "/ends"), h5::read<float>(file_, folder + "/force"),
                    h5::read<float>(file_, folder + "/normal force")};
  if (out.ends.size() != 2 * out.force.size() || out.force.size() != 3 * out.normal.size())
    throw std::runtime_error(folder + ": ends and forces differ in length");
  return out;
}

std::vector<double> FramesFile::surface(std::size_t frame, const FrameSurface& s) const {
  const std::string path = "surfaces/" + s.name;
  if (!holds(frame, path)) return {};
  std::vector<double> vertices = h5::read<double>(file_, group(frame) + "/" + path);
  if (vertices.size() != s.vertices.size()) throw std::runtime_error(group(frame) + "/" + path + " has lost vertices");
  return vertices;
}

}  // namespace subsoil::sim
