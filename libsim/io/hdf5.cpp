#include "libsim/io/hdf5.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <stdexcept>

#include "libsim/base/deflate.hpp"
#include "libsim/base/input_limits.hpp"
#include "libsim/io/disk.hpp"
#include "libsim/io/hdf5_driver.hpp"
#include "libsim/io/read_guard.hpp"

namespace subsoil::sim::h5 {
namespace {

/// The innermost entry of HDF5's error stack says what really happened.
herr_t take_innermost(unsigned n, const H5E_error2_t* error, void* text) {
  if (n == 0 && error->desc) *static_cast<std::string*>(text) = error->desc;
  return 0;
}

/// HDF5 prints its stack to stderr unless told not to; ours goes into the exception.
void be_quiet() {
  static const bool once = [] { return H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0; }();
  (void)once;
}

/// Types we keep for the life of the program; H5T_NATIVE_* are calls in disguise.
Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "making a text type");
  checked(H5Tset_size(type, H5T_VARIABLE), "making a text type");
  checked(H5Tset_cset(type, H5T_CSET_UTF8), "making a text type");
  return type;
}

Handle open_dataset(hid_t parent, const std::string& name) {
  return {H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "opening dataset " + name};
}

/// Chunks of at most 16k rows, so that 130k spheres keep eight threads busy; equal in size so that the last is not
/// mostly padding.
hsize_t rows_per_chunk(const Layout& layout) {
  constexpr hsize_t most = 16384;
  const hsize_t pieces = (layout.rows + most - 1) / most;
  return (layout.rows + pieces - 1) / pieces;
}

/// Numbers so few that the index of their chunks (2.6 kB in HDF5's B-tree) would be more than they are: they lie in the
/// dataset's header, as they are.
bool is_small(const Layout& layout) {
  constexpr hsize_t most = 4096;  // bytes
  return layout.rows > 0 && layout.rows * layout.columns * H5Tget_size(layout.file_type) <= most;
}

Handle creation_properties(const Layout& layout) {
  Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "preparing a dataset");
  checked(H5Pset_obj_track_times(list, false), "preparing a dataset");  // the same run writes the same bytes
  if (layout.compression < 0 || layout.rows == 0) return list;
  if (is_small(layout)) {
    checked(H5Pset_layout(list, H5D_COMPACT), "choosing a layout");
    return list;
  }
  const hsize_t chunk[2] = {rows_per_chunk(layout), layout.columns};
  checked(H5Pset_chunk(list, layout.columns > 1 ? 2 : 1, chunk), "choosing chunks");
  checked(H5Pset_shuffle(list), "choosing byte shuffle");
  checked(H5Pset_deflate(list, static_cast<unsigned>(layout.compression)), "choosing gzip");
  return list;
}

/// The bytes of numbers of one width by their place in the number, as HDF5's shuffle filter puts them.
template <std::size_t width>
void shuffle(const unsigned char* from, std::size_t numbers, std::size_t plane, unsigned char* planes) {
  for (std::size_t b = 0; b < width; ++b)
    for (std::size_t i = 0; i < numbers; ++i) planes[b * plane + i] = from[i * width + b];
}
void shuffle(std::size_t width, const unsigned char* from, std::size_t numbers, std::size_t plane,
             unsigned char* planes) {
  if (width == 4) return shuffle<4>(from, numbers, plane, planes);
  if (width == 8) return shuffle<8>(from, numbers, plane, planes);
  for (std::size_t i = 0; i < numbers; ++i)
    for (std::size_t b = 0; b < width; ++b) planes[b * plane + i] = from[i * width + b];
}

/// Does what HDF5's shuffle and gzip filters would, a chunk on each thread, and hands the chunks over ready, in order.
void write_chunks(hid_t set, const std::string& name, const void* data, const Layout& layout) {
  const std::size_t width = H5Tget_size(layout.file_type);
  const hsize_t rows = rows_per_chunk(layout);
  const std::size_t count = rows * layout.columns;
  const auto packed_from = [&](hsize_t first) {
    const auto* from = static_cast<const unsigned char*>(data) + first * layout.columns * width;
    const std::size_t here = std::min(rows, layout.rows - first) * layout.columns;
    std::vector<unsigned char> planes(count * width, 0);  // the last chunk is padded with zeros
    shuffle(width, from, here, count, planes.data());
    return deflated_planes(planes, count, layout.compression);
  };
  const int chunks = static_cast<int>((layout.rows + rows - 1) / rows), at_once = omp_get_max_threads();
  std::vector<std::vector<unsigned char>> packed(static_cast<std::size_t>(at_once));
  for (int begin = 0; begin < chunks; begin += at_once) {
    const int end = std::min(chunks, begin + at_once);
#pragma omp parallel for schedule(static, 1)
    for (int k = begin; k < end; ++k) {
      std::vector<unsigned char>& chunk = packed[static_cast<std::size_t>(k - begin)];
      try {
        chunk = packed_from(static_cast<hsize_t>(k) * rows);
      } catch (const std::bad_alloc&) {  // must not leave the thread
        chunk.clear();
      }
    }
    for (int k = begin; k < end; ++k) {
      const std::vector<unsigned char>& chunk = packed[static_cast<std::size_t>(k - begin)];
      if (chunk.empty()) throw std::runtime_error("no memory to compress a chunk of " + name);
      const hsize_t place[2] = {static_cast<hsize_t>(k) * rows, 0};
      checked(H5Dwrite_chunk(set, H5P_DEFAULT, 0, place, chunk.size(), chunk.data()), "writing " + name);
    }
  }
}

/// HDF5 clears a megabyte for whatever it converts, texts above all, unless it is told that less will do.
Handle transfer_properties(hid_t memory_type, const Layout& layout) {
  constexpr std::size_t little = 65536;  // bytes
  Handle list(H5Pcreate(H5P_DATASET_XFER), H5Pclose, "preparing a transfer");
  const std::size_t width = std::max(H5Tget_size(memory_type), H5Tget_size(layout.file_type));
  if (layout.rows * layout.columns * width <= little)
    checked(H5Pset_buffer(list, little, nullptr, nullptr), "preparing a transfer");
  return list;
}

}  // namespace

std::int64_t checked(std::int64_t code, const std::string& doing) {
  if (code >= 0) return code;
  std::string reason = "no reason given";
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_innermost, &reason);
  throw std::runtime_error("HDF5: " + doing + ": " + reason);
}

template <>
hid_t type_of<float>() {
  return H5T_NATIVE_FLOAT;
}
template <>
hid_t type_of<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
hid_t type_of<std::uint8_t>() {
  return H5T_NATIVE_UINT8;
}
template <>
hid_t type_of<std::int32_t>() {
  return H5T_NATIVE_INT32;
}
template <>
hid_t type_of<std::uint32_t>() {
  return H5T_NATIVE_UINT32;
}
template <>
hid_t type_of<std::int64_t>() {
  return H5T_NATIVE_INT64;
}
template <>
hid_t type_of<std::uint64_t>() {
  return H5T_NATIVE_UINT64;
}

Handle create_file(const std::filesystem::path& path) {
  be_quiet();
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "preparing " + path.string());
  checked(H5Pset_driver(access, checked_driver(), nullptr), "preparing " + path.string());
  // Groups and headers as of HDF5 1.8 (2008) are a third of the older ones.
  checked(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "preparing " + path.string());
  errno = 0;
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  if (file < 0 && errno != 0) refuse_write(path, errno);
  return {file, H5Fclose, "creating " + path.string()};
}

Handle open_file(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) throw std::runtime_error(path.string() + ": there is no such file");
  be_quiet();
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "preparing " + path.string());
  checked(H5Pset_file_locking(access, false, true), "preparing " + path.string());
  const ReadGuard guard(path.string());
  return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose, "opening " + path.string()};
}

Handle create_group(hid_t parent, const std::string& name, std::size_t name_bytes) {
  Handle properties(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "preparing group " + name);
  if (name_bytes > 0) checked(H5Pset_local_heap_size_hint(properties, name_bytes), "preparing group " + name);
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT), H5Gclose, "creating group " + name};
}

Handle open_group(hid_t parent, const std::string& name) {
  const ReadGuard guard(parent);
  return {H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "opening group " + name};
}

std::vector<std::string> names_in(hid_t parent, const std::string& group) {
  const ReadGuard guard(parent);
  const Handle handle = open_group(parent, group);
  H5G_info_t info;
  checked(H5Gget_info(handle, &info), "listing " + group);
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    char name[512];
    checked(H5Lget_name_by_idx(handle, ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof name, H5P_DEFAULT),
            "listing " + group);
    names.emplace_back(name);
  }
  return names;
}

std::filesystem::path external_target(hid_t parent, const std::string& group, const std::string& name) {
  const ReadGuard guard(parent);
  const Handle handle = open_group(parent, group);
  H5L_info_t info;
  checked(H5Lget_info(handle, name.c_str(), &info, H5P_DEFAULT), "looking at link " + name);
  if (info.type != H5L_TYPE_EXTERNAL) return {};
  std::vector<char> value(info.u.val_size), holder(4096);
  checked(H5Lget_val(handle, name.c_str(), value.data(), value.size(), H5P_DEFAULT), "looking at link " + name);
  const char *file = nullptr, *object = nullptr;
  checked(H5Lunpack_elink_val(value.data(), value.size(), nullptr, &file, &object), "looking at link " + name);
  checked(H5Fget_name(handle, holder.data(), holder.size()), "looking at link " + name);
  return std::filesystem::path(holder.data()).parent_path() / file;
}

std::vector<std::string> dataset_names(hid_t parent) {
  const ReadGuard guard(parent);
  std::vector<std::string> names;
  const auto visit = [](hid_t group, const char* name, const H5L_info_t*, void* to) -> herr_t {
    const hid_t object = H5Oopen(group, name, H5P_DEFAULT);
    if (object < 0) return -1;
    if (H5Iget_type(object) == H5I_DATASET) static_cast<std::vector<std::string>*>(to)->emplace_back(name);
    return H5Oclose(object);
  };
  checked(H5Lvisit(parent, H5_INDEX_NAME, H5_ITER_INC, visit, &names), "listing what a file holds");
  return names;
}

bool exists(hid_t parent, const std::string& path) {
  const ReadGuard guard(parent);
  // HDF5 refuses to ask for a/b when there is no a, so ask link by link.
  for (std::size_t slash = path.find('/', 1); slash != std::string::npos; slash = path.find('/', slash + 1))
    if (H5Lexists(parent, path.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
  return H5Lexists(parent, path.c_str(), H5P_DEFAULT) > 0;
}

Handle write_unlinked(hid_t file, const std::string& name, const void* data, hid_t memory_type, const Layout& layout) {
  const hsize_t dimensions[2] = {layout.rows, layout.columns};
  const Handle space(H5Screate_simple(layout.columns > 1 ? 2 : 1, dimensions, nullptr), H5Sclose, "shaping " + name);
  Handle set(H5Dcreate_anon(file, layout.file_type, space, creation_properties(layout), H5P_DEFAULT), H5Dclose,
             "creating dataset " + name);
  if (layout.rows == 0) return set;
  const bool ready = H5Tequal(memory_type, layout.file_type) > 0;  // numbers lie in memory as in the file
  if (ready && layout.compression >= 0 && !is_small(layout))
    write_chunks(set, name, data, layout);
  else
    checked(H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, transfer_properties(memory_type, layout), data),
            "writing " + name);
  return set;
}

void link(hid_t object, hid_t parent, const std::string& name) {
  const Handle properties(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "preparing " + name);
  checked(H5Pset_create_intermediate_group(properties, 1), "preparing " + name);
  checked(H5Olink(object, parent, name.c_str(), properties, H5P_DEFAULT), "naming " + name);
}

void write(hid_t parent, const std::string& name, const void* data, hid_t memory_type, const Layout& layout) {
  link(write_unlinked(parent, name, data, memory_type, layout), parent, name);
}

void write_text(hid_t parent, const std::string& name, const std::vector<std::string>& lines) {
  std::vector<const char*> pointers;
  for (const auto& line : lines) pointers.push_back(line.c_str());
  const Handle type = string_type();
  write(parent, name, pointers.data(), type, {lines.size(), 1, type, -1});
}

std::vector<hsize_t> shape(hid_t parent, const std::string& name) {
  const ReadGuard guard(parent);
  const Handle set = open_dataset(parent, name);
  const Handle space(H5Dget_space(set), H5Sclose, "shape of " + name);
  std::vector<hsize_t> dimensions(
      static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), "shape of " + name)));
  checked(H5Sget_simple_extent_dims(space, dimensions.data(), nullptr), "shape of " + name);
  return dimensions;
}

NumberKind kind_of(hid_t parent, const std::string& name) {
  const ReadGuard guard(parent);
  const Handle set = open_dataset(parent, name);
  const Handle type(H5Dget_type(set), H5Tclose, "type of " + name);
  return {H5Tget_class(type) == H5T_FLOAT, static_cast<int>(H5Tget_size(type))};
}

namespace {

/// Number of values of a dataset, whose shape is only what the file says: refused where it holds no such number of
/// bytes (gzip packs 1032 into one at best) or more than one array may have.
std::size_t count_of(hid_t set, const std::string& name, const std::vector<hsize_t>& shape, std::size_t width) {
  double count = 1;
  for (const hsize_t n : shape) count *= static_cast<double>(n);
  const double bytes = count * static_cast<double>(width), held = static_cast<double>(H5Dget_storage_size(set));
  if (bytes > 1100 * held + 64)
    throw std::runtime_error(
        fmt::format("HDF5: dataset {} says it holds {:.4g} values and takes {:g} bytes of the file: it is damaged",
                    name, count, held));
  if (bytes > static_cast<double>(input_limits().array_bytes))
    throw std::runtime_error(fmt::format("HDF5: dataset {} holds {:.4g} bytes; an array may have {}{}", name, bytes,
                                         input_limits().array_bytes, allow_more("array-bytes")));
  return static_cast<std::size_t>(count);
}

/// One value alone is read into one number, whatever shape the file gives it.
Handle open_scalar_attribute(hid_t object, const char* name) {
  Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose, std::string("opening attribute ") + name);
  const Handle space(H5Aget_space(attribute), H5Sclose, std::string("shape of attribute ") + name);
  if (H5Sget_simple_extent_npoints(space) != 1)
    throw std::runtime_error(std::string("HDF5: attribute ") + name + " is no single number: the file is damaged");
  return attribute;
}

}  // namespace

template <class T>
std::vector<T> read(hid_t parent, const std::string& name) {
  const ReadGuard guard(parent);
  const Handle set = open_dataset(parent, name);
  const std::size_t count = count_of(set, name, shape(parent, name), sizeof(T));
  const Handle type(H5Dget_type(set), H5Tclose, "type of " + name);
  if (H5Tget_class(type) != H5Tget_class(type_of<T>()))
    throw std::runtime_error("HDF5: dataset " + name + " holds another kind of number than the one asked for");
  std::vector<T> values(count);
  if (count > 0)
    checked(H5Dread(set, type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "reading dataset " + name);
  return values;
}
template std::vector<float> read(hid_t, const std::string&);
template std::vector<double> read(hid_t, const std::string&);
template std::vector<std::uint8_t> read(hid_t, const std::string&);
template std::vector<std::int32_t> read(hid_t, const std::string&);
template std::vector<std::uint32_t> read(hid_t, const std::string&);
template std::vector<std::int64_t> read(hid_t, const std::string&);
template std::vector<std::uint64_t> read(hid_t, const std::string&);

std::vector<std::string> read_text(hid_t parent, const std::string& name) {
  const ReadGuard guard(parent);
  const Handle set = open_dataset(parent, name);
  const Handle space(H5Dget_space(set), H5Sclose, "shape of " + name);
  const Handle held(H5Dget_type(set), H5Tclose, "type of " + name);
  if (H5Tis_variable_str(held) <= 0) throw std::runtime_error("HDF5: dataset " + name + " holds no text");
  const std::size_t count = count_of(set, name, shape(parent, name), H5Tget_size(held));
  const Handle type = string_type();
  std::vector<char*> pointers(count, nullptr);
  if (count > 0) checked(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()), "reading " + name);
  std::vector<std::string> lines;
  for (const char* line : pointers) lines.emplace_back(line != nullptr ? line : "");  // null: nothing was written there
  if (count > 0) checked(H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data()), "reading " + name);
  return lines;
}

namespace {
void set_attribute(hid_t object, const char* name, hid_t type, const void* value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, "shaping an attribute");
  const Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         std::string("creating attribute ") + name);
  checked(H5Awrite(attribute, type, value), std::string("writing attribute ") + name);
}
}  // namespace

void set_attribute(hid_t object, const char* name, const std::string& text) {
  // Fixed length: variable strings live in a heap that is shared by the whole file.
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "making a text type");
  checked(H5Tset_size(type, std::max<std::size_t>(text.size(), 1)), "making a text type");
  checked(H5Tset_cset(type, H5T_CSET_UTF8), "making a text type");
  checked(H5Tset_strpad(type, H5T_STR_NULLPAD), "making a text type");
  set_attribute(object, name, type, text.c_str());
}
void set_attribute(hid_t object, const char* name, double value) {
  set_attribute(object, name, H5T_NATIVE_DOUBLE, &value);
}
void set_attribute(hid_t object, const char* name, std::int64_t value) {
  set_attribute(object, name, H5T_NATIVE_INT64, &value);
}

double number_attribute(hid_t object, const char* name) {
  const ReadGuard guard(object);
  const Handle attribute = open_scalar_attribute(object, name);
  double value = 0;
  checked(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), std::string("reading attribute ") + name);
  return value;
}

std::optional<std::int64_t> whole_attribute(hid_t parent, const std::string& dataset, const char* name) {
  const ReadGuard guard(parent);
  const Handle set(H5Dopen2(parent, dataset.c_str(), H5P_DEFAULT), H5Dclose, "opening dataset " + dataset);
  if (H5Aexists(set, name) <= 0) return std::nullopt;
  const Handle attribute = open_scalar_attribute(set, name);
  std::int64_t value = 0;
  checked(H5Aread(attribute, H5T_NATIVE_INT64, &value), std::string("reading attribute ") + name);
  return value;
}

void flush(hid_t file) {
  const std::shared_ptr<WriteStatus> status = status_of(file);
  const std::int64_t flushed = H5Fflush(file, H5F_SCOPE_GLOBAL);
  status->check();
  checked(flushed, "writing " + status->path.string());
}

void flush_to_disk(hid_t file) {
  flush(file);
  sync_file(status_of(file)->path);
}

}  // namespace subsoil::sim::h5
