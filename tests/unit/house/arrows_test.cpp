// The arrows of the house: which room may include what (docs/architecture.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/paths.hpp"

namespace {

namespace fs = std::filesystem;

struct Room {
  std::string folder;
  std::vector<std::string> rooms;             ///< folders whose headers it may include
  std::vector<std::string> libraries;         ///< system headers beside the standard's: starts of names
  std::vector<std::string> libraries_inside;  ///< the same, in .cpp only: the room's users never see them
};

const std::vector<Room> house = {
    {"libdem", {"libdem/"}, {"omp.h", "immintrin.h"}, {"boost/math/", "sys/mman.h"}},
    {"libmbd",
     {"libmbd/"},
     {"Eigen/"},
     {"cvode/", "ida/", "nvector/", "sunlinsol/", "sunmatrix/", "sunnonlinsol/", "sundials/"}},
    {"coupling", {"coupling/", "libdem/", "libmbd/"}, {}, {}},
};

bool starts_with_any(const std::string& name, const std::vector<std::string>& starts) {
  return std::any_of(starts.begin(), starts.end(), [&](const std::string& s) { return name.rfind(s, 0) == 0; });
}

/// Headers of the C++ standard library have neither a folder nor a suffix; everything else has.
bool is_standard(const std::string& name) { return name.find_first_of("./") == std::string::npos; }

bool allowed(const Room& room, bool quoted, const std::string& name, bool in_source) {
  if (quoted) return starts_with_any(name, room.rooms);
  return is_standard(name) || starts_with_any(name, room.libraries) ||
         (in_source && starts_with_any(name, room.libraries_inside));
}

/// "file:line: includes NAME" for each include of a text that breaks the room's arrows.
std::vector<std::string> violations(const Room& room, const std::string& file, const std::string& text) {
  static const std::regex include(R"(^\s*#\s*include\s*(["<])([^">]+)[">].*)");
  std::vector<std::string> found;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (!std::regex_match(line, match, include)) continue;
    if (!allowed(room, match[1] == "\"", match[2], fs::path(file).extension() == ".cpp"))
      found.push_back(file + ":" + std::to_string(number) + ": includes " + match[2].str());
  }
  return found;
}

std::vector<std::string> violations_below(const Room& room, const fs::path& folder, int* files) {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string suffix = entry.path().extension().string();
    if (suffix != ".cpp" && suffix != ".hpp" && suffix != ".h") continue;
    std::ifstream in(entry.path());
    std::stringstream text;
    text << in.rdbuf();
    ++*files;
    for (const std::string& v : violations(room, entry.path().string(), text.str())) found.push_back(v);
  }
  return found;
}

TEST(Arrows, EveryRoomKeepsThem) {
  for (const Room& room : house) {
    int files = 0;
    for (const std::string& v : violations_below(room, fs::path(subsoil::test::source_dir()) / room.folder, &files))
      ADD_FAILURE() << v << ", which " << room.folder << " may not know";
    EXPECT_GT(files, 1) << room.folder << ": nothing was looked at";
  }
}

TEST(Arrows, ScannerFindsPlantedViolations) {
  const auto broken = [](std::size_t room, const std::string& file, const std::string& line) {
    return violations(house[room], file, "#pragma once\n#include <vector>\n" + line + "\n").size();
  };
  enum : std::size_t { dem, mbd, coupling };
  EXPECT_EQ(broken(dem, "libdem/a.hpp", "#include \"libmbd/body.hpp\""), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "#include \"coupling/simulation.hpp\""), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "  #  include <yaml-cpp/yaml.h>  // only for a moment"), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "#include <hdf5.h>"), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "#include <Eigen/Core>"), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.hpp", "#include <boost/math/tools/roots.hpp>"), 1u) << "private to the room";
  EXPECT_EQ(broken(mbd, "libmbd/a.cpp", "#include \"libdem/base/vec3.hpp\""), 1u);
  EXPECT_EQ(broken(mbd, "libmbd/a.hpp", "#include <ida/ida.h>"), 1u) << "private to the room: .cpp only";
  EXPECT_EQ(broken(mbd, "libmbd/a.cpp", "#include <udunits2.h>"), 1u);
  EXPECT_EQ(broken(coupling, "coupling/a.cpp", "#include \"apps/run/runner.hpp\""), 1u);
  EXPECT_EQ(broken(coupling, "coupling/a.cpp", "#include <fmt/format.h>"), 1u);
  EXPECT_EQ(broken(coupling, "coupling/a.cpp", "#include <CLI/CLI.hpp>"), 1u);
}

TEST(Arrows, ScannerLetsAllowedOnesPass) {
  EXPECT_TRUE(violations(house[0], "libdem/a.cpp", "#include <omp.h>\n#include <cmath>\n#include \"libdem/bed.hpp\"\n")
                  .empty());
  EXPECT_TRUE(violations(house[1], "libmbd/a.cpp", "#include <ida/ida.h>\n#include <Eigen/Dense>\n").empty());
  EXPECT_TRUE(
      violations(house[2], "coupling/a.hpp", "#include \"libdem/bed.hpp\"\n#include \"libmbd/machine.hpp\"\n").empty());
  EXPECT_TRUE(violations(house[0], "libdem/a.hpp", "// #include <yaml-cpp/yaml.h>\n").empty());
}

TEST(Arrows, ViolationNamesPlace) {
  const auto found = violations(house[0], "libdem/laws/wet.hpp", "#pragma once\n\n#include \"libmbd/body.hpp\"\n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], "libdem/laws/wet.hpp:3: includes libmbd/body.hpp");
}

}  // namespace
