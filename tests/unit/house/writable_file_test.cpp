// Benchmarks settle a bed for a minute before they write it: where it goes is tried first.
#include "bench/writable_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace subsoil::bench::writable_file_test {
namespace {

namespace fs = std::filesystem;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("subsoil_writable_" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

TEST(WritableFile, MakesAFolderThatIsMissing) {
  const Folder folder;
  const fs::path file = folder.path / "a" / "b" / "tile.csv";
  EXPECT_NO_THROW(require_writable(file.string()));
  EXPECT_TRUE(fs::is_directory(file.parent_path()));
  EXPECT_TRUE(fs::is_empty(file.parent_path())) << "nothing is left of the trial";
}

TEST(WritableFile, RefusesWhatCannotBeAFolder) {
  const Folder folder;
  std::ofstream(folder.path / "taken") << "a file";
  try {
    require_writable((folder.path / "taken" / "tile.csv").string());
    FAIL() << "no refusal";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find((folder.path / "taken").string()), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace subsoil::bench::writable_file_test
