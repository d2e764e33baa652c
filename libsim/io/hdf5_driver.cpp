#include "libsim/io/hdf5_driver.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "libsim/io/disk.hpp"

namespace subsoil::sim::h5 {
namespace {

/// The public part comes first, as HDF5 wants it.
struct File {
  H5FD_t pub{};
  int descriptor = -1;
  haddr_t end_of_addresses = 0, end_of_file = 0;
  std::shared_ptr<WriteStatus> status = std::make_shared<WriteStatus>();
  struct Kept {
    haddr_t at;
    std::vector<unsigned char> bytes;
  };
  std::vector<Kept> kept;  ///< what was written after a failure, in order
};

File& of(H5FD_t* file) { return *reinterpret_cast<File*>(file); }
const File& of(const H5FD_t* file) { return *reinterpret_cast<const File*>(file); }

H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
  int how = O_CLOEXEC | ((flags & H5F_ACC_RDWR) != 0 ? O_RDWR : O_RDONLY);
  if ((flags & H5F_ACC_TRUNC) != 0) how |= O_TRUNC;
  if ((flags & H5F_ACC_CREAT) != 0) how |= O_CREAT;
  const int descriptor = ::open(name, how, 0666);
  if (descriptor < 0) return nullptr;
  struct stat st {};
  if (::fstat(descriptor, &st) != 0) {
    ::close(descriptor);
    return nullptr;
  }
  auto* file = new File;
  file->descriptor = descriptor;
  file->end_of_file = static_cast<haddr_t>(st.st_size);
  file->status->path = name;
  return &file->pub;
}

herr_t close(H5FD_t* file) {
  File* const f = &of(file);
  if (::close(f->descriptor) != 0 && f->status->error == 0) f->status->error = errno;
  delete f;
  return 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t get_eoa(const H5FD_t* file, H5FD_mem_t) { return of(file).end_of_addresses; }
herr_t set_eoa(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  of(file).end_of_addresses = end;
  return 0;
}
haddr_t get_eof(const H5FD_t* file, H5FD_mem_t) { return of(file).end_of_file; }

herr_t get_handle(H5FD_t* file, hid_t, void** handle) {
  *handle = &of(file).status;
  return 0;
}

/// Whole blocks at a place; false with errno otherwise.
bool write_all(int descriptor, haddr_t at, const unsigned char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t done = ::pwrite(descriptor, bytes, size, static_cast<off_t>(at));
    if (done < 0 && errno == EINTR) continue;
    if (done == 0) errno = EIO;
    if (done <= 0) return false;
    bytes += done, at += static_cast<haddr_t>(done), size -= static_cast<std::size_t>(done);
  }
  return true;
}

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* buffer) {
  File& f = of(file);
  auto* out = static_cast<unsigned char*>(buffer);
  std::size_t have = 0;
  while (have < size) {
    const ssize_t done = ::pread(f.descriptor, out + have, size - have, static_cast<off_t>(at + have));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return -1;
    if (done == 0) break;
    have += static_cast<std::size_t>(done);
  }
  std::memset(out + have, 0, size - have);
  for (const File::Kept& k : f.kept) {
    const haddr_t from = std::max(at, k.at), to = std::min<haddr_t>(at + size, k.at + k.bytes.size());
    if (from < to) std::memcpy(out + (from - at), k.bytes.data() + (from - k.at), to - from);
  }
  return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* buffer) {
  File& f = of(file);
  const auto* bytes = static_cast<const unsigned char*>(buffer);
  if (f.status->error == 0 && !write_all(f.descriptor, at, bytes, size)) {
    f.status->error = errno;
    f.status->needed = std::max(at + size, f.end_of_addresses);
  }
  if (f.status->error != 0) f.kept.push_back({at, {bytes, bytes + size}});
  f.end_of_file = std::max(f.end_of_file, at + size);
  return 0;
}

herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  File& f = of(file);
  if (f.end_of_file == f.end_of_addresses) return 0;
  if (f.status->error == 0 && ::ftruncate(f.descriptor, static_cast<off_t>(f.end_of_addresses)) != 0) {
    f.status->error = errno;
    f.status->needed = f.end_of_addresses;
  }
  f.end_of_file = f.end_of_addresses;
  return 0;
}

int compare(const H5FD_t* a, const H5FD_t* b) { return a < b ? -1 : a > b ? 1 : 0; }

H5FD_class_t driver_class() {
  H5FD_class_t c{};
  c.name = "subsoil";
  c.maxaddr = static_cast<haddr_t>(1) << 62;
  c.fc_degree = H5F_CLOSE_WEAK;
  c.open = open, c.close = close, c.cmp = compare, c.query = query;
  c.get_eoa = get_eoa, c.set_eoa = set_eoa, c.get_eof = get_eof, c.get_handle = get_handle;
  c.read = read, c.write = write, c.truncate = truncate;
  const H5FD_mem_t one_list[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(one_list), std::end(one_list), c.fl_map);
  return c;
}

}  // namespace

void WriteStatus::check() const {
  if (error != 0) refuse_write(path, error, needed);
}

hid_t checked_driver() {
  static const H5FD_class_t its_class = driver_class();
  static const hid_t driver = checked(H5FDregister(&its_class), "registering the file driver");
  return driver;
}

std::shared_ptr<WriteStatus> status_of(hid_t file) {
  void* handle = nullptr;
  checked(H5Fget_vfd_handle(file, H5P_DEFAULT, &handle), "looking at the state of a file");
  return *static_cast<std::shared_ptr<WriteStatus>*>(handle);
}

void close_file(Handle& file) {
  const std::shared_ptr<WriteStatus> status = status_of(file);
  const std::int64_t flushed = H5Fflush(file, H5F_SCOPE_GLOBAL);
  { const Handle closing = std::move(file); }
  status->check();
  checked(flushed, "writing " + status->path.string());
}

void link_external(hid_t file, const std::string& name, const std::string& target_file, const std::string& target) {
  checked(H5Lcreate_external(target_file.c_str(), target.c_str(), file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
          "naming " + name);
}

}  // namespace subsoil::sim::h5
