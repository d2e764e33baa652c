#include "libsim/run/output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "libsim/scenario/load.hpp"

namespace subsoil::sim {
namespace {

constexpr std::size_t kReserve = 1 << 16;  // bytes; a summary takes some 10 to 40 kB
constexpr std::size_t kOwner = 128;        // bytes at the start of the file, that name who holds it

/// The first folder on the way to `folder` that is not there.
std::filesystem::path first_missing(const std::filesystem::path& folder) {
  std::filesystem::path missing, above = std::filesystem::absolute(folder).lexically_normal();
  if (!above.has_filename()) above = above.parent_path();
  while (!above.empty() && !std::filesystem::exists(above)) missing = above, above = above.parent_path();
  return missing;
}

}  // namespace

void refuse_folder(const std::filesystem::path& folder, bool force) {
  if (!std::filesystem::exists(folder)) return;
  if (!std::filesystem::is_directory(folder))
    throw ScenarioError(folder.string() + ": is a file, results need a directory; choose another --out");
  if (std::filesystem::is_empty(folder) || force) return;
  throw ScenarioError(folder.string() +
                      ": exists and is not empty; choose another --out, --force to write over it, or continue what is "
                      "there by `subsoil resume " +
                      folder.string() + "`");
}

FolderLock::FolderLock(const std::filesystem::path& folder)
    : folder_(folder), file_(folder / "run.lock"), made_(first_missing(folder)) {
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (fault) throw ScenarioError(folder.string() + ": cannot be made (" + fault.message() + "); choose another --out");
  while (true) {
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw ScenarioError(
          fmt::format("{}: cannot be written to ({}); choose another --out", folder.string(), std::strerror(errno)));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      char who[200] = {};
      [[maybe_unused]] const ssize_t read = ::pread(descriptor_, who, sizeof who - 1, 0);
      ::close(descriptor_);
      const std::string text(who);
      throw ScenarioError(fmt::format("{}: another run writes into it ({}); wait for its end, or choose another --out",
                                      folder.string(), text.substr(0, text.find('\n'))));
    }
    // The one that held it may have taken the file away meanwhile.
    struct stat here {
    }, there{};
    if (::fstat(descriptor_, &here) == 0 && ::stat(file_.c_str(), &there) == 0 && here.st_ino == there.st_ino) break;
    ::close(descriptor_);
  }
  char host[65] = {};
  ::gethostname(host, sizeof host - 1);
  std::string text = fmt::format("process {} on {}\n", ::getpid(), host);
  text.resize(kReserve, ' ');
  // A disk that has no room even for this says so with the first file of the results.
  if (::ftruncate(descriptor_, 0) == 0) {
    [[maybe_unused]] const ssize_t written = ::pwrite(descriptor_, text.data(), text.size(), 0);
  }
}

FolderLock::~FolderLock() {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
  ::close(descriptor_);
  if (made_.empty()) return;
  // Empty folders from the inside outwards.
  for (auto folder = std::filesystem::absolute(folder_).lexically_normal(); std::filesystem::remove(folder, ignored);
       folder = folder.parent_path())
    if (folder == made_) return;
}

void FolderLock::report_progress(const std::string& text) {
  // One write of all of it, so that a reader meets the old text or the new one.
  std::string line = text.substr(0, kReserve - kOwner - 1);
  line.resize(kReserve - kOwner, ' ');
  [[maybe_unused]] const ssize_t written = ::pwrite(descriptor_, line.data(), line.size(), kOwner);
}

std::optional<std::string> reported_progress(const std::filesystem::path& folder) {
  std::ifstream file(folder / "run.lock");
  std::string owner;
  if (!file || !std::getline(file, owner)) return std::nullopt;
  long process = 0;
  char host[65] = {}, here[65] = {};
  if (std::sscanf(owner.c_str(), "process %ld on %64s", &process, host) != 2) return std::nullopt;
  ::gethostname(here, sizeof here - 1);
  const bool gone = ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH;
  if (std::string(host) == here && gone) return std::nullopt;
  file.seekg(kOwner);
  std::string text(kReserve - kOwner, ' ');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(text.find_last_not_of(' ') + 1);
  return text;
}

void FolderLock::free_reserve() { [[maybe_unused]] const int done = ::ftruncate(descriptor_, 0); }

}  // namespace subsoil::sim
