#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/commands/view_command.hpp"
#include "libsim/view/show.hpp"
#include "libsim/view/view.hpp"
#include "tests/tools/message_of.hpp"
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

/// Every joint and force but those that only beds have, somewhere in the plane.
constexpr const char* every_element = R"(subsoil: 1
title: every joint and force
machine:
  bodies:
    gear a: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0 m}
    gear b: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.3 0 m}
    rack: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 -0.1 m}
    idler: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.8 0 m}
    cam: {mass: 1 kg, inertia: 0.01 kg m^2, at: 1.2 0 m}
    follower: {mass: 1 kg, inertia: 0.01 kg m^2, at: 1.2 0.2 m}
    roller: {mass: 1 kg, inertia: 0.01 kg m^2, at: 1.8 0.1 m}
    bead: {mass: 1 kg, inertia: 0.01 kg m^2, at: 2.2 0.1 m}
    lid: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.2 0.8 m}
    sledge: {mass: 1 kg, inertia: 0.01 kg m^2, at: 1 0.8 m}
    bob: {mass: 1 kg, inertia: 0.01 kg m^2, at: 1.7 0.6 m}
    post: {mass: 1 kg, inertia: 0.01 kg m^2, at: 2.2 0.8 m}
    wheel: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0.3 -0.6 m}
    ram: {mass: 1 kg, inertia: 0.01 kg m^2, at: 1.2 -0.7 m}
    ball: {mass: 1 kg, inertia: 0.01 kg m^2, at: 2 -0.6 m}
  joints:
    pin a: {revolute: [ground, gear a], at: 0 0 m}
    pin b: {revolute: [ground, gear b], at: 0.3 0 m}
    mesh: {gear pair: [gear a, gear b], ends: [0 0 m, 0.3 0 m], first radius: 0.1 m, second radius: 0.2 m}
    rail: {translational: [ground, rack], along: 1 0}
    teeth: {rack and pinion: [rack, gear a], ends: [0 -0.1 m, 0 0 m], along: 1 0, radius: 0.1 m}
    pin c: {revolute: [ground, idler], at: 0.8 0 m}
    belt: {gear ratio: [gear b, idler], ratio: 2}
    pin d: {revolute: [ground, cam], at: 1.2 0 m}
    lift: {translational: [ground, follower], along: 0 1}
    track: {cam: [cam, follower], ends: [1.2 0 m, 1.2 0.1 m], profile: [[0 deg, 0.1 m], [90 deg, 0.1 m], [180 deg, 0.08 m], [270 deg, 0.09 m]]}
    floor: {rolling on line: [ground, roller], ends: [1.8 0 m, 1.8 0.1 m], along: 1 0, radius: 0.1 m}
    wire: {point on curve: [ground, bead], curve: [2 0.1 m, 2.2 0.1 m, 2.4 0.2 m]}
    hinge: {revolute: [ground, lid], at: 0 0.8 m}
    guide: {translational: [ground, sledge], along: 1 0}
    weld: {fixed: [ground, post], at: 2.2 0.8 m}
    hinge r: {translational: [ground, ram], along: 0 1}
  drivers:
    turn: {coordinate: gear a.angle, velocity: 1 rad/s}
  forces:
    coil: {rotational spring-damper: [ground, lid], stiffness: 10 N m/rad}
    stop: {rotational stop: [ground, lid], minimum: -20 deg, maximum: 60 deg, stiffness: 1 kN m/rad, n: 1}
    ends: {slide stop: [ground, sledge], at: 1 0.8 m, along: 1 0, minimum: -0.1 m, maximum: 0.2 m, stiffness: 1 kN/m, n: 1}
    rope: {distance stop: [ground, bob], ends: [1.7 1 m, 1.7 0.6 m], maximum: 0.5 m, stiffness: 1 kN/m, n: 1}
    rubber: {bushing: [ground, bob], at: 1.7 0.6 m, stiffness x: 1 kN/m, stiffness y: 1 kN/m}
    blade: {beam: [post, ground], ends: [2.2 0.8 m, 2.5 0.8 m], axial stiffness: 1 MN, bending stiffness: 100 N m^2}
    air: {drag: sledge, linear: 1 N s/m}
    push: {force: sledge, along x: 10 N}
    twist: {force: lid, moment: 1 N m}
    rub: {joint friction: hinge, radius: 10 mm, mu_s: 0.1, mu_k: 0.1}
    dc: {electric motor: [ground, idler], torque constant: 0.1 N m/A, resistance: 1 ohm, voltage: 1 V}
    soft: {wheel on soil: wheel, radius: 0.1 m, width: 0.1 m, n: 1, k_c: 1 kN/m^2, k_phi: 500 kN/m^3, surface: -0.7 m}
    jack: {hydraulic cylinder: [ground, ram], ends: [1.2 -1.2 m, 1.2 -0.7 m], bore: 40 mm, closed length: 0.3 m, stroke: 0.4 m, flow given: 1e-5 m^3/s}
    bump: {line contact: [ground, ball], ends: [2 -0.7 m, 2 -0.6 m], along: 1 0, radius: 0.1 m, stiffness: 100 kN/m, n: 1}
    spring: {spring-damper: [ground, ball], ends: [2.4 -0.6 m, 2 -0.6 m], stiffness: 100 N/m}
time: {end: 0.1 s}
output: {monitor: {coil torque: {force: coil}, spring force: {force: spring}, crank: {driver: turn}, sledge speed: {column: sledge.vx}}}
)";

TEST(Show, EveryJointAndForceHasASymbol) {
  const Json scene = scene_of(every_element);
  std::set<int> drawn;
  for (const Json& s : scene["symbols"]) drawn.insert(s["thing"].get<int>());
  int count = 0;
  for (std::size_t i = 0; i < scene["things"].size(); ++i) {
    const Json& t = scene["things"][i];
    if (t["kind"] != "joint" && t["kind"] != "force" && t["kind"] != "driver") continue;
    ++count;
    EXPECT_TRUE(drawn.contains(static_cast<int>(i))) << t["path"] << " has no symbol";
  }
  EXPECT_EQ(count, 32);
}

const Json& symbol_of(const Json& scene, const std::string& kind, const std::string& path) {
  const int number = number_of(scene, path);
  for (const Json& s : scene["symbols"])
    if (s["kind"] == kind && s["thing"] == number) return s;
  throw std::runtime_error("no symbol " + kind + " of " + path);
}

TEST(Show, SymbolsHoldTheNumbersOfTheirElements) {
  const Json scene = scene_of(every_element);
  const Json& stop = symbol_of(scene, "angle stop", "machine.forces.stop");
  EXPECT_NEAR(stop["from"].get<double>(), -20 * M_PI / 180, 1e-12);
  EXPECT_NEAR(stop["until"].get<double>(), 60 * M_PI / 180, 1e-12);
  EXPECT_NEAR(stop["pb"][0].get<double>(), -0.2, 1e-12) << "at the hinge: the lid's centre of mass is 0.2 m beside it";
  const Json& rope = symbol_of(scene, "distance stop", "machine.forces.rope");
  EXPECT_TRUE(rope["from"].is_null()) << "a rope has no minimum";
  EXPECT_EQ(rope["until"], 0.5);
  const Json& mesh = symbol_of(scene, "two disks", "machine.joints.mesh");
  EXPECT_EQ(mesh["what"], "gears");
  EXPECT_EQ(mesh["radius"], 0.1);
  EXPECT_EQ(mesh["radiusB"], 0.2);
  EXPECT_EQ(symbol_of(scene, "ratio", "machine.joints.belt")["ratio"], 2.0);
  EXPECT_EQ(symbol_of(scene, "load", "machine.forces.push")["along"], Json({10.0, 0.0, 0.0}));
}

TEST(Show, MonitorsPointWhereTheyArePositive) {
  const Json scene = scene_of(every_element);
  std::map<std::string, Json> arrows;
  for (const Json& m : scene["monitors"]) arrows[m["name"].get<std::string>()] = m["arrow"];
  EXPECT_EQ(arrows["coil torque"]["turn"], 1) << "a torque on the second body, counter-clockwise";
  EXPECT_EQ(arrows["crank"]["turn"], 1);
  EXPECT_EQ(arrows["sledge speed"]["along"], Json({1.0, 0.0, 0.0}));
  // A spring's force is positive where it pushes its ends apart: away from its end on the ground.
  EXPECT_EQ(arrows["spring force"]["from"]["body"], 0);
  EXPECT_NEAR(arrows["spring force"]["from"]["point"][0].get<double>(), 2.4, 1e-12);
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

TEST(Show, ANameOfAPictureIsRefusedWithTheCure) {
  const test::RunDirectory directory;
  ShowRequest request;
  request.scenario = directory.scenario(test::small_pass);
  request.out = directory / "case.png";
  EXPECT_EQ(
      subsoil::test::message_of<std::invalid_argument>([&] { show_command(request); }),
      "--out " + request.out.string() +
          ": must end in .html, since the command writes a page; for a PNG open the page and press its button PNG");
  EXPECT_FALSE(std::filesystem::exists(request.out));
  request.out = directory / "none" / "case.html";
  EXPECT_EQ(subsoil::test::message_of<std::invalid_argument>([&] { show_command(request); }),
            "--out " + request.out.string() + ": there is no folder " + (directory / "none").string() +
                "; make it, or write the page elsewhere");
  request.out = directory / "case.html";
  EXPECT_EQ(show_command(request), exit_ok);
  EXPECT_TRUE(std::filesystem::exists(request.out));
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

TEST(View, ChainsAreTheRecordedContactsWithTheirNormalForces) {
  const test::RunDirectory directory;
  ASSERT_EQ(test::run_scenario(directory.scenario(test::small_pass), directory / "run", {"output.contact forces=yes"}),
            exit_ok);
  ViewRequest request;
  request.run = directory / "run";
  const Json spheres = view_scene(request)["spheres"];
  const h5::Handle file = h5::open_file(directory / "run" / "run.h5");
  const std::size_t last = spheres["frames"].size() - 1;
  const std::string folder = fmt::format("/frames/{:06}/contact forces/", last);
  const std::vector<float> ends = h5::read<float>(file, folder + "ends"),
                           normal = h5::read<float>(file, folder + "normal force");
  using Line = std::array<float, 7>;
  std::multiset<Line> recorded, drawn;
  for (std::size_t k = 0; k < normal.size(); ++k) {
    Line line{};
    std::copy_n(&ends[6 * k], 6, line.begin()), line[6] = normal[k];
    recorded.insert(line);
  }
  const std::vector<float> chains = unpacked_numbers<float>(spheres["frames"][last]["chains"].get<std::string>());
  for (std::size_t k = 0; k + 6 < chains.size(); k += 7) {
    Line line{};
    std::copy_n(&chains[k], 7, line.begin());
    drawn.insert(line);
    const double length = std::hypot(line[3] - line[0], line[4] - line[1], line[5] - line[2]);
    ASSERT_LT(length, 0.0241) << "two radii of 10 mm and the reach of attraction, dc + dB = 4 mm";
  }
  ASSERT_GT(recorded.size(), 100U) << "a bed at rest: more contacts than spheres";
  ASSERT_LT(recorded.size(), 2500U) << "the page has all of them";
  EXPECT_EQ(drawn, recorded);
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
