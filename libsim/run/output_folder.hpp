#pragma once
#include <filesystem>
#include <optional>
#include <string>

/// The folder of a run's results: who may write into it.
namespace subsoil::sim {

/// Throws ScenarioError unless results may go there: it can be made, or is empty, or `force` is given.
void refuse_folder(const std::filesystem::path& folder, bool force);

/// Keeps a second run out of a folder for as long as it lives, by a lock of the system on DIR/run.lock, which goes with
/// the process however it ends. The file has room that a summary may take when the disk is full.
class FolderLock {
 public:
  /// Makes the folder where there is none. Throws ScenarioError naming the other run when it is locked.
  explicit FolderLock(const std::filesystem::path& folder);
  /// Also takes away the folder, if this made it and nothing was put into it.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  /// Writes how far the run is into DIR/run.lock, for who looks at it meanwhile (reported_progress()).
  void report_progress(const std::string& text);
  /// Gives the room back.
  void free_reserve();

 private:
  std::filesystem::path folder_, file_, made_;  ///< made_: the first folder on the way that was not there
  int descriptor_ = -1;
};

/// What the run that is active in a folder reported last, "" before it did; nullopt: none is active. Of a run on
/// another computer it is not known whether it has ended: it counts as active.
std::optional<std::string> reported_progress(const std::filesystem::path& folder);

}  // namespace subsoil::sim
