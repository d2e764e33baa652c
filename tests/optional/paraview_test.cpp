#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "libsim/post/fields.hpp"
#include "tests/tools/program_runs.hpp"

/// ParaView opens what a run and `subsoil fields` leave, with forces of contacts, loads on triangles and tensors. Left
/// out where there is no pvpython (scripts/setup --pictures).
namespace subsoil::sim::test::paraview_test {
namespace {

std::string read_by_paraview(const std::filesystem::path& file) {
  const std::string command =
      "pvpython " + subsoil::test::source_dir() + "/tests/optional/paraview_read.py " + file.string() + " 2>&1";
  std::string text;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  char line[4096];
  while (std::fgets(line, sizeof line, pipe.get()) != nullptr) text += line;
  return text;
}

/// Of a block: the line that begins with its name.
std::string line_of(const std::string& text, const std::string& block) {
  const std::size_t at = text.find("\n" + block + "|");
  return at == std::string::npos ? "" : text.substr(at + 1, text.find('\n', at + 1) - at - 1);
}

TEST(ParaView, OpensFramesWithContactsAndLoadsAndFields) {
  if (std::system("command -v pvpython >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "no pvpython: scripts/setup --pictures installs it";
  const RunDirectory dir;
  const std::vector<std::string> sets{"output.contact forces=yes", "machine.surfaces.blade.wear.finnie=1e-12 1/Pa",
                                      "output.every=50 ms"};
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out", sets), exit_ok);
  const std::string frames = read_by_paraview(dir / "out" / "run.xdmf2");
  const std::string asked = read_by_paraview(dir / "out" / "run.xdmf");
  EXPECT_EQ(frames.substr(0, frames.find("\nreaders ")), asked.substr(0, asked.find("\nreaders ")));
  EXPECT_NE(frames.find("\nreaders 1\n"), std::string::npos) << "it opens without a question";
  EXPECT_EQ(frames.find("times 4 0.15"), 0U) << frames;
  const auto file = h5::open_file(dir / "out" / "run.h5");
  const std::size_t lines = h5::shape(file, "/frames/000003/contact forces/ids").at(0);
  EXPECT_EQ(line_of(frames, "contact forces"),
            "contact forces|" + std::to_string(2 * lines) + "|" + std::to_string(lines) + "||force:3,normal force:1")
      << frames;
  EXPECT_EQ(line_of(frames, "blade"), "blade|8|12||Finnie wear depth:1,mean pressure:1,normal work:1,shear work:1")
      << frames;

  const FieldsReport report = write_fields({.run = dir / "out", .all = true});
  const std::string fields = read_by_paraview(report.xdmf);
  EXPECT_NE(fields.find("\nreaders 1\n"), std::string::npos) << fields;
  EXPECT_EQ(fields.find("times 4 0.15"), 0U) << fields;
  EXPECT_NE(fields.find("|" + std::to_string(report.grid.size()) + "|"), std::string::npos) << fields;
  EXPECT_NE(
      fields.find("bulk density:1,contact stress:9,coordination:1,kinetic stress:9,porosity:1,pressure:1,velocity:3"),
      std::string::npos)
      << fields;
  const FieldsReport cut = write_fields({.run = dir / "out", .out = dir / "cut", .section = FieldSection{2, 0.0}});
  const std::string section = read_by_paraview(cut.xdmf);
  EXPECT_NE(section.find("|" + std::to_string(cut.grid.n[0] * cut.grid.n[1]) + "|"), std::string::npos) << section;
}

}  // namespace
}  // namespace subsoil::sim::test::paraview_test
