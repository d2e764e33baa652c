#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// The Debian package of the built program, unpacked and run.
namespace subsoil::sim::package_test {
namespace {

constexpr const char* plate = R"(subsoil: 1
materials: {clay: {density: 1800 kg/m^3}}
contacts: [{between: [clay, clay], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.5}]
soil: {container: {size: 60 60 60 mm, at: 0 0 0 m, material: clay}, bed: {fill: lattice, material: clay, radius: 10 mm}}
time: {end: 1 ms}
)";

TEST(Package, UnpackedProgramRuns) {
  if (std::system("command -v cpack >/dev/null 2>&1 && command -v dpkg-deb >/dev/null 2>&1 && "
                  "command -v dpkg-shlibdeps >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "no cpack, dpkg-deb or dpkg-shlibdeps: no Debian";
  const test::Scratch scratch;
  const std::filesystem::path build = std::filesystem::path(subsoil::test::program()).parent_path().parent_path();
  const std::string here = scratch.path().string(), log = scratch / "log", root = here + "/root/usr/";
  const auto done = [&](const std::string& command) {
    return std::system(("cd " + here + " && " + command + " >" + log + " 2>&1").c_str()) == 0;
  };
  ASSERT_TRUE(done("cpack -G DEB -B packed --config " + (build / "CPackConfig.cmake").string())) << test::text_of(log);
  ASSERT_TRUE(done("dpkg-deb -f packed/*.deb Depends")) << test::text_of(log);
  for (const char* library : {"libyaml-cpp", "libsundials", "libc6"})
    EXPECT_NE(test::text_of(log).find(library), std::string::npos) << test::text_of(log);
  ASSERT_TRUE(done("dpkg-deb -x packed/*.deb root")) << test::text_of(log);
  for (const char* file : {"share/man/man1/subsoil.1", "share/bash-completion/completions/subsoil",
                           "share/subsoil/configs/templates/tine.yaml", "share/doc/subsoil/start.md",
                           "share/zsh/vendor-completions/_subsoil", "share/fish/vendor_completions.d/subsoil.fish"})
    EXPECT_TRUE(std::filesystem::exists(root + file)) << file;
  test::write_file(scratch / "plate.yaml", plate);
  EXPECT_TRUE(done("OMP_NUM_THREADS=1 root/usr/bin/subsoil run plate.yaml")) << test::text_of(log);
  EXPECT_TRUE(std::filesystem::exists(scratch / "plate/summary.json")) << test::text_of(log);
}

}  // namespace
}  // namespace subsoil::sim::package_test
