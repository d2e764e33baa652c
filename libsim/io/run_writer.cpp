#include "libsim/io/run_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <fstream>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "libdem/geometry/bounds.hpp"
#include "libsim/io/array_file.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/disk.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/io/hdf5_driver.hpp"
#include "libsim/io/part_writer.hpp"
#include "libsim/io/soil_columns.hpp"
#include "libsim/io/xdmf.hpp"

namespace subsoil::sim {
namespace {

constexpr double kWaitingShare = 0.05;        // of the time, for the disk
constexpr std::chrono::seconds kLongest{10};  // that a frame waits for others to share its file

using Clock = std::chrono::steady_clock;

constexpr const char* kStaticFile = "frames/static.h5";
constexpr const char* kBondsFile = "frames/broken-bonds.h5";

/// HDF5 takes a slash in a name for a level.
std::string file_name_of(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::set<std::string> RunOptions::all_columns() {
  return {"position", "velocity", "spin", "force", "torque", "contacts"};
}

struct RunWriter::Impl {
  Impl(const std::filesystem::path& directory_, ParticleTable particles_, std::vector<OutputSurface> surfaces_,
       RunOptions options_, const WrittenFrames& go_on, FrameParts* parts_)
      : directory(directory_),
        particles(std::move(particles_)),
        surfaces(std::move(surfaces_)),
        options(std::move(options_)),
        parts(parts_),
        quantum(position_quantum(particles.radius)),
        xdmf(options.title),
        file(directory, options.precision, options.compression),
        file_of(go_on.file_of),
        count(static_cast<long>(file_of.size())),
        published(count) {
    check_input();
    std::error_code fault;
    std::filesystem::create_directory(directory / "frames", fault);
    if (fault) refuse_write(directory / "frames", fault.value());
    write_static();
    if (count > 0) xdmf.keep(text_of(directory / "run.xdmf"), count);
    if (parts != nullptr) parts->open(directory, quantum);
  }

  void check_input() const;
  void write_particles();
  void write_surfaces();
  XdmfArray write_cells(const OutputSurface& s, const std::string& group);
  void write_value_names();
  void write_static();
  void name_frame(const Frame& frame, const std::string& group);
  void write(const Frame& frame);
  void publish();
  void write_index() const;
  void remove_later_frames() const;
  template <class Action>
  void or_fail(const Action& action);
  std::size_t entry_of(const Frame& frame, std::size_t row) const;
  XdmfGrid write_soil(const Frame& frame, const std::string& group);
  std::string write_parts(const Frame& frame);
  void name_parts(const std::string& group);
  std::vector<XdmfAttribute> write_fields(const std::vector<FrameField>& fields, const std::string& group);
  XdmfGrid write_contacts(const ContactLines& lines, const std::string& group);
  XdmfGrid write_surface(std::size_t i, const Frame& frame, const std::string& group);
  void check_frame(const Frame& frame) const;
  void write_broken_bonds(std::span<const dem::BrokenBond> broken);

  std::filesystem::path directory;
  ParticleTable particles;
  std::vector<OutputSurface> surfaces;
  RunOptions options;
  FrameParts* parts;
  double quantum;  // m, of positions
  Xdmf xdmf;
  ArrayFile file;                                // of frames that are being written
  std::vector<std::int64_t> file_of;             // by frame, the first frame of its file
  std::vector<XdmfArray> cells, fixed_vertices;  // by surface
  std::vector<XdmfAttribute> particle_arrays;
  XdmfArray point_numbers;
  long count = 0, published = 0;
  bool has_broken_bonds = false, finished = false;
  bool failed = false;            // what is published stands, and nothing comes after it
  bool index_is_old = true;       // run.h5 and run.xdmf do not name all that there is
  std::uint64_t frame_bytes = 0;  // of the largest file of a frame so far
  Clock::time_point published_at{};
  Clock::duration publishing{};  // what the last one took
};

void RunWriter::Impl::check_input() const {
  const auto n = particles.id.size();
  if (particles.radius.size() != n || particles.density.size() != n || particles.material.size() != n ||
      (particles.repeats() && particles.at_rest.size() != n))
    throw std::invalid_argument("particle table: id, radius, density and material must be of one length");
  if (!std::is_sorted(particles.id.begin(), particles.id.end()))
    throw std::invalid_argument("particle table: ids must rise");
  const auto known = RunOptions::all_columns();
  for (const auto& column : options.columns)
    if (!known.contains(column))
      throw std::invalid_argument("output column '" + column +
                                  "': must be one of position, velocity, spin, force, torque, contacts");
}

void RunWriter::Impl::write_particles() {
  const auto n = particles.id.size();
  if (n == 0) return;
  h5::create_group(file.id(), "/particles");
  const auto& p = particles;
  std::vector<std::size_t> all(n);
  std::iota(all.begin(), all.end(), std::size_t{0});
  particle_arrays = put_particles(file, "/particles", p, p.id, all);
  if (!p.volume.empty())
    file.put<double>("/particles/solid volume", n, 1, "m^3", [&](std::size_t i) { return p.volume[i]; });
  if (p.repeats()) {
    file.put<double>("/particles/at rest", n, 3, "m",
                     [&](std::size_t i) { return p.at_rest[i / 3][static_cast<int>(i % 3)]; });
    file.put<double>("/particles/period", 1, 1, "m", [&](std::size_t) { return p.period; });
  }
  point_numbers = file.put_point_numbers("/particles/point numbers", n);
  if (!p.material_names.empty()) h5::write_text(file.id(), "/particles/material names", p.material_names);
}

void RunWriter::Impl::write_surfaces() {
  if (surfaces.empty()) return;
  h5::create_group(file.id(), "/surfaces");
  for (const auto& s : surfaces) {
    const std::string group = "/surfaces/" + file_name_of(s.name);
    h5::create_group(file.id(), group);
    cells.push_back(write_cells(s, group));
    if (s.wall) file.put<std::int32_t>(group + "/wall", 1, 1, "", [](std::size_t) { return 1; });
    // Of a moving surface this is its shape in its own axes: nothing draws it, but it is what the poses refer to.
    fixed_vertices.push_back(file.put_real(group + "/vertices", s.vertices.size(), 3, "m",
                                           [&](std::size_t i) { return s.vertices[i / 3][static_cast<int>(i % 3)]; }));
  }
}

XdmfArray RunWriter::Impl::write_cells(const OutputSurface& s, const std::string& group) {
  if (!s.triangles.empty())
    return file.put<std::int32_t>(group + "/triangles", s.triangles.size(), 3, "",
                                  [&](std::size_t i) { return s.triangles[i / 3][i % 3]; });
  if (!s.segments.empty())
    return file.put<std::int32_t>(group + "/segments", s.segments.size(), 2, "",
                                  [&](std::size_t i) { return s.segments[i / 2][i % 2]; });
  return file.put_point_numbers(group + "/point numbers", s.vertices.size());
}

void RunWriter::Impl::write_value_names() {
  h5::create_group(file.id(), "/values");
  std::vector<std::string> names, units;
  for (const FrameValue& v : options.values) names.push_back(v.name), units.push_back(v.unit);
  h5::write_text(file.id(), "/values/names", names);
  h5::write_text(file.id(), "/values/units", units);
}

void RunWriter::Impl::write_static() {
  file.begin(kStaticFile);
  write_particles();
  write_surfaces();
  if (!options.values.empty()) write_value_names();
  file.name_all();
  file.end();
}

/// Lets the frame appear in its file: one that is refused half-way leaves its place free.
void RunWriter::Impl::name_frame(const Frame& frame, const std::string& group) {
  const h5::Handle place = h5::create_group(file.id(), group);
  h5::set_attribute(place, "time", frame.time);
  h5::set_attribute(place, "step", static_cast<double>(frame.step));
  file.name_all();
  if (parts != nullptr) name_parts(group);
  const std::uint8_t yes = 1;
  h5::write(place, "written", std::span(&yes, 1));
}

/// run.h5: links to what lies in the files of frames, and nothing else.
void RunWriter::Impl::write_index() const {
  h5::Handle index = h5::create_file(temporary_name(directory / "run.h5"));
  h5::set_attribute(index, "subsoil output", std::int64_t{2});
  h5::set_attribute(index, "title", options.title);
  if (!particles.id.empty()) h5::link_external(index, "/particles", kStaticFile, "/particles");
  if (!surfaces.empty()) h5::link_external(index, "/surfaces", kStaticFile, "/surfaces");
  if (!options.values.empty()) h5::link_external(index, "/values", kStaticFile, "/values");
  if (has_broken_bonds) h5::link_external(index, "/broken bonds", kBondsFile, "/broken bonds");
  h5::create_group(index, "/frames");
  for (long k = 0; k < count; ++k) {
    const std::string group = frame_group(k);
    h5::link_external(index, group, frames_file(file_of[static_cast<std::size_t>(k)]), group);
  }
  h5::close_file(index);
}

/// Of a run that went on beyond the state from which this one goes on.
void RunWriter::Impl::remove_later_frames() const {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "frames", ignored)) {
    const std::string name = entry.path().filename().string();
    long first = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), first);
    const std::string_view rest(end, name.data() + name.size());
    if (error == std::errc{} && (rest == ".h5" || rest.starts_with(".rank-")) && first >= count)
      std::filesystem::remove(entry.path(), ignored);
  }
}

/// First the parts of frames, then the frames, then what names them.
void RunWriter::Impl::publish() {
  if (failed || (!index_is_old && published == count)) return;
  const Clock::time_point begin = Clock::now();
  if (parts != nullptr) parts->publish();
  if (file.is_open()) frame_bytes = std::max(frame_bytes, file.end());
  write_index();
  OutFile text(temporary_name(directory / "run.xdmf"));
  text.write(xdmf.text());
  text.close();
  for (const char* name : {"run.h5", "run.xdmf"}) sync_file(temporary_name(directory / name));
  for (const char* name : {"run.h5", "run.xdmf"}) rename_into_place(directory / name);
  sync_folder(directory);
  if (published == 0) write_atomically(directory / "run.xdmf2", xdmf_leading_to("run.xdmf"));
  published = count, index_is_old = false;
  published_at = Clock::now();
  publishing = published_at - begin;
}

void RunWriter::Impl::check_frame(const Frame& frame) const {
  const auto n = frame.id ? frame.id->size() : particles.id.size();
  const auto demand = [&](const std::string& name, std::size_t size) {
    if (options.columns.contains(name) && size != n)
      throw std::invalid_argument(
          fmt::format("frame at {} s: {} has {} entries, {} spheres are there", frame.time, name, size, n));
  };
  if (parts == nullptr) {
    demand("position", frame.position.size()), demand("velocity", frame.velocity.size());
    demand("spin", frame.spin.size()), demand("force", frame.force.size()), demand("torque", frame.torque.size());
    demand("contacts", frame.contacts.size());
  }
  if (!frame.bonds.empty() && frame.bonds.size() != n)
    throw std::invalid_argument(
        fmt::format("frame at {} s: bonds has {} entries, {} spheres are there", frame.time, frame.bonds.size(), n));
  if (frame.surfaces.size() != surfaces.size())
    throw std::invalid_argument(
        fmt::format("frame at {} s: {} poses for {} surfaces", frame.time, frame.surfaces.size(), surfaces.size()));
  if (!frame.values.empty() && frame.values.size() != options.values.size())
    throw std::invalid_argument(
        fmt::format("frame at {} s: {} values, {} are named", frame.time, frame.values.size(), options.values.size()));
  std::size_t next = 0;
  for (const auto& s : surfaces) {
    if (!s.deforms) continue;
    if (next >= frame.deformed.size() || frame.deformed[next].size() != s.vertices.size())
      throw std::invalid_argument(
          fmt::format("frame at {} s: {} needs its {} vertices", frame.time, s.name, s.vertices.size()));
    ++next;
  }
}

/// Of a row of the frame, in the particle table.
std::size_t RunWriter::Impl::entry_of(const Frame& frame, std::size_t row) const {
  if (!frame.id) return row;
  const std::int64_t id = (*frame.id)[row];
  if (particles.repeats()) return static_cast<std::size_t>(id) % particles.id.size();
  const auto found = std::lower_bound(particles.id.begin(), particles.id.end(), id);
  if (found == particles.id.end() || *found != id)
    throw std::invalid_argument(fmt::format("frame at {} s: sphere {} is not in the particle table", frame.time, id));
  return static_cast<std::size_t>(found - particles.id.begin());
}

XdmfGrid RunWriter::Impl::write_soil(const Frame& frame, const std::string& group) {
  const std::vector<std::size_t> rows = rows_in(options.region, frame.position);
  XdmfGrid grid = put_motion(file, group, frame, rows, options, quantum);
  grid.cells = point_numbers;
  if (rows.size() == particles.id.size() && !particles.repeats()) {
    grid.attributes.insert(grid.attributes.end(), particle_arrays.begin(), particle_arrays.end());
    return grid;
  }
  // Some are gone or outside the region: the frame carries its own ids and what ParaView needs to draw them.
  grid.cells = file.put_point_numbers(group + "/point numbers", rows.size());
  std::vector<std::size_t> entries;
  std::vector<std::int64_t> ids;
  for (const std::size_t row : rows) {
    entries.push_back(entry_of(frame, row));
    ids.push_back(particles.repeats() ? (*frame.id)[row] : particles.id[entries.back()]);
  }
  const std::vector<XdmfAttribute> own = put_particles(file, group, particles, ids, entries);
  grid.attributes.insert(grid.attributes.end(), own.begin(), own.end());
  return grid;
}

std::string RunWriter::Impl::write_parts(const Frame& frame) { return parts->write({count, published}, frame.between); }

void RunWriter::Impl::name_parts(const std::string& group) {
  h5::create_group(file.id(), group + "/parts");
  for (int k = 0; k < parts->count(); ++k)
    h5::link_external(file.id(), fmt::format("{}/parts/{:02}", group, k),
                      std::filesystem::path(part_file(published, k)).filename().string(), group);
}

std::vector<XdmfAttribute> RunWriter::Impl::write_fields(const std::vector<FrameField>& fields,
                                                         const std::string& group) {
  std::vector<XdmfAttribute> out;
  const bool rounds = options.precision == FramePrecision::rounded;
  for (const FrameField& f : fields) {
    const auto value = [&](std::size_t i) { return rounds ? rounded_value(f.values[i]) : f.values[i]; };
    out.push_back(
        {f.name, file.put_real(group + "/" + f.name, f.values.size() / f.columns, f.columns, f.unit, value), true});
  }
  return out;
}

XdmfGrid RunWriter::Impl::write_contacts(const ContactLines& lines, const std::string& group) {
  const std::size_t count = lines.ids.size() / 2;
  std::vector<std::size_t> rows(lines.ends.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  XdmfGrid grid{"contact forces",
                put_vectors(file, group + "/ends", lines.ends, rows, "m", quantum),
                file.put<std::int32_t>(group + "/lines", count, 2, "", [](std::size_t i) { return i; }),
                {}};
  file.put<std::int64_t>(group + "/ids", count, 2, "", [&](std::size_t i) { return lines.ids[i]; });
  grid.attributes = write_fields(lines.fields, group);
  return grid;
}

namespace {

/// Whether floats leave of a surface, far from the origin, less than a hundred-thousandth of its size.
bool is_coarse_in_floats(const std::vector<dem::Vec3>& vertices) {
  dem::Bounds box;
  double farthest = 0;
  for (const dem::Vec3& v : vertices) {
    box.include(v);
    for (int d = 0; d < 3; ++d) farthest = std::max(farthest, std::abs(v[d]));
  }
  return farthest * 0x1p-24 > 1e-5 * box.diagonal();
}

}  // namespace

XdmfGrid RunWriter::Impl::write_surface(std::size_t i, const Frame& frame, const std::string& group) {
  const auto& s = surfaces[i];
  XdmfGrid grid{s.name, fixed_vertices[i], cells[i], {}};
  if (!frame.loads.empty()) grid.attributes = write_fields(frame.loads[i], group + "/loads/" + file_name_of(s.name));
  if (!s.moves && !s.deforms) return grid;
  std::vector<dem::Vec3> world;
  if (s.deforms) {
    const auto before = std::count_if(surfaces.begin(), surfaces.begin() + static_cast<std::ptrdiff_t>(i),
                                      [](const OutputSurface& other) { return other.deforms; });
    world = frame.deformed[static_cast<std::size_t>(before)];
  } else {
    for (const dem::Vec3& v : s.vertices) world.push_back(frame.surfaces[i].to_world(v));
  }
  const std::string path = group + "/surfaces/" + file_name_of(s.name);
  const auto value = [&](std::size_t k) { return world[k / 3][static_cast<int>(k % 3)]; };
  if (file.precision() == FramePrecision::rounded && is_coarse_in_floats(world))
    grid.vertices = file.put<double>(path, world.size(), 3, "m", value);
  else
    grid.vertices = file.put_real(path, world.size(), 3, "m", value);
  return grid;
}

void RunWriter::Impl::write(const Frame& frame) {
  check_frame(frame);
  file.forget();  // of a frame that was refused half-way
  if (!file.is_open()) {
    require_space(directory / frames_file(count), frame_bytes + frame_bytes / 8);
    file.begin(frames_file(count));
    h5::create_group(file.id(), "/frames");
  }
  const std::string group = frame_group(count);
  std::vector<XdmfGrid> grids;
  const std::string soil = parts != nullptr ? write_parts(frame) : "";
  if (parts == nullptr && !particles.id.empty()) {  // a frame without spheres has arrays without rows
    XdmfGrid spheres = write_soil(frame, group);
    if (!frame.position.empty()) grids.push_back(std::move(spheres));
  }
  if (frame.contact_forces != nullptr)
    grids.push_back(write_contacts(*frame.contact_forces, group + "/contact forces"));
  for (std::size_t i = 0; i < surfaces.size(); ++i) grids.push_back(write_surface(i, frame, group));
  if (!frame.values.empty())
    file.put<double>(group + "/values", frame.values.size(), 1, "", [&](std::size_t i) { return frame.values[i]; });
  if (frame.window) file.put<double>(group + "/window", 2, 1, "m", [&](std::size_t i) { return (*frame.window)[i]; });
  name_frame(frame, group);
  file.check();
  file_of.push_back(published);
  ++count;
  xdmf.add_frame(frame.time, grids, soil);
  const Clock::duration since = Clock::now() - published_at;
  if (since >= kLongest || kWaitingShare * since >= publishing) publish();
}

RunWriter::RunWriter(const std::filesystem::path& directory, ParticleTable particles,
                     std::vector<OutputSurface> surfaces, RunOptions options, const WrittenFrames& go_on,
                     FrameParts* parts)
    : impl_(new Impl(directory, std::move(particles), std::move(surfaces), std::move(options), go_on, parts)) {
  if (impl_->count == 0 && !std::filesystem::exists(directory / "run.h5")) return;
  // Of an earlier run in this folder: what is left of it must be named before the rest goes.
  if (impl_->count > 0) impl_->publish();
  impl_->remove_later_frames();
}

RunWriter::~RunWriter() {
  try {
    finish();
  } catch (const std::exception&) {
    // What was published before is on the disk.
  }
}

void RunWriter::Impl::write_broken_bonds(std::span<const dem::BrokenBond> broken) {
  if (broken.empty()) return;
  publish();
  file.begin(kBondsFile);
  const std::string group = "/broken bonds";
  h5::create_group(file.id(), group);
  const std::size_t n = broken.size();
  file.put<double>(group + "/time", n, 1, "s", [&](std::size_t i) { return broken[i].time; });
  file.put<std::int64_t>(group + "/ids", n, 2, "", [&](std::size_t i) { return broken[i / 2].ids[i % 2]; });
  file.put<double>(group + "/position", n, 3, "m",
                   [&](std::size_t i) { return broken[i / 3].position[static_cast<int>(i % 3)]; });
  file.put<double>(group + "/energy", n, 1, "J", [&](std::size_t i) { return broken[i].energy; });
  file.put<std::int32_t>(group + "/mode", n, 1, "", [&](std::size_t i) {
    return broken[i].in_tension ? 0 : broken[i].by_edge ? 2 : 1;
  });
  file.name_all();
  h5::write_text(file.id(), group + "/modes", {"tension", "shear", "edge"});
  file.end();
  has_broken_bonds = index_is_old = true;
}

/// Does it; after a failure of the disk what was about to be written is thrown away, which also makes room.
template <class Action>
void RunWriter::Impl::or_fail(const Action& action) {
  try {
    action();
  } catch (const DiskFault&) {
    failed = true;
    file.drop();
    if (parts != nullptr) parts->drop();
    std::error_code ignored;
    for (const char* name : {"run.h5", "run.xdmf"}) std::filesystem::remove(temporary_name(directory / name), ignored);
    throw;
  }
}

void RunWriter::write(const Frame& frame) {
  if (impl_->failed) return;
  impl_->or_fail([&] { impl_->write(frame); });
}
void RunWriter::write_broken_bonds(std::span<const dem::BrokenBond> broken) {
  if (impl_->failed) return;
  impl_->or_fail([&] { impl_->write_broken_bonds(broken); });
}
long RunWriter::frames() const { return impl_->failed ? impl_->published : impl_->count; }

const ParticleTable& RunWriter::particles() const { return impl_->particles; }

WrittenFrames RunWriter::publish() {
  impl_->or_fail([&] { impl_->publish(); });
  return {impl_->file_of};
}

void RunWriter::finish() {
  if (std::exchange(impl_->finished, true)) return;
  impl_->file.forget();
  impl_->or_fail([&] { impl_->publish(); });
}

}  // namespace subsoil::sim
