#include "apps/output/run_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "apps/output/atomic_file.hpp"
#include "apps/output/disk.hpp"
#include "apps/output/hdf5.hpp"
#include "apps/output/hdf5_driver.hpp"
#include "apps/output/rounding.hpp"
#include "apps/output/xdmf.hpp"

namespace subsoil::app {
namespace {

constexpr int kMantissaBits = 14;        // relative error 2^-15 = 3e-5
constexpr double kPositionShare = 1e-4;  // of the smallest radius: a hundredth of a percent of the overlaps that matter

struct VectorColumn {
  const char* name;
  const char* unit;
  std::span<const dem::Vec3> Frame::*data;
};
constexpr VectorColumn kVectorColumns[] = {{"velocity", "m/s", &Frame::velocity},
                                           {"spin", "rad/s", &Frame::spin},
                                           {"force", "N", &Frame::force},
                                           {"torque", "N m", &Frame::torque}};

constexpr double kWaitingShare = 0.05;        // of the time, for the disk
constexpr std::chrono::seconds kLongest{10};  // that a frame waits for others to share its file

using Clock = std::chrono::steady_clock;

std::string group_name(long frame) { return fmt::format("/frames/{:06}", frame); }
std::string frames_file(long first) { return fmt::format("frames/{:06}.h5", first); }
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

bool inside(const FrameBox& box, const dem::Vec3& p) {
  return p.x >= box.low.x && p.x <= box.high.x && p.y >= box.low.y && p.y <= box.high.y && p.z >= box.low.z &&
         p.z <= box.high.z;
}

}  // namespace

std::set<std::string> RunOptions::all_columns() {
  return {"position", "velocity", "spin", "force", "torque", "contacts"};
}

struct RunWriter::Impl {
  Impl(const std::filesystem::path& directory_, ParticleTable particles_, std::vector<OutputSurface> surfaces_,
       RunOptions options_, const WrittenFrames& go_on)
      : directory(directory_),
        particles(std::move(particles_)),
        surfaces(std::move(surfaces_)),
        options(std::move(options_)),
        xdmf(options.title),
        file_of(go_on.file_of),
        count(static_cast<long>(file_of.size())),
        published(count) {
    check_input();
    std::error_code fault;
    std::filesystem::create_directory(directory / "frames", fault);
    if (fault) refuse_write(directory / "frames", fault.value());
    write_static();
    if (count > 0) xdmf.keep(text_of(directory / "run.xdmf"), count);
    if (!particles.radius.empty())
      quantum =
          power_of_two_below(kPositionShare * *std::min_element(particles.radius.begin(), particles.radius.end()));
  }

  void check_input() const;
  void write_particles();
  void write_surfaces();
  XdmfArray write_cells(const OutputSurface& s, const std::string& group);
  void write_value_names();
  void write_static();
  void begin_file(const std::string& name);
  void end_file();
  void name_all();
  void name_frame(const Frame& frame, const std::string& group);
  void write(const Frame& frame);
  void publish();
  void write_index() const;
  void remove_later_frames() const;
  template <class Action>
  void or_fail(const Action& action);
  std::vector<std::size_t> select(const Frame& frame) const;
  XdmfGrid write_soil(const Frame& frame, const std::string& group);
  std::vector<XdmfAttribute> write_fields(const std::vector<FrameField>& fields, const std::string& group);
  XdmfGrid write_contacts(const ContactLines& lines, const std::string& group);
  XdmfGrid write_surface(std::size_t i, const Frame& frame, const std::string& group);
  void check_frame(const Frame& frame) const;
  void write_broken_bonds(std::span<const dem::BrokenBond> broken);

  template <class T, class Get>
  XdmfArray put(const std::string& path, std::size_t rows, hsize_t columns, const std::string& unit, Get get);
  template <class Get>
  XdmfArray put_real(const std::string& path, std::size_t rows, hsize_t columns, const std::string& unit, Get get);
  /// 0, 1, 2, ...: which points make the cells of a point cloud. Next to nothing once compressed.
  XdmfArray put_point_numbers(const std::string& path, std::size_t rows) {
    return put<std::int32_t>(path, rows, 1, "", [](std::size_t i) { return i; });
  }
  XdmfArray put_vectors(const std::string& path, std::span<const dem::Vec3> all, std::span<const std::size_t> rows,
                        const std::string& unit);

  std::filesystem::path directory;
  ParticleTable particles;
  std::vector<OutputSurface> surfaces;
  RunOptions options;
  Xdmf xdmf;
  h5::Handle file;                               // that is being written, under its temporary name
  std::string file_name;                         // from the directory
  std::vector<std::int64_t> file_of;             // by frame, the first frame of its file
  std::vector<XdmfArray> cells, fixed_vertices;  // by surface
  std::vector<std::pair<std::string, XdmfArray>> particle_arrays;
  XdmfArray point_numbers;
  std::vector<std::pair<std::string, h5::Handle>> unnamed;  // datasets written, and the path each shall get
  long count = 0, published = 0;
  bool has_broken_bonds = false, finished = false;
  bool failed = false;            // what is published stands, and nothing comes after it
  bool index_is_old = true;       // run.h5 and run.xdmf do not name all that there is
  std::uint64_t frame_bytes = 0;  // of the largest file of a frame so far
  Clock::time_point published_at{};
  Clock::duration publishing{};  // what the last one took
  double quantum = 0;            // m; a power of two, so that rounded coordinates are exact floats
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

/// Writes rows x columns numbers of type T, value by value from `get(i)`, and says where they will lie once named.
template <class T, class Get>
XdmfArray RunWriter::Impl::put(const std::string& path, std::size_t rows, hsize_t columns, const std::string& unit,
                               Get get) {
  std::vector<T> values(rows * columns);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<T>(get(i));
  const auto type = h5::type_of<T>();
  auto set = h5::write_unlinked(file, path, values.data(), type, {rows, columns, type, options.compression});
  if (!unit.empty()) h5::set_attribute(set, "unit", unit);
  unnamed.emplace_back(path, std::move(set));
  XdmfArray array{file_name + ":" + path, {rows}, std::is_floating_point_v<T>, static_cast<int>(sizeof(T))};
  if (columns > 1) array.dimensions.push_back(columns);
  return array;
}

template <class Get>
XdmfArray RunWriter::Impl::put_real(const std::string& path, std::size_t rows, hsize_t columns, const std::string& unit,
                                    Get get) {
  return options.precision == FramePrecision::float64 ? put<double>(path, rows, columns, unit, get)
                                                      : put<float>(path, rows, columns, unit, get);
}

XdmfArray RunWriter::Impl::put_vectors(const std::string& path, std::span<const dem::Vec3> all,
                                       std::span<const std::size_t> rows, const std::string& unit) {
  const auto value = [&](std::size_t i) { return all[rows[i / 3]][static_cast<int>(i % 3)]; };
  if (options.precision != FramePrecision::rounded) return put_real(path, rows.size(), 3, unit, value);
  if (unit == "m")
    return put<float>(path, rows.size(), 3, unit,
                      [&](std::size_t i) { return std::nearbyint(value(i) / quantum) * quantum; });
  return put<float>(path, rows.size(), 3, unit,
                    [&](std::size_t i) { return round_mantissa(static_cast<float>(value(i)), kMantissaBits); });
}

void RunWriter::Impl::write_particles() {
  const auto n = particles.id.size();
  if (n == 0) return;
  h5::create_group(file, "/particles");
  const auto& p = particles;
  particle_arrays = {
      {"id", put<std::int64_t>("/particles/id", n, 1, "", [&](std::size_t i) { return p.id[i]; })},
      {"radius", put_real("/particles/radius", n, 1, "m", [&](std::size_t i) { return p.radius[i]; })},
      {"density", put_real("/particles/density", n, 1, "kg/m^3", [&](std::size_t i) { return p.density[i]; })},
      {"material", put<std::int32_t>("/particles/material", n, 1, "", [&](std::size_t i) { return p.material[i]; })}};
  if (!p.clump.empty())
    particle_arrays.push_back(
        {"clump", put<std::int32_t>("/particles/clump", n, 1, "", [&](std::size_t i) { return p.clump[i]; })});
  if (!p.volume.empty())
    put<double>("/particles/solid volume", n, 1, "m^3", [&](std::size_t i) { return p.volume[i]; });
  if (p.repeats()) {
    put<double>("/particles/at rest", n, 3, "m",
                [&](std::size_t i) { return p.at_rest[i / 3][static_cast<int>(i % 3)]; });
    put<double>("/particles/period", 1, 1, "m", [&](std::size_t) { return p.period; });
  }
  point_numbers = put_point_numbers("/particles/point numbers", n);
  if (!p.material_names.empty()) h5::write_text(file, "/particles/material names", p.material_names);
}

void RunWriter::Impl::write_surfaces() {
  if (surfaces.empty()) return;
  h5::create_group(file, "/surfaces");
  for (const auto& s : surfaces) {
    const std::string group = "/surfaces/" + file_name_of(s.name);
    h5::create_group(file, group);
    cells.push_back(write_cells(s, group));
    if (s.wall) put<std::int32_t>(group + "/wall", 1, 1, "", [](std::size_t) { return 1; });
    // Of a moving surface this is its shape in its own axes: nothing draws it, but it is what the poses refer to.
    fixed_vertices.push_back(put_real(group + "/vertices", s.vertices.size(), 3, "m",
                                      [&](std::size_t i) { return s.vertices[i / 3][static_cast<int>(i % 3)]; }));
  }
}

XdmfArray RunWriter::Impl::write_cells(const OutputSurface& s, const std::string& group) {
  if (!s.triangles.empty())
    return put<std::int32_t>(group + "/triangles", s.triangles.size(), 3, "",
                             [&](std::size_t i) { return s.triangles[i / 3][i % 3]; });
  if (!s.segments.empty())
    return put<std::int32_t>(group + "/segments", s.segments.size(), 2, "",
                             [&](std::size_t i) { return s.segments[i / 2][i % 2]; });
  return put_point_numbers(group + "/point numbers", s.vertices.size());
}

void RunWriter::Impl::write_value_names() {
  h5::create_group(file, "/values");
  std::vector<std::string> names, units;
  for (const FrameValue& v : options.values) names.push_back(v.name), units.push_back(v.unit);
  h5::write_text(file, "/values/names", names);
  h5::write_text(file, "/values/units", units);
}

void RunWriter::Impl::begin_file(const std::string& name) {
  file_name = name;
  file = h5::create_file(temporary_name(directory / name));
}

void RunWriter::Impl::end_file() {
  h5::close_file(file);
  put_in_place(directory / file_name);
}

void RunWriter::Impl::write_static() {
  begin_file(kStaticFile);
  write_particles();
  write_surfaces();
  if (!options.values.empty()) write_value_names();
  name_all();
  end_file();
}

void RunWriter::Impl::name_all() {
  for (const auto& [path, object] : unnamed) h5::link(object, file, path);
  unnamed.clear();
}

/// Lets the frame appear in its file: one that is refused half-way leaves its place free.
void RunWriter::Impl::name_frame(const Frame& frame, const std::string& group) {
  const h5::Handle place = h5::create_group(file, group);
  h5::set_attribute(place, "time", frame.time);
  h5::set_attribute(place, "step", static_cast<double>(frame.step));
  name_all();
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
    const std::string group = group_name(k);
    h5::link_external(index, group, frames_file(file_of[static_cast<std::size_t>(k)]), group);
  }
  h5::close_file(index);
}

/// Of a run that went on beyond the state from which this one goes on.
void RunWriter::Impl::remove_later_frames() const {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "frames", ignored)) {
    const std::string name = entry.path().stem().string();
    long first = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), first);
    if (error == std::errc{} && end == name.data() + name.size() && first >= count)
      std::filesystem::remove(entry.path(), ignored);
  }
}

/// First the frames, then what names them.
void RunWriter::Impl::publish() {
  if (failed || (!index_is_old && published == count)) return;
  const Clock::time_point begin = Clock::now();
  if (file >= 0) {
    end_file();
    std::error_code unknown;
    const auto bytes = std::filesystem::file_size(directory / file_name, unknown);
    if (!unknown) frame_bytes = std::max<std::uint64_t>(frame_bytes, bytes);
  }
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
  demand("position", frame.position.size());
  for (const auto& column : kVectorColumns) demand(column.name, (frame.*column.data).size());
  demand("contacts", frame.contacts.size());
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

/// Rows of the frame that go into the file.
std::vector<std::size_t> RunWriter::Impl::select(const Frame& frame) const {
  std::vector<std::size_t> rows;
  rows.reserve(frame.position.size());
  for (std::size_t i = 0; i < frame.position.size(); ++i)
    if (!options.region || inside(*options.region, frame.position[i])) rows.push_back(i);
  return rows;
}

XdmfGrid RunWriter::Impl::write_soil(const Frame& frame, const std::string& group) {
  const auto rows = select(frame);
  XdmfGrid grid{"soil", put_vectors(group + "/position", frame.position, rows, "m"), point_numbers, {}};
  for (const auto& column : kVectorColumns)
    if (options.columns.contains(column.name))
      grid.attributes.push_back(
          {column.name, put_vectors(group + "/" + column.name, frame.*column.data, rows, column.unit)});
  if (options.columns.contains("contacts"))
    grid.attributes.push_back({"contacts", put<std::int32_t>(group + "/contacts", rows.size(), 1, "",
                                                             [&](std::size_t i) { return frame.contacts[rows[i]]; })});
  if (!frame.bonds.empty())
    grid.attributes.push_back({"bonds", put<std::int32_t>(group + "/bonds", rows.size(), 1, "",
                                                          [&](std::size_t i) { return frame.bonds[rows[i]]; })});

  if (rows.size() == particles.id.size() && !particles.repeats()) {
    for (const auto& [name, array] : particle_arrays) grid.attributes.push_back({name, array});
    return grid;
  }
  // Some are gone or outside the region: the frame carries its own ids and what ParaView needs to draw them.
  grid.cells = put_point_numbers(group + "/point numbers", rows.size());
  std::vector<std::size_t> entry(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!frame.id) {
      entry[i] = rows[i];
      continue;
    }
    if (particles.repeats()) {
      entry[i] = static_cast<std::size_t>((*frame.id)[rows[i]]) % particles.id.size();
      continue;
    }
    const auto found = std::lower_bound(particles.id.begin(), particles.id.end(), (*frame.id)[rows[i]]);
    if (found == particles.id.end() || *found != (*frame.id)[rows[i]])
      throw std::invalid_argument(
          fmt::format("frame at {} s: sphere {} is not in the particle table", frame.time, (*frame.id)[rows[i]]));
    entry[i] = static_cast<std::size_t>(found - particles.id.begin());
  }
  const auto& p = particles;
  const auto n = rows.size();
  grid.attributes.push_back({"id", put<std::int64_t>(group + "/id", n, 1, "", [&](std::size_t i) {
                               return p.repeats() ? (*frame.id)[rows[i]] : p.id[entry[i]];
                             })});
  grid.attributes.push_back(
      {"radius", put_real(group + "/radius", n, 1, "m", [&](std::size_t i) { return p.radius[entry[i]]; })});
  grid.attributes.push_back(
      {"density", put_real(group + "/density", n, 1, "kg/m^3", [&](std::size_t i) { return p.density[entry[i]]; })});
  grid.attributes.push_back({"material", put<std::int32_t>(group + "/material", n, 1, "",
                                                           [&](std::size_t i) { return p.material[entry[i]]; })});
  if (!p.clump.empty())
    grid.attributes.push_back(
        {"clump", put<std::int32_t>(group + "/clump", n, 1, "", [&](std::size_t i) { return p.clump[entry[i]]; })});
  return grid;
}

std::vector<XdmfAttribute> RunWriter::Impl::write_fields(const std::vector<FrameField>& fields,
                                                         const std::string& group) {
  std::vector<XdmfAttribute> out;
  const bool rounds = options.precision == FramePrecision::rounded;
  for (const FrameField& f : fields) {
    const auto value = [&](std::size_t i) {
      return rounds ? round_mantissa(static_cast<float>(f.values[i]), kMantissaBits) : f.values[i];
    };
    out.push_back(
        {f.name, put_real(group + "/" + f.name, f.values.size() / f.columns, f.columns, f.unit, value), true});
  }
  return out;
}

XdmfGrid RunWriter::Impl::write_contacts(const ContactLines& lines, const std::string& group) {
  const std::size_t count = lines.ids.size() / 2;
  std::vector<std::size_t> rows(lines.ends.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  XdmfGrid grid{"contact forces",
                put_vectors(group + "/ends", lines.ends, rows, "m"),
                put<std::int32_t>(group + "/lines", count, 2, "", [](std::size_t i) { return i; }),
                {}};
  put<std::int64_t>(group + "/ids", count, 2, "", [&](std::size_t i) { return lines.ids[i]; });
  grid.attributes = write_fields(lines.fields, group);
  return grid;
}

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
  grid.vertices = put_real(group + "/surfaces/" + file_name_of(s.name), world.size(), 3, "m",
                           [&](std::size_t k) { return world[k / 3][static_cast<int>(k % 3)]; });
  return grid;
}

void RunWriter::Impl::write(const Frame& frame) {
  check_frame(frame);
  unnamed.clear();  // of a frame that was refused half-way
  if (file < 0) {
    require_space(directory / frames_file(count), frame_bytes + frame_bytes / 8);
    begin_file(frames_file(count));
    h5::create_group(file, "/frames");
  }
  const std::string group = group_name(count);
  std::vector<XdmfGrid> grids;
  if (!frame.position.empty()) grids.push_back(write_soil(frame, group));
  if (frame.contact_forces != nullptr)
    grids.push_back(write_contacts(*frame.contact_forces, group + "/contact forces"));
  for (std::size_t i = 0; i < surfaces.size(); ++i) grids.push_back(write_surface(i, frame, group));
  if (!frame.values.empty())
    put<double>(group + "/values", frame.values.size(), 1, "", [&](std::size_t i) { return frame.values[i]; });
  if (frame.window) put<double>(group + "/window", 2, 1, "m", [&](std::size_t i) { return (*frame.window)[i]; });
  name_frame(frame, group);
  h5::status_of(file)->check();
  file_of.push_back(published);
  ++count;
  xdmf.add_frame(frame.time, grids);
  const Clock::duration since = Clock::now() - published_at;
  if (since >= kLongest || kWaitingShare * since >= publishing) publish();
}

RunWriter::RunWriter(const std::filesystem::path& directory, ParticleTable particles,
                     std::vector<OutputSurface> surfaces, RunOptions options, const WrittenFrames& go_on)
    : impl_(new Impl(directory, std::move(particles), std::move(surfaces), std::move(options), go_on)) {
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
  begin_file(kBondsFile);
  const std::string group = "/broken bonds";
  h5::create_group(file, group);
  const std::size_t n = broken.size();
  put<double>(group + "/time", n, 1, "s", [&](std::size_t i) { return broken[i].time; });
  put<std::int64_t>(group + "/ids", n, 2, "", [&](std::size_t i) { return broken[i / 2].ids[i % 2]; });
  put<double>(group + "/position", n, 3, "m",
              [&](std::size_t i) { return broken[i / 3].position[static_cast<int>(i % 3)]; });
  put<double>(group + "/energy", n, 1, "J", [&](std::size_t i) { return broken[i].energy; });
  put<std::int32_t>(group + "/mode", n, 1, "", [&](std::size_t i) { return broken[i].in_tension ? 0 : 1; });
  name_all();
  h5::write_text(file, group + "/modes", {"tension", "shear"});
  end_file();
  has_broken_bonds = index_is_old = true;
}

/// Does it; after a failure of the disk what was about to be written is thrown away, which also makes room.
template <class Action>
void RunWriter::Impl::or_fail(const Action& action) {
  try {
    action();
  } catch (const DiskFault&) {
    failed = true;
    unnamed.clear();
    file = {};
    std::error_code ignored;
    for (const std::string& name : {file_name, std::string("run.h5"), std::string("run.xdmf")})
      std::filesystem::remove(temporary_name(directory / name), ignored);
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
  impl_->unnamed.clear();
  impl_->or_fail([&] { impl_->publish(); });
}

}  // namespace subsoil::app
