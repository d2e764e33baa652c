#include "libsim/post/vtkhdf_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/hdf5_driver.hpp"

namespace subsoil::sim {
namespace {

const std::string kRoot = "/VTKHDF";
constexpr std::array<const char*, 4> kCellGroups{"Vertices", "Lines", "Polygons", "Strips"};
constexpr std::array<const char*, 2> kDataGroups{"PointData", "CellData"};

std::size_t points_of(VtkCells cells) { return static_cast<std::size_t>(cells) + 1; }

hid_t type_of(const VtkNumbers& n) {
  if (n.real) return n.bytes == 4 ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  return n.bytes == 4 ? H5T_STD_I32LE : H5T_STD_I64LE;
}

void append(GrowingArray& to, const VtkNumbers& n) {
  if (n.real && n.bytes == 8) return to.append(n.reals);
  if (!n.real && n.bytes == 8) return to.append(n.wholes);
  // Exact: the numbers were of four bytes when they were read.
  if (n.real) return to.append(std::vector<float>(n.reals.begin(), n.reals.end()));
  to.append(std::vector<std::int32_t>(n.wholes.begin(), n.wholes.end()));
}

void put(hid_t file, const std::string& name, const std::vector<std::int64_t>& values) {
  GrowingArray(file, name, H5T_STD_I64LE).append(values);
}

std::vector<std::int64_t> counted(std::size_t count, std::size_t stride = 1) {
  std::vector<std::int64_t> out(count);
  for (std::size_t k = 0; k < count; ++k) out[k] = static_cast<std::int64_t>(k * stride);
  return out;
}

void write_head(hid_t group) {
  const std::string type = "PolyData";
  // Fixed-length ASCII and two whole numbers, as the specification asks.
  const h5::Handle text(H5Tcopy(H5T_C_S1), H5Tclose, "making a text type");
  h5::checked(H5Tset_size(text, type.size()), "making a text type");
  h5::checked(H5Tset_strpad(text, H5T_STR_NULLPAD), "making a text type");
  const h5::Handle one(H5Screate(H5S_SCALAR), H5Sclose, "shaping an attribute");
  const h5::Handle name(H5Acreate2(group, "Type", text, one, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, "creating Type");
  h5::checked(H5Awrite(name, text, type.c_str()), "writing Type");
  const hsize_t two = 2;
  const h5::Handle pair(H5Screate_simple(1, &two, nullptr), H5Sclose, "shaping an attribute");
  const h5::Handle version(H5Acreate2(group, "Version", H5T_STD_I64LE, pair, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                           "creating Version");
  h5::checked(H5Awrite(version, H5T_NATIVE_INT64, vtkhdf_version.data()), "writing Version");
}

}  // namespace

VtkFile::VtkFile(std::filesystem::path file, VtkCells cells, std::vector<std::int64_t> connectivity)
    : path_(std::move(file)),
      file_(h5::create_file(temporary_name(path_))),
      cells_(cells),
      connectivity_(std::move(connectivity)) {
  write_head(h5::create_group(file_, kRoot));
  for (const char* data : kDataGroups) h5::create_group(file_, kRoot + "/" + data);
  for (const char* kind : kCellGroups) h5::create_group(file_, kRoot + "/" + kind);
}

void VtkFile::add_step(const VtkNumbers* points) {
  if (points != nullptr) {
    if (!coordinates_) coordinates_.emplace(file_, kRoot + "/Points", type_of(*points), 3);
    start_ = static_cast<std::int64_t>(coordinates_->rows());
    append(*coordinates_, *points);
    points_now_ = points->rows();
  } else if (!coordinates_) {
    throw std::logic_error(path_.string() + ": its first step has no points");
  }
  cells_now_ = (connectivity_.empty() ? points_now_ : connectivity_.size()) / points_of(cells_);
  point_offsets_.push_back(start_);
  point_counts_.push_back(static_cast<std::int64_t>(points_now_));
  cell_counts_.push_back(static_cast<std::int64_t>(cells_now_));
}

void VtkFile::add_array(std::size_t kind, const std::string& name, const VtkNumbers* numbers) {
  auto& arrays = arrays_[kind];
  auto at = arrays.find(name);
  if (numbers != nullptr) {
    const std::size_t expected = kind == 0 ? points_now_ : cells_now_;
    if (numbers->rows() != expected)
      throw std::runtime_error(
          fmt::format("{}: {} has {} rows where there are {}", path_.string(), name, numbers->rows(), expected));
    if (at == arrays.end()) {
      const std::string path = fmt::format("{}/{}/{}", kRoot, kDataGroups[kind], name);
      at = arrays.emplace(name, Array{GrowingArray(file_, path, type_of(*numbers), numbers->columns), 0, {}}).first;
    }
    at->second.start = static_cast<std::int64_t>(at->second.values.rows());
    append(at->second.values, *numbers);
  }
  if (at == arrays.end() || at->second.offsets.size() + 1 != point_offsets_.size())
    throw std::runtime_error(
        fmt::format("{}: not every frame holds {}; every step of VTKHDF has the same arrays", path_.string(), name));
  at->second.offsets.push_back(at->second.start);
}

void VtkFile::write_cells(const std::string& path, bool used, bool constant) {
  const std::size_t width = points_of(cells_);
  const std::size_t parts = constant ? 1 : cell_counts_.size();
  std::vector<std::int64_t> cells(parts, 0), points(parts, 0);
  std::size_t most = 0;
  for (std::size_t k = 0; used && k < parts; ++k) {
    cells[k] = cell_counts_[k];
    points[k] = cell_counts_[k] * static_cast<std::int64_t>(width);
    most = std::max(most, static_cast<std::size_t>(cells[k]));
  }
  put(file_, path + "/NumberOfCells", cells);
  put(file_, path + "/NumberOfConnectivityIds", points);
  put(file_, path + "/Offsets", counted(most + 1, width));  // of each step a beginning of these
  if (used && !connectivity_.empty()) return put(file_, path + "/Connectivity", connectivity_);
  put(file_, path + "/Connectivity", counted(most * width));
}

void VtkFile::write_steps(const std::vector<double>& times, bool constant) {
  const std::string steps = kRoot + "/Steps";
  const auto count = static_cast<std::int64_t>(times.size());
  const h5::Handle group = h5::create_group(file_, steps);
  h5::set_attribute(group, "NSteps", count);
  GrowingArray(file_, steps + "/Values", H5T_IEEE_F64LE).append(times);
  put(file_, steps + "/PartOffsets", constant ? std::vector<std::int64_t>(times.size(), 0) : counted(times.size()));
  put(file_, steps + "/NumberOfParts", std::vector<std::int64_t>(times.size(), 1));
  put(file_, steps + "/PointOffsets", point_offsets_);
  const std::vector<std::int64_t> zeros(times.size() * kCellGroups.size(), 0);
  GrowingArray(file_, steps + "/CellOffsets", H5T_STD_I64LE, kCellGroups.size()).append(zeros);
  GrowingArray(file_, steps + "/ConnectivityIdOffsets", H5T_STD_I64LE, kCellGroups.size()).append(zeros);
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const std::string offsets = fmt::format("{}/{}Offsets", steps, kDataGroups[kind]);
    h5::create_group(file_, offsets);
    for (const auto& [name, array] : arrays_[kind]) put(file_, offsets + "/" + name, array.offsets);
  }
}

void VtkFile::finish(const std::vector<double>& times) {
  const auto same = [](const std::vector<std::int64_t>& counts) {
    return std::adjacent_find(counts.begin(), counts.end(), std::not_equal_to<>()) == counts.end();
  };
  const bool constant = same(point_counts_) && same(cell_counts_);
  for (std::size_t kind = 0; kind < 2; ++kind)
    for (const auto& [name, array] : arrays_[kind])
      if (array.offsets.size() != times.size())
        throw std::runtime_error(fmt::format("{}: not every frame holds {}; every step of VTKHDF has the same arrays",
                                             path_.string(), name));
  put(file_, kRoot + "/NumberOfPoints", constant ? std::vector<std::int64_t>{point_counts_.front()} : point_counts_);
  for (std::size_t k = 0; k < kCellGroups.size(); ++k)
    write_cells(fmt::format("{}/{}", kRoot, kCellGroups[k]), k == static_cast<std::size_t>(cells_), constant);
  write_steps(times, constant);
  coordinates_.reset();
  for (auto& arrays : arrays_) arrays.clear();
  h5::close_file(file_);
  put_in_place(path_);
}

}  // namespace subsoil::sim
