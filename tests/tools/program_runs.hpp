#pragma once
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "libdem/base/vec3.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/io/series.hpp"
#include "libsim/run/runner.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// Running scenarios as `subsoil run` does, in this process, and looking at what they leave.
namespace subsoil::sim::test {

/// A scratch directory that scenarios are put into and run in.
class RunDirectory : public Scratch {
 public:
  /// Puts a scenario here; returns its path.
  std::string scenario(const std::string& text) const {
    write_file(*this / "case.yaml", text);
    return (*this / "case.yaml").string();
  }
};

inline std::string config(const std::string& name) {
  return subsoil::test::source_dir() + "/configs/" + name + ".yaml";
}

/// Runs on one thread, without talk; returns the exit code.
inline int run_scenario(const std::string& scenario, const std::filesystem::path& out,
                        const std::vector<std::string>& sets = {}, const std::filesystem::path& from = {}) {
  spdlog::set_level(spdlog::level::off);
  return run({.scenario = scenario, .out = out, .sets = sets, .threads = 1, .from = from});
}

inline nlohmann::json summary_of(const std::filesystem::path& out) {
  std::ifstream file(out / "summary.json");
  return nlohmann::json::parse(file);
}

/// Times of the frames in a run, from the file itself.
inline std::vector<double> frame_times(const std::filesystem::path& out) {
  std::vector<double> times;
  const auto file = h5::open_file(out / "run.h5");
  for (int k = 0;; ++k) {
    char name[32];
    std::snprintf(name, sizeof name, "/frames/%06d", k);
    if (!h5::exists(file, name)) return times;
    const h5::Handle group(H5Gopen2(file, name, H5P_DEFAULT), H5Gclose, name);
    times.push_back(h5::number_attribute(group, "time"));
  }
}

/// x y z of the spheres of a frame, in the file's order.
inline std::vector<dem::Vec3> frame_vectors(const std::filesystem::path& out, std::size_t frame, const char* of) {
  char name[48];
  std::snprintf(name, sizeof name, "/frames/%06zu/%s", frame, of);
  const std::vector<double> flat = h5::read<double>(h5::open_file(out / "run.h5"), name);
  std::vector<dem::Vec3> points;
  for (std::size_t i = 0; i + 2 < flat.size(); i += 3) points.push_back({flat[i], flat[i + 1], flat[i + 2]});
  return points;
}
inline std::vector<dem::Vec3> frame_positions(const std::filesystem::path& out, std::size_t frame) {
  return frame_vectors(out, frame, "position");
}

/// About 300 wet spheres and a tine that hangs on a spring behind a towed trolley: starts outside and enters. Soil,
/// machine, and both ways between, in well under a second.
inline constexpr const char* small_pass = R"(subsoil: 1
title: a small pass
materials:
  soil: {density: 1800 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - &wet {between: [soil, soil], law: wet, K_X: 10 kN/m, C_X: 5 N s/m, K_Y: 8 kN/m, C_Y: 3 N s/m, K_B: 7 kN/m, dc: 2 mm,
          dB: 2 mm, mu: 0.5, mu_r: 0.3}
  - {<<: *wet, between: [soil, steel], K_X: 16 kN/m, K_Y: 12 kN/m, K_B: 3 kN/m}
soil:
  container: {size: 0.16 0.085 0.13 m, at: 0 -0.085 -0.065 m, open after settling: [-x], material: steel}
  surface: 0 m
  bed: {fill: rest-lattice, material: soil, radius: 10 mm}
machine:
  bodies:
    trolley: {mass: 5 kg, inertia: 1 kg m^2, at: -0.05 0.1 m}
    tine: {mass: 1 kg, inertia: 0.01 kg m^2, at: -0.02 0 m}
  joints:
    rail: {translational: [ground, trolley], along: 1 0}
    slide: {translational: [trolley, tine], along: 1 0}
  drivers:
    tow: {coordinate: trolley.x, velocity: 0.5 m/s}
  forces:
    spring: {spring-damper: [tine, trolley], ends: [-0.02 0.05 m, -0.2 0.05 m], stiffness: 5 kN/m, free length: 0.18 m,
             damping: 20 N s/m}
  surfaces:
    blade: {body: tine, material: steel, box: 20 90 30 mm}
time: {end: 0.15 s, safety: 0.8}
output:
  every: 25 ms
  series every: 1 ms
  monitor:
    pull: {driver: tow}
    draft: {soil force: tine, along: -1 0}
)";

/// A moving bed: some 370 grains in three blocks, a blade that goes through five.
inline constexpr const char* moving_pass = R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {grain: {density: 2500 kg/m^3}}
contacts: [{between: [grain, grain], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.5, mu_r: 0.1}]
soil:
  container: {size: 360 160 120 mm, at: 0 -60 -60 mm, material: grain}
  surface: 0 mm
  bed: {fill: random, material: grain, radius: {uniform: 8.5 10 mm}, depth: 60 mm, inside machine: carve}
  moving: {follows: blade, block: 120 mm}
boundaries:
  - {name: blade, shape: {box: 15 100 30 mm}, at: 180 20 0 mm, material: grain, moves: [{velocity: 1 0 0 m/s}]}
time: {end: 0.62 s}
output: {precision: double, every: 40 ms, series every: 10 ms, monitor: {draft: {soil force: blade, along: -1 0}}}
)";

}  // namespace subsoil::sim::test
