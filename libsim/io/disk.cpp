#include "libsim/io/disk.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace subsoil::sim {
namespace {

std::string bytes_text(double bytes) {
  const char* unit = "bytes";
  for (const char* larger : {"kB", "MB", "GB", "TB"}) {
    if (bytes < 1e3) break;
    bytes /= 1e3, unit = larger;
  }
  return fmt::format("{:.3g} {}", bytes, unit);
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  const auto folder = path.parent_path();
  return folder.empty() ? "." : folder;
}

const char* cure_of(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "make room there, then continue: a run by `subsoil resume`, a study by the command that began it";
    case EFBIG:
      return "the limit on the size of a file (ulimit -f) is too low";
    case EMFILE:
    case ENFILE:
      return "the limit on open files (ulimit -n) is too low";
    case ENOENT:
      return "the folder has been deleted or moved during the run";
    case EROFS:
    case EACCES:
    case EPERM:
      return "the folder cannot be written to; it has been made read-only, or belongs to somebody else";
    default:
      return "the disk reports a fault; results up to the last complete file are kept";
  }
}

}  // namespace

void refuse_write(const std::filesystem::path& path, int error, std::uint64_t needed) {
  std::string text = fmt::format("cannot write {}: {}", path.string(), std::strerror(error));
  if (needed > 0) text += fmt::format("; {} are needed", bytes_text(static_cast<double>(needed)));
  if (const auto free = free_bytes(path)) {
    text += needed > 0 ? "," : ";";
    text += fmt::format(" {} are free there", bytes_text(static_cast<double>(*free)));
  }
  throw DiskFault(text + "; " + cure_of(error));
}

std::optional<std::uint64_t> free_bytes(const std::filesystem::path& path) {
  struct statvfs of {};
  std::filesystem::path folder = folder_of(path);
  while (::statvfs(folder.c_str(), &of) != 0) {
    if (errno != ENOENT || folder == folder.root_path() || folder.parent_path() == folder) return std::nullopt;
    folder = folder_of(folder);
  }
  return static_cast<std::uint64_t>(of.f_bavail) * of.f_frsize;
}

void require_space(const std::filesystem::path& path, std::uint64_t needed) {
  const auto free = free_bytes(path);
  if (free && *free < needed) refuse_write(path, ENOSPC, needed);
}

namespace {

void sync_path(const std::filesystem::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
  if (descriptor < 0) refuse_write(path, errno);
  const int failed = ::fsync(descriptor) != 0 ? errno : 0;
  ::close(descriptor);
  // Some network file systems have no fsync of a folder: their renames are on the server then.
  if (failed != 0 && !(failed == EINVAL && (flags & O_DIRECTORY) != 0)) refuse_write(path, failed);
}

}  // namespace

void sync_folder(const std::filesystem::path& folder) {
  sync_path(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
}
void sync_file(const std::filesystem::path& path) { sync_path(path, O_RDONLY); }

OutFile::OutFile(std::filesystem::path path, std::optional<std::uint64_t> keep) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (keep ? 0 : O_TRUNC), 0666);
  if (descriptor_ < 0) refuse_write(path_, errno);
  if (!keep) return;
  size_ = *keep;
  if (::ftruncate(descriptor_, static_cast<off_t>(size_)) == 0 && ::lseek(descriptor_, 0, SEEK_END) >= 0) return;
  const int error = errno;
  ::close(descriptor_);
  refuse_write(path_, error);
}

OutFile::~OutFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutFile::write(std::string_view bytes) {
  const std::size_t all = bytes.size();
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) refuse_write(path_, done < 0 ? errno : EIO, all);
    bytes.remove_prefix(static_cast<std::size_t>(done));
    size_ += static_cast<std::uint64_t>(done);
  }
}

void OutFile::sync() {
  if (::fdatasync(descriptor_) != 0) refuse_write(path_, errno, size_);
}

void OutFile::close() {
  const int descriptor = std::exchange(descriptor_, -1);
  if (descriptor >= 0 && ::close(descriptor) != 0) refuse_write(path_, errno, size_);
}

}  // namespace subsoil::sim
