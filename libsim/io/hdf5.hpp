#pragma once
#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The little of HDF5 that the program uses: handles that close themselves, one checker, whole arrays in and out.
namespace subsoil::sim::h5 {

/// Passes a non-negative return code on; throws std::runtime_error with `doing` and HDF5's own reason otherwise.
std::int64_t checked(std::int64_t code, const std::string& doing);

class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& doing) : id_(checked(id, doing)), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT: every HDF5 call takes one

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// Memory type of a number.
template <class T>
hid_t type_of();

/// A dataset of `rows` x `columns` (columns == 1: one-dimensional) as it shall lie in the file.
struct Layout {
  hsize_t rows = 0, columns = 1;
  hid_t file_type = -1;
  int compression = -1;  ///< gzip level 0..9 with byte shuffle in front; negative: contiguous
};

Handle create_file(const std::filesystem::path& path);
Handle open_file(const std::filesystem::path& path);
/// `name_bytes`: room for the names of what will be linked in it; 0: HDF5's own guess.
Handle create_group(hid_t parent, const std::string& name, std::size_t name_bytes = 0);
bool exists(hid_t parent, const std::string& path);
/// An object of a file that may be damaged, under a guard (read_guard.hpp).
Handle open_group(hid_t parent, const std::string& name);
/// Names of the links of a group.
std::vector<std::string> names_in(hid_t parent, const std::string& group);
/// File that a link of a group leads to, by its path; empty where it leads to no other file.
std::filesystem::path external_target(hid_t parent, const std::string& group, const std::string& name);
/// Of all datasets below, with their groups: "bed/ids".
std::vector<std::string> dataset_names(hid_t parent);

/// A dataset with its data that nothing leads to yet; it is gone when closed without a link(). `name` is for messages.
Handle write_unlinked(hid_t file, const std::string& name, const void* data, hid_t memory_type, const Layout& layout);
/// Gives an object a name; groups on the way are made.
void link(hid_t object, hid_t parent, const std::string& name);
/// Both.
void write(hid_t parent, const std::string& name, const void* data, hid_t memory_type, const Layout& layout);
template <class T>
void write(hid_t parent, const std::string& name, std::span<const T> values, hsize_t columns = 1,
           int compression = -1) {
  write(parent, name, values.data(), type_of<T>(), {values.size() / columns, columns, type_of<T>(), compression});
}
void write_text(hid_t parent, const std::string& name, const std::vector<std::string>& lines);

/// Shape of a dataset; a missing one throws std::runtime_error.
std::vector<hsize_t> shape(hid_t parent, const std::string& name);
/// What the numbers of a dataset are.
struct NumberKind {
  bool real = true;  ///< else whole numbers
  int bytes = 0;     ///< of each
};
NumberKind kind_of(hid_t parent, const std::string& name);
/// All values in row order. The class (integer, float) must be T's: a float read as an integer is a mistake, not a
/// wish.
template <class T>
std::vector<T> read(hid_t parent, const std::string& name);
std::vector<std::string> read_text(hid_t parent, const std::string& name);

void set_attribute(hid_t object, const char* name, const std::string& text);
void set_attribute(hid_t object, const char* name, double value);
void set_attribute(hid_t object, const char* name, std::int64_t value);
double number_attribute(hid_t object, const char* name);
/// A whole number kept with a dataset; none if there is none.
std::optional<std::int64_t> whole_attribute(hid_t parent, const std::string& dataset, const char* name);

/// Hands everything written so far to the system, where a kill of this process cannot reach it.
void flush(hid_t file);
/// Everything written so far is on the disk when this returns, metadata and data.
void flush_to_disk(hid_t file);

}  // namespace subsoil::sim::h5
