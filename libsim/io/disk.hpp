#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

/// Files that survive: every write, flush, sync and close is looked at, and what fails names which file it was, what it
/// needed and what was free.
namespace subsoil::sim {

/// A file of the results could not be written. The message names it, the system's reason, bytes needed and free.
struct DiskFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws DiskFault for an errno. `needed` bytes; 0: not known.
[[noreturn]] void refuse_write(const std::filesystem::path& path, int error, std::uint64_t needed = 0);
/// Bytes that are free where `path` lies or shall lie; none if the system does not report it.
std::optional<std::uint64_t> free_bytes(const std::filesystem::path& path);
/// Throws DiskFault unless so many bytes are free for a file that is about to be written.
void require_space(const std::filesystem::path& path, std::uint64_t needed);
/// Its entries, files that were renamed or made in it, are on the disk when this returns.
void sync_folder(const std::filesystem::path& folder);
/// Likewise the content of a file.
void sync_file(const std::filesystem::path& path);
/// Renames the temporary of `path` (atomic_file.hpp) over it. put_in_place is this between a sync of the file and one
/// of its folder; apart for several files of one folder.
void rename_into_place(const std::filesystem::path& path);

/// A file that is written from its start to its end.
class OutFile {
 public:
  /// A new file, or with `keep` bytes the one that is there, cut to that length.
  explicit OutFile(std::filesystem::path path, std::optional<std::uint64_t> keep = std::nullopt);
  ~OutFile();
  OutFile(const OutFile&) = delete;
  OutFile& operator=(const OutFile&) = delete;

  void write(std::string_view bytes);
  void sync();   ///< what was written is on the disk
  void close();  ///< and a failure of closing is one of writing
  std::uint64_t size() const { return size_; }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace subsoil::sim
