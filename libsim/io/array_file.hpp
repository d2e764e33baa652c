#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "libsim/io/frame.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/io/xdmf.hpp"

namespace subsoil::sim {

/// An HDF5 file of results while it is written, under its temporary name; one after another. Its arrays get their names
/// when all that belong together are there, so that none is seen without the others.
class ArrayFile {
 public:
  ArrayFile(std::filesystem::path directory, FramePrecision precision, int compression)
      : directory_(std::move(directory)), precision_(precision), compression_(compression) {}

  void begin(const std::string& name);  ///< its path from the directory
  bool is_open() const { return file_ >= 0; }
  hid_t id() const { return file_; }
  void check() const;                  ///< Throws DiskFault if a write failed
  std::uint64_t end();                 ///< puts it in place, on the disk; its bytes, 0: not known
  void drop();                         ///< throws it away
  void name_all();                     ///< the arrays since the last call
  void forget() { unnamed_.clear(); }  ///< these instead

  /// Writes rows x columns numbers of type T, value by value from `get(i)`, which several threads call, and returns
  /// where they will lie once named.
  template <class T, class Get>
  XdmfArray put(const std::string& path, std::size_t rows, hsize_t columns, const std::string& unit, Get get);
  template <class Get>
  XdmfArray put_real(const std::string& path, std::size_t rows, hsize_t columns, const std::string& unit, Get get) {
    return precision_ == FramePrecision::float64 ? put<double>(path, rows, columns, unit, get)
                                                 : put<float>(path, rows, columns, unit, get);
  }
  /// 0, 1, 2, ...: which points make the cells of a point cloud. Next to nothing once compressed.
  XdmfArray put_point_numbers(const std::string& path, std::size_t rows) {
    return put<std::int32_t>(path, rows, 1, "", [](std::size_t i) { return i; });
  }
  FramePrecision precision() const { return precision_; }

 private:
  std::filesystem::path directory_;
  FramePrecision precision_;
  int compression_;
  h5::Handle file_;
  std::string name_;
  std::vector<std::pair<std::string, h5::Handle>> unnamed_;  ///< datasets written, and the path each shall get
};

template <class T, class Get>
XdmfArray ArrayFile::put(const std::string& path, std::size_t rows, hsize_t columns, const std::string& unit, Get get) {
  std::vector<T> values(rows * columns);
  constexpr long many = 65536;  // below, other threads are not worth waking
  const auto count = static_cast<long>(values.size());
#pragma omp parallel for schedule(static) if (count > many)
  for (long i = 0; i < count; ++i)
    values[static_cast<std::size_t>(i)] = static_cast<T>(get(static_cast<std::size_t>(i)));
  const auto type = h5::type_of<T>();
  auto set = h5::write_unlinked(file_, path, values.data(), type, {rows, columns, type, compression_});
  if (!unit.empty()) h5::set_attribute(set, "unit", unit);
  unnamed_.emplace_back(path, std::move(set));
  XdmfArray array{name_ + ":" + path, {rows}, std::is_floating_point_v<T>, static_cast<int>(sizeof(T))};
  if (columns > 1) array.dimensions.push_back(columns);
  return array;
}

}  // namespace subsoil::sim
