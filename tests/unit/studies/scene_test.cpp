#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "libsim/view/show.hpp"
#include "libsim/view/view.hpp"
#include "tests/tools/packed.hpp"
#include "tests/tools/program_runs.hpp"

/// Scenes of `subsoil show` and `subsoil view` as data. A browser draws them in tests/optional.
namespace subsoil::sim::scene_test {
namespace {

using test::unpacked;
using test::unpacked_numbers;
using Json = nlohmann::ordered_json;

Json scene_of(const std::string& text) {
  const test::RunDirectory directory;
  ShowRequest request;
  request.scenario = directory.scenario(text);
  return show_scene(load_scenario(request.scenario), request);
}

/// Positions of a frame as the page adds them up.
std::vector<std::uint16_t> decoded(const std::string& frame, std::size_t count, std::vector<std::uint16_t> last) {
  const std::vector<unsigned char> bytes = unpacked(frame);
  EXPECT_EQ(bytes.size(), 6 * count);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < count; ++i)
      last[3 * i + axis] = static_cast<std::uint16_t>(last[3 * i + axis] + bytes[2 * axis * count + i] +
                                                      256U * bytes[(2 * axis + 1) * count + i]);
  return last;
}

const Json* thing(const Json& scene, const std::string& path) {
  for (const Json& t : scene["things"])
    if (t["path"] == path) return &t;
  return nullptr;
}

int number_of(const Json& scene, const std::string& path) {
  for (std::size_t i = 0; i < scene["things"].size(); ++i)
    if (scene["things"][i]["path"] == path) return static_cast<int>(i);
  return -1;
}

TEST(ScenePack, PositionsComeBackWithinTheErrorThatIsStated) {
  const Vec3 low{-1, 0, 2}, high{3, 0.5, 2.25};
  ScenePack pack(4, low, high);
  const std::vector<float> first{-1, 0, 2, 3, 0.5F, 2.25F, 0.123F, 0.4F, 2.1F}, second{0.7F, 0.1F, 2.2F};
  const std::vector<std::uint32_t> in_first{0, 1, 3}, in_second{3};
  const std::string a = pack.frame(first, in_first), b = pack.frame(second, in_second);
  EXPECT_DOUBLE_EQ(pack.error(), 0.5 * 4 / 65534) << "half a step of the longest side";
  const auto now = decoded(a, 4, std::vector<std::uint16_t>(12, 0)), next = decoded(b, 4, now);
  const double corner[3] = {low.x, low.y, low.z}, size[3] = {4, 0.5, 0.25};
  const auto expect_at = [&](const std::vector<std::uint16_t>& frame, std::size_t sphere, const float* place) {
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(corner[k] + frame[3 * sphere + k] / 65534.0 * size[k], static_cast<double>(place[k]),
                  pack.error() * (1 + 1e-6));
  };
  for (std::size_t i = 0; i < 3; ++i) expect_at(now, in_first[i], &first[3 * i]);
  EXPECT_EQ(now[3 * 2], 65535) << "a sphere that is not in the frame";
  expect_at(next, 3, second.data());
  EXPECT_EQ(next[0], 65535) << "one that has left";
}

TEST(Show, AMachineIsShownByItsJointsAtTheirPlacesWithTheirLines) {
  const Json scene = scene_of(R"(subsoil: 1
title: two bars
machine:
  bodies:
    crank: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.1 0 m}
    rod: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.35 0 m}
  joints:
    A: {revolute: [ground, crank], at: 0 0 m}
    B: {revolute: [crank, rod], at: 0.2 0 m}
  drivers: {D: {coordinate: crank.angle, velocity: 3 rad/s}}
time: {end: 0.1 s}
output: {monitor: {push: {joint: B, along: 0 1}}}
)");
  const Json* joint = thing(scene, "machine.joints.B");
  ASSERT_NE(joint, nullptr);
  EXPECT_NE((*joint)["place"].get<std::string>().find("case.yaml:9:"), std::string::npos) << *joint;
  EXPECT_NE((*joint)["values"].get<std::string>().find("revolute"), std::string::npos) << *joint;
  EXPECT_NE((*thing(scene, "machine.bodies.crank"))["values"].get<std::string>().find("kg m^2"), std::string::npos)
      << "values have units";
  bool found = false;
  for (const Json& s : scene["symbols"])
    if (s["kind"] == "pin" && s["thing"] == number_of(scene, "machine.joints.B")) {
      found = true;
      EXPECT_NEAR(s["pa"][0].get<double>(), 0.1, 1e-12) << "from the crank's centre of mass at 0.1 m";
      EXPECT_NEAR(s["pb"][0].get<double>(), -0.15, 1e-12) << "from the rod's at 0.35 m";
    }
  EXPECT_TRUE(found);
  ASSERT_EQ(scene["monitors"].size(), 1U);
  EXPECT_EQ(scene["monitors"][0]["arrow"]["along"], Json({0.0, 1.0, 0.0}));
}

TEST(Show, ADrivenMachineMovesAsItsDriverSays) {
  const Json scene = scene_of(R"(subsoil: 1
machine:
  bodies: {crank: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.1 0 m}}
  joints: {A: {revolute: [ground, crank], at: 0 0 m}}
  drivers: {D: {coordinate: crank.angle, velocity: 3 rad/s}}
analysis: kinematics
time: {end: 0.5 s}
)");
  const std::vector<double> times = scene["motion"]["times"].get<std::vector<double>>();
  const std::vector<float> bodies = unpacked_numbers<float>(scene["motion"]["bodies"].get<std::string>());
  ASSERT_EQ(bodies.size(), 6 * times.size());
  ASSERT_GT(times.size(), 50U);
  EXPECT_DOUBLE_EQ(times.back(), 0.5);
  for (std::size_t k = 0; k < times.size(); ++k) {  // float: 6e-8 of 1.5 rad
    EXPECT_NEAR(bodies[6 * k + 5], 3 * times[k], 1e-6);
    EXPECT_NEAR(bodies[6 * k + 3], 0.1 * std::cos(3 * times[k]), 1e-6);
  }
}

constexpr const char* moved_box = R"(subsoil: 1
materials: {grain: {density: 2500 kg/m^3}}
contacts: [{between: [grain, grain], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.5, mu_r: 0.1}]
soil:
  container: {size: 0.2 0.1 0.0808 m, at: 0 0 0 m, periodic: [z], open: [+y], material: grain}
  bed: {fill: FILL, material: grain, radius: 5 mm, MORE}
boundaries:
  - {name: tine, material: grain, shape: {box: 10 60 20 mm}, at: -0.02 0.1 0.04 m, moves: [{velocity: 0.5 0 0 m/s, from: 0.1 s}]}
time: {end: 0.3 s}
)";

std::string moved_box_with(const std::string& fill, const std::string& more) {
  std::string text = moved_box;
  text.replace(text.find("FILL"), 4, fill);
  return text.replace(text.find("MORE"), 4, more);
}

TEST(Show, GivenPathsSpheresAndSidesAreThoseOfTheScenario) {
  const Json scene = scene_of(moved_box_with("lattice", "region: {size: 0.2 0.06 0.0808 m, at: 0 0 0 m}"));
  const std::vector<double> times = scene["motion"]["times"].get<std::vector<double>>();
  const std::vector<float> poses = unpacked_numbers<float>(scene["motion"]["poses"].get<std::string>());
  ASSERT_EQ(poses.size(), 7 * times.size());
  for (std::size_t k = 0; k < times.size(); ++k)
    EXPECT_NEAR(poses[7 * k], -0.02 + 0.5 * std::max(0.0, times[k] - 0.1), 1e-7);
  std::map<std::string, std::string> faces;
  for (const Json& f : scene["container"]["faces"]) faces[f["name"].get<std::string>()] = f["state"].get<std::string>();
  EXPECT_EQ(
      faces,
      (std::map<std::string, std::string>{
          {"-x", "wall"}, {"+x", "wall"}, {"-y", "wall"}, {"+y", "open"}, {"-z", "periodic"}, {"+z", "periodic"}}));
  // The region of 200 x 60 x 80.8 mm holds at most as many spheres of 10 mm as cubes of 10 mm.
  const auto count = scene["spheres"]["count"].get<std::size_t>();
  EXPECT_GT(count, 500U);
  EXPECT_LE(count, 960U);
  const auto places =
      decoded(scene["spheres"]["frames"][0]["position"], count, std::vector<std::uint16_t>(3 * count, 0));
  const Json &low = scene["spheres"]["low"], &high = scene["spheres"]["high"];
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double at =
          low[k].get<double>() + places[3 * i + k] / 65534.0 * (high[k].get<double>() - low[k].get<double>());
      EXPECT_GE(at, (k < 2 ? 0.005 : 0) - 1e-5);
      EXPECT_LE(at, (k == 0 ? 0.195 : k == 1 ? 0.055 : 0.0808) + 1e-5);
    }
}

TEST(Show, OfAPouredBedTheRegionIsShownUpToItsDepth) {
  const Json scene = scene_of(moved_box_with("random", "depth: 60 mm"));
  EXPECT_TRUE(scene["spheres"].is_null());
  EXPECT_NEAR(scene["bed"]["surface"].get<double>(), 0.06, 1e-12);
  EXPECT_EQ(scene["bed"]["low"], Json({0.0, 0.0, 0.0}));
}

TEST(Show, AWarningPointsAtWhatItNames) {
  // The tine stays 0.5 m above the soil: `check` warns that it never comes near.
  std::string text = moved_box_with("lattice", "region: {size: 0.2 0.06 0.0808 m, at: 0 0 0 m}");
  const std::string at = "at: -0.02 0.1 0.04 m";
  text.replace(text.find(at), at.size(), "at: -0.02 0.8 0.04 m");
  const Json scene = scene_of(text);
  bool found = false;
  for (const Json& w : scene["warnings"])
    if (w["text"].get<std::string>().find("tine comes no nearer") != std::string::npos) {
      found = true;
      EXPECT_EQ(w["things"], Json::array({number_of(scene, "boundaries[0]")})) << w;
    }
  EXPECT_TRUE(found) << scene["warnings"];
}

TEST(Show, DepthWidthAndSpeedAreReadOffTheMovingTool) {
  std::string text = moved_box_with("lattice", "region: {size: 0.2 0.06 0.0808 m, at: 0 0 0 m}");
  const std::string at = "at: -0.02 0.1 0.04 m";
  text.replace(text.find(at), at.size(), "at: -0.02 0.05 0.04 m");
  const Json tool = scene_of(text)["tool"];
  ASSERT_FALSE(tool.is_null());
  // A box of 10 x 60 x 20 mm about y = 50 mm reaches down to 20 mm; it travels 0.1 m in 0.3 s; its front is upright.
  for (const Json& depth : tool["depth"]) EXPECT_NEAR(depth.get<double>(), tool["surface"].get<double>() - 0.02, 1e-6);
  EXPECT_NEAR(tool["width"].get<double>(), 0.02, 1e-6);
  EXPECT_NEAR(tool["speed"].get<double>(), 0.1 / 0.3, 1e-5);
  EXPECT_NEAR(tool["rakeHigh"].get<double>(), M_PI / 2, 1e-3);
}

TEST(Show, OpenEdgesOfAMeshAreThoseOfOneTriangle) {
  const test::RunDirectory directory;
  test::write_file(directory / "flap.obj", "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3\nf 1 3 4\n");
  ShowRequest request;
  request.scenario = directory.scenario(R"(subsoil: 1
machine:
  bodies: {plate: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0 m}}
  joints: {A: {revolute: [ground, plate], at: 0 0 m}}
  surfaces: {flap: {body: plate, mesh: flap.obj, unit: m, touches soil: no}}
time: {end: 0.1 s}
)");
  const Json scene = show_scene(load_scenario(request.scenario), request);
  ASSERT_EQ(scene["meshes"].size(), 1U);
  EXPECT_EQ(unpacked_numbers<std::uint32_t>(scene["meshes"][0]["open"].get<std::string>()).size(), 8U)
      << "the four sides of a square";
  EXPECT_EQ(unpacked_numbers<std::uint32_t>(scene["meshes"][0]["triangles"].get<std::string>()).size(), 6U);
}

/// One small pass for the tests of `view`.
const test::RunDirectory& pass() {
  static const test::RunDirectory* directory = [] {
    auto* d = new test::RunDirectory;
    EXPECT_EQ(test::run_scenario(d->scenario(test::small_pass), *d / "run"), exit_ok);
    return d;
  }();
  return *directory;
}

TEST(View, SpheresAndBodiesAreThoseOfTheRun) {
  ViewRequest request;
  request.run = pass() / "run";
  const Json scene = view_scene(request);
  const Json& spheres = scene["spheres"];
  const std::vector<double> times = test::frame_times(pass() / "run");
  ASSERT_EQ(spheres["frames"].size(), times.size());
  const auto count = spheres["count"].get<std::size_t>();
  std::vector<std::uint16_t> now(3 * count, 0);
  for (std::size_t f = 0; f < times.size(); ++f) now = decoded(spheres["frames"][f]["position"], count, now);
  const std::vector<dem::Vec3> last = test::frame_positions(pass() / "run", times.size() - 1);
  ASSERT_EQ(last.size(), count) << "no sphere leaves in this pass";
  const double error = spheres["error"].get<double>();
  EXPECT_LT(error, 1e-5);
  for (std::size_t i = 0; i < count; ++i) {
    const double place[3] = {last[i].x, last[i].y, last[i].z};
    for (std::size_t k = 0; k < 3; ++k) {
      const double low = spheres["low"][k].get<double>(), high = spheres["high"][k].get<double>();
      EXPECT_NEAR(low + now[3 * i + k] / 65534.0 * (high - low), place[k], error * 1.01);
    }
  }
  const Series series = read_series(pass() / "run" / "series.csv");
  const std::vector<float> bodies = unpacked_numbers<float>(scene["motion"]["bodies"].get<std::string>());
  const std::vector<double> samples = scene["motion"]["times"].get<std::vector<double>>();
  ASSERT_EQ(samples.size(), series.rows());
  for (std::size_t row = 0; row < series.rows(); ++row)
    EXPECT_FLOAT_EQ(bodies[9 * row + 6], static_cast<float>(series.at("tine.x")[row]));
}

TEST(View, FramesAreLeftOutUntilTheyFitAndThePageSaysSo) {
  ViewRequest request;
  request.run = pass() / "run";
  request.bytes = 8000;
  const Json scene = view_scene(request);
  double bytes = 0;
  for (const Json& f : scene["spheres"]["frames"])
    for (const char* part : {"position", "speed", "force"})
      if (f.contains(part)) bytes += static_cast<double>(f[part].get<std::string>().size());
  const std::size_t all = test::frame_times(pass() / "run").size(), kept = scene["spheres"]["frames"].size();
  EXPECT_LT(kept, all);
  EXPECT_TRUE(bytes <= request.bytes || kept <= 2) << bytes;
  EXPECT_NE(scene["notes"].dump().find("of " + std::to_string(all) + " frames"), std::string::npos) << scene["notes"];
}

}  // namespace
}  // namespace subsoil::sim::scene_test
