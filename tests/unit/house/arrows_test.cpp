// The arrows of the house: which room may include what (docs/developers/architecture.md).
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
     {"boost/math/", "cvode/", "ida/", "nvector/", "sunlinsol/", "sunmatrix/", "sunnonlinsol/", "sundials/"}},
    {"coupling", {"coupling/", "libdem/", "libmbd/"}, {"Eigen/"}, {}},
    {"libsim",
     {"libsim/", "coupling/", "libdem/", "libmbd/"},
     {"Eigen/", "fmt/", "hdf5.h", "malloc.h", "nlohmann/", "omp.h", "spdlog/", "sys/resource.h"},
     {"CGAL/", "H5", "boost/asio/", "boost/beast/", "boost/geometry/", "boost/math/", "fcntl.h", "libdeflate.h",
      "minizip/zip.h", "nlopt.hpp", "sched.h", "spawn.h", "sys/", "udunits2.h", "unistd.h", "unsupported/Eigen/",
      "yaml-cpp/"}},
    {"python", {"libsim/"}, {"nanobind/"}, {}},
};

/// A room inside a library, or a header of its root: what its files are called and which of the rooms before it they
/// may include; its own they always may.
struct InnerRoom {
  std::string start;               ///< of its files' names
  std::vector<std::string> above;  ///< starts of rooms
};

/// From the foundations up: no room knows one below it in this list.
const std::vector<InnerRoom> inner_rooms = {
    {"libdem/base/", {}},
    {"libdem/geometry/", {"libdem/base/"}},
    {"libdem/particles/", {"libdem/base/", "libdem/geometry/"}},
    {"libdem/simd/", {"libdem/base/"}},
    {"libdem/impact/", {"libdem/base/"}},
    {"libdem/laws/", {"libdem/base/", "libdem/simd/", "libdem/impact/"}},
    {"libdem/neighbours/", {"libdem/base/", "libdem/geometry/", "libdem/particles/"}},
    {"libdem/contacts/",
     {"libdem/base/", "libdem/geometry/", "libdem/particles/", "libdem/laws/", "libdem/neighbours/"}},
    {"libdem/kernel/", {"libdem/base/", "libdem/particles/", "libdem/simd/", "libdem/laws/", "libdem/contacts/"}},
    {"libdem/sphere_force.hpp", {"libdem/base/", "libdem/geometry/"}},
    {"libdem/bed.hpp",
     {"libdem/base/", "libdem/geometry/", "libdem/particles/", "libdem/laws/", "libdem/contacts/bond_record.hpp",
      "libdem/contacts/contact_record.hpp", "libdem/contacts/histories.hpp", "libdem/sphere_force.hpp"}},
    {"libdem/bed_engine.hpp", {"libdem/bed.hpp"}},
    {"libdem/own_law.hpp", {"libdem/laws/", "libdem/kernel/"}},
    {"libdem/step/",
     {"libdem/base/", "libdem/geometry/", "libdem/particles/", "libdem/laws/", "libdem/neighbours/", "libdem/contacts/",
      "libdem/kernel/", "libdem/bed.hpp", "libdem/bed_engine.hpp", "libdem/sphere_force.hpp"}},
    {"libdem/packing/", {"libdem/base/", "libdem/geometry/", "libdem/particles/", "libdem/laws/", "libdem/bed.hpp"}},
    {"libdem/bed_impact.", {"libdem/particles/", "libdem/impact/", "libdem/laws/", "libdem/bed.hpp"}},
    {"libmbd/base/", {}},
    {"libmbd/element/", {"libmbd/base/"}},
    {"libmbd/joints/", {"libmbd/base/", "libmbd/element/"}},
    {"libmbd/drivers/", {"libmbd/base/", "libmbd/element/"}},
    {"libmbd/forces/", {"libmbd/base/", "libmbd/element/", "libmbd/joints/"}},
    {"libmbd/controllers/", {"libmbd/base/", "libmbd/element/"}},
    {"libmbd/controllers.hpp", {"libmbd/controllers/"}},
    {"libmbd/elements.hpp", {"libmbd/joints/", "libmbd/drivers/", "libmbd/forces/"}},
    {"libmbd/system/",
     {"libmbd/base/", "libmbd/element/", "libmbd/joints/", "libmbd/forces/", "libmbd/controllers/",
      "libmbd/controllers.hpp", "libmbd/elements.hpp"}},
    {"libmbd/measures", {"libmbd/forces/", "libmbd/controllers/", "libmbd/system/"}},
    {"libmbd/assembly/", {"libmbd/base/", "libmbd/controllers.hpp", "libmbd/system/"}},
    {"libmbd/integrators/",
     {"libmbd/base/", "libmbd/controllers.hpp", "libmbd/elements.hpp", "libmbd/system/", "libmbd/assembly/"}},
    {"libmbd/search/", {"libmbd/integrators/"}},
    {"libmbd/equilibrium/",
     {"libmbd/base/", "libmbd/forces/", "libmbd/elements.hpp", "libmbd/system/", "libmbd/assembly/",
      "libmbd/integrators/"}},
    {"libmbd/machine.",
     {"libmbd/controllers.hpp", "libmbd/elements.hpp", "libmbd/system/", "libmbd/measures", "libmbd/assembly/",
      "libmbd/integrators/", "libmbd/equilibrium/"}},
    {"libsim/base/", {}},
    {"libsim/document/", {"libsim/base/"}},
    {"libsim/io/", {"libsim/base/"}},
    {"libsim/keys/", {"libsim/base/", "libsim/document/", "libsim/io/csv.hpp", "libsim/io/csv_separator.hpp"}},
    {"libsim/scenario/", {"libsim/base/", "libsim/document/", "libsim/keys/"}},
    {"libsim/setup/", {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/scenario/"}},
    {"libsim/post/", {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/scenario/"}},
    {"libsim/run/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/scenario/", "libsim/setup/", "libsim/post/"}},
    {"libsim/plot/", {"libsim/base/", "libsim/io/", "libsim/scenario/", "libsim/setup/", "libsim/post/"}},
    {"libsim/fmu/", {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/scenario/", "libsim/run/"}},
    {"libsim/view/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/scenario/", "libsim/setup/", "libsim/post/",
      "libsim/run/"}},
    {"libsim/report/", {"libsim/base/", "libsim/io/", "libsim/scenario/", "libsim/post/", "libsim/view/"}},
    {"libsim/studies/laboratory/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/keys/", "libsim/scenario/", "libsim/setup/",
      "libsim/plot/"}},
    {"libsim/studies/impact/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/keys/", "libsim/scenario/", "libsim/plot/"}},
    {"libsim/studies/calibrate/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/keys/", "libsim/scenario/", "libsim/plot/",
      "libsim/studies/laboratory/"}},
    {"libsim/studies/sweep/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/keys/", "libsim/scenario/", "libsim/post/",
      "libsim/report/"}},
    {"libsim/studies/design/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/keys/", "libsim/scenario/", "libsim/studies/calibrate/",
      "libsim/studies/sweep/"}},
    {"libsim/studies/wear/",
     {"libsim/base/", "libsim/document/", "libsim/io/", "libsim/scenario/", "libsim/setup/", "libsim/post/",
      "libsim/plot/", "libsim/studies/sweep/"}},
    {"libsim/studies/credibility/", {"libsim/base/", "libsim/scenario/", "libsim/setup/", "libsim/studies/sweep/"}},
    {"libsim/studies/sections.cpp",
     {"libsim/keys/", "libsim/studies/laboratory/", "libsim/studies/impact/", "libsim/studies/calibrate/",
      "libsim/studies/sweep/", "libsim/studies/design/"}},
};

bool starts_with_any(const std::string& name, const std::vector<std::string>& starts) {
  return std::any_of(starts.begin(), starts.end(), [&](const std::string& s) { return name.rfind(s, 0) == 0; });
}

/// Headers of the C++ standard library have neither a folder nor a suffix; everything else has.
bool is_standard(const std::string& name) { return name.find_first_of("./") == std::string::npos; }

/// The room of a file of a library, by its name; null for none.
const InnerRoom* room_of(const std::string& name) {
  const auto at = std::find_if(inner_rooms.begin(), inner_rooms.end(),
                               [&](const InnerRoom& r) { return name.rfind(r.start, 0) == 0; });
  return at == inner_rooms.end() ? nullptr : &*at;
}

bool allowed(const Room& room, bool quoted, const std::string& name, bool in_source) {
  if (quoted) return starts_with_any(name, room.rooms);
  return is_standard(name) || starts_with_any(name, room.libraries) ||
         (in_source && starts_with_any(name, room.libraries_inside));
}

/// "file:line: includes NAME" for each include of a text for which `keeps(quoted, name)` does not hold.
template <class Keeps>
std::vector<std::string> includes_against(const std::string& file, const std::string& text, const Keeps& keeps) {
  static const std::regex include(R"(^\s*#\s*include\s*(["<])([^">]+)[">].*)");
  std::vector<std::string> found;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (!std::regex_match(line, match, include)) continue;
    if (!keeps(match[1] == "\"", match[2].str()))
      found.push_back(file + ":" + std::to_string(number) + ": includes " + match[2].str());
  }
  return found;
}

std::vector<std::string> violations(const Room& room, const std::string& file, const std::string& text) {
  return includes_against(file, text, [&](bool quoted, const std::string& name) {
    return allowed(room, quoted, name, fs::path(file).extension() == ".cpp");
  });
}

bool same_library(const std::string& a, const std::string& b) {
  return a.substr(0, a.find('/')) == b.substr(0, b.find('/'));
}

/// Likewise inside a library; `file` as it is included. What it may know of other libraries is the rule above.
std::vector<std::string> violations_inside(const std::string& file, const std::string& text) {
  const InnerRoom* room = room_of(file);
  if (room == nullptr) return {file + ": is in no room"};
  return includes_against(file, text, [&](bool quoted, const std::string& name) {
    return !quoted || name.rfind(room->start, 0) == 0 || starts_with_any(name, room->above) ||
           !same_library(name, file);
  });
}

/// use(name from the checkout's root, text) for each source below a folder; returns how many.
template <class Use>
int each_source(const std::string& folder, const Use& use) {
  const fs::path root = subsoil::test::source_dir();
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    const std::string suffix = entry.path().extension().string();
    if (suffix != ".cpp" && suffix != ".hpp" && suffix != ".h") continue;
    if (entry.path().parent_path().filename() == "vendor") continue;  // of others, kept as they are
    std::ifstream in(entry.path());
    std::stringstream text;
    text << in.rdbuf();
    ++files;
    use(fs::relative(entry.path(), root).generic_string(), text.str());
  }
  return files;
}

TEST(Arrows, EveryRoomKeepsThem) {
  for (const Room& room : house) {
    const int files = each_source(room.folder, [&](const std::string& name, const std::string& text) {
      for (const std::string& v : violations(room, name, text))
        ADD_FAILURE() << v << ", which " << room.folder << " may not know";
    });
    EXPECT_GT(files, 0) << room.folder << ": nothing was looked at";
  }
}

TEST(Arrows, RoomsOfLibrariesKeepThem) {
  std::vector<int> files(inner_rooms.size(), 0);
  for (const std::string library : {"libdem", "libmbd", "libsim"})
    each_source(library, [&](const std::string& name, const std::string& text) {
      for (const std::string& v : violations_inside(name, text)) ADD_FAILURE() << v << ", against the order of rooms";
      if (const InnerRoom* room = room_of(name)) ++files[static_cast<std::size_t>(room - inner_rooms.data())];
    });
  for (std::size_t k = 0; k < files.size(); ++k)
    EXPECT_GT(files[k], 0) << inner_rooms[k].start << ": nothing was looked at";
}

/// Each room knows only such as stand before it: then no chain of includes closes a circle of rooms.
TEST(Arrows, RoomsOfLibrariesHaveAnOrder) {
  for (std::size_t k = 0; k < inner_rooms.size(); ++k)
    for (const std::string& name : inner_rooms[k].above) {
      const InnerRoom* known = room_of(name);
      ASSERT_NE(known, nullptr) << name;
      EXPECT_LT(known - inner_rooms.data(), static_cast<std::ptrdiff_t>(k))
          << inner_rooms[k].start << " knows " << name;
    }
}

TEST(Arrows, ScannerFindsPlantedViolations) {
  const auto broken = [](std::size_t room, const std::string& file, const std::string& line) {
    return violations(house[room], file, "#pragma once\n#include <vector>\n" + line + "\n").size();
  };
  enum : std::size_t { dem, mbd, coupling };
  EXPECT_EQ(broken(dem, "libdem/a.hpp", "#include \"libmbd/base/body.hpp\""), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "#include \"coupling/simulation.hpp\""), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "  #  include <yaml-cpp/yaml.h>  // only for a moment"), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "#include <hdf5.h>"), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.cpp", "#include <Eigen/Core>"), 1u);
  EXPECT_EQ(broken(dem, "libdem/a.hpp", "#include <boost/math/tools/roots.hpp>"), 1u) << "private to the room";
  EXPECT_EQ(broken(mbd, "libmbd/a.cpp", "#include \"libdem/base/vec3.hpp\""), 1u);
  EXPECT_EQ(broken(mbd, "libmbd/a.hpp", "#include <ida/ida.h>"), 1u) << "private to the room: .cpp only";
  EXPECT_EQ(broken(mbd, "libmbd/a.cpp", "#include <udunits2.h>"), 1u);
  EXPECT_EQ(broken(coupling, "coupling/a.cpp", "#include \"libsim/run/runner.hpp\""), 1u);
  EXPECT_EQ(broken(coupling, "coupling/a.cpp", "#include <fmt/format.h>"), 1u);
  EXPECT_EQ(broken(coupling, "coupling/a.cpp", "#include <CLI/CLI.hpp>"), 1u);
}

TEST(Arrows, ScannerFindsPlantedViolationsInsideLibdem) {
  const auto broken = [](const std::string& file, const std::string& name) {
    return violations_inside(file, "#pragma once\n#include <vector>\n#include \"" + name + "\"\n").size();
  };
  EXPECT_EQ(broken("libdem/contacts/bonds.hpp", "libdem/step/bed_impl.hpp"), 1u);
  EXPECT_EQ(broken("libdem/contacts/bonds.cpp", "libdem/bed.hpp"), 1u);
  EXPECT_EQ(broken("libdem/neighbours/grid.hpp", "libdem/contacts/blocks.hpp"), 1u);
  EXPECT_EQ(broken("libdem/particles/statistics.cpp", "libdem/step/bed_impl.hpp"), 1u);
  EXPECT_EQ(broken("libdem/geometry/boundary.hpp", "libdem/particles/particles.hpp"), 1u);
  EXPECT_EQ(broken("libdem/impact/impact.hpp", "libdem/bed.hpp"), 1u);
  EXPECT_EQ(broken("libdem/impact/hertz.cpp", "libdem/laws/law.hpp"), 1u);
  EXPECT_EQ(broken("libdem/laws/wet.hpp", "libdem/kernel/pairs.hpp"), 1u);
  EXPECT_EQ(broken("libdem/kernel/pairs.hpp", "libdem/step/sampling.hpp"), 1u);
  EXPECT_EQ(broken("libdem/bed.hpp", "libdem/step/bed_impl.hpp"), 1u);
  EXPECT_EQ(broken("libdem/packing/settle.cpp", "libdem/step/bed_impl.hpp"), 1u);
  EXPECT_EQ(broken("libdem/base/buffer.hpp", "libdem/geometry/bounds.hpp"), 1u);
  EXPECT_EQ(broken("libsim/keys/fields.hpp", "libsim/scenario/scenario.hpp"), 1u);
  EXPECT_EQ(broken("libsim/io/csv.hpp", "libsim/run/rows.hpp"), 1u);
  EXPECT_EQ(broken("libsim/run/rows.cpp", "libsim/report/page.hpp"), 1u);
  EXPECT_EQ(broken("libsim/run/rows.cpp", "libdem/bed.hpp"), 0u);
  EXPECT_EQ(broken("libdem/stray.hpp", "libdem/base/vec3.hpp"), 1u) << "in no room";
  EXPECT_EQ(broken("libdem/step/sweep.cpp", "libdem/contacts/blocks.hpp"), 0u);
  EXPECT_EQ(broken("libdem/packing/settle.cpp", "libdem/bed.hpp"), 0u);
  EXPECT_EQ(broken("libdem/bed_impact.cpp", "libdem/bed.hpp"), 0u);
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
  const auto found = violations(house[0], "libdem/laws/wet.hpp", "#pragma once\n\n#include \"libmbd/base/body.hpp\"\n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], "libdem/laws/wet.hpp:3: includes libmbd/base/body.hpp");
}

}  // namespace
