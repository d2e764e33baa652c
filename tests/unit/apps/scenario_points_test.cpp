// Points from CSV files: columns are taken by their names, each in its own unit.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "libsim/scenario/load.hpp"

namespace subsoil::sim::scenario_points_test {
namespace {

class ScenarioPoints : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return file(name);
  }
  /// What a scenario with these points reads as, each default explicit; else the refusal.
  std::string read(const std::string& points) const {
    try {
      return write_scenario(load_scenario(write("run.yaml", before_ + points + after_)).scenario);
    } catch (const ScenarioError& e) {
      return e.lines.at(0);
    }
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("subsoil_points_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
  std::string before_ = "subsoil: 1\ntime: {end: 1 s}\nmaterials: {g: {density: 2000 kg/m^3}}\n";
  std::string after_;
};

struct Key {
  std::string name, before, after;
};
const std::string body = "machine:\n  bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 3 4 m}}\n";
const std::vector<Key> keys = {
    {"boundaries.extrude",
     "contacts: [{between: [g, g], law: linear, k_n: 9 N/m, restitution: 0.5, mu: 0.5}]\n"
     "soil:\n  container: {size: 1 1 1 m, at: 0 0 0 m, material: g}\n"
     "  bed: {fill: particles, material: g, particles: [{position: 0.5 0.9 0.5 m, radius: 1 mm}]}\n"
     "boundaries: [{name: b, material: g, shape: {extrude: ",
     ", width: 1 m}}]\n"},
    {"surfaces.extrude", body + "  surfaces: {s: {body: a, material: g, extrude: ", ", width: 1 m}}\n"},
    {"outline", "machine:\n  bodies: {a: {mass: 1 kg, inertia: 1 kg m^2, at: 3 4 m, outline: ", "}}\n"},
    {"beams.points",
     "machine:\n  beams: {b: {points: ", ", section: {circle: 9 mm}, young's modulus: 2 GPa, density: 1 kg/m^3}}\n"},
    {"curve", body + "  joints: {j: {point on curve: [ground, a], curve: ", ", point: 0 0 m}}\n"},
    {"polygon", body + "  forces: {f: {outline contact: [ground, a], first: {polygon: ",
     "}, second: {disk: 1 m}, stiffness: 1 N/m, n: 1}}\n"},
    {"flank", body + "  forces: {f: {outline contact: [ground, a], first: {flank: ",
     "}, second: {disk: 1 mm}, stiffness: 1 N/m, n: 1}}\n"}};

// The oracle is the list: its points carry their units themselves.
TEST_F(ScenarioPoints, ColumnsAreTakenByNameAndUnit) {
  write("plain.csv", "x [m],y [m]\n0,0\n0.25,0.5\n-0.5,0.75\n");
  write("units.csv", "x [cm],y [mm]\n0,0\n25,500\n-50,750\n");
  write("turned.csv", "# turned\r\n\r\n\"y [mm]\" , x [m]\r\n0, 0\r\n500, +0.25\r\n750, -5e-1\r\n");
  const std::string common = before_;
  for (const Key& key : keys) {
    before_ = common + key.before, after_ = key.after;
    const std::string list = read("[0 0 m, 0.25 0.5 m, -0.5 0.75 m]");
    EXPECT_NE(list.find("-0.5 0.75 m"), std::string::npos) << key.name << ": " << list;
    for (const char* name : {"plain.csv", "units.csv", "turned.csv"}) EXPECT_EQ(read(name), list) << key.name << name;
  }
}

TEST_F(ScenarioPoints, RefusalsNameFileLineAndCure) {
  before_ += keys.front().before, after_ = keys.front().after;
  const auto expect = [&](const std::string& text, const std::string& refusal) {
    write("p.csv", text);
    const std::string got = read("p.csv"), place = "p.csv" + refusal;
    EXPECT_TRUE(got.ends_with(place)) << got << "\nexpected: " << place;
    EXPECT_NE(got.find("run.yaml:8:"), std::string::npos) << got;
  };
  const std::string cure = "must be a header such as x [mm], y [mm]";
  expect("x, y\n0,0\n", ":1: column 'x' has no unit; " + cure);
  expect("x [m], y\n0,0\n", ":1: column 'y' has no unit; " + cure);
  expect("#\nz [m], x [m]\n0,0\n", ":2: column 'z' is unknown; " + cure);
  expect("0,0\n1,0\n", ":1: column '0' is unknown; " + cure);
  expect("x [m], x [m]\n0,0\n", ":1: column 'x' stands twice; name one of them y");
  expect("x [m], y [kg]\n0,0\n", ":1: y = 1: `kg` is a mass (kg), but needed is a length (m), such as m");
  expect("x [m], y [m], z [m]\n0,0,0\n", ":1: holds 3 columns; must be two, x and y");
  expect("x [m], y [m]\n0,0\n1\n", ":3: holds 1 columns; must be two, x and y");
  expect("x [m], y [m]\n0,0\n1,0\n", ": an outline needs at least three points");
}

}  // namespace
}  // namespace subsoil::sim::scenario_points_test
