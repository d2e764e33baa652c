#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "libsim/io/state_file.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Fibres of a scenario. Oracles: springs in series under a load across, the mass that is asked for, a count of what is
/// buried from the frames, the balance of energy, a run and a settling that were not interrupted.
namespace subsoil::sim::fibres {
namespace {

using namespace test;

// ---- a root that stands in a fixed floor ---------------------------------------------------------------------------

/// The lowest sphere of a vertical fibre of 20 is fixed, and so is the only sphere of the bed; gravity acts across.
constexpr const char* kRoot = R"(subsoil: 1
title: a root in a rough floor
gravity: 1 0 0 m/s^2
materials:
  soil: {density: 2000 kg/m^3}
  root: {density: 150 kg/m^3}
contacts:
  - &soft {between: [soil, soil], law: linear, k_n: 1 kN/m, restitution: 0.5, mu: 0.3}
  - {<<: *soft, between: [soil, root]}
  - {<<: *soft, between: [root, root], bond: fibre, bond modulus: 10 MPa, bond tensile strength: 1 GPa, bond shear strength: 1 GPa}
soil:
  container: {size: 200 200 40 mm, at: 0 0 0 mm, material: soil}
  bed:
    fill: lattice
    material: soil
    radius: 5 mm
    region: {at: 180 0 10 mm, size: 10.2 10.2 10.2 mm}
    rough floor: 5.5 mm
    fibres: {root: {material: root, length: 80 mm, diameter: 4 mm, count: 1, orientation: y, region: {at: 47.999 0 17.999 mm, size: 4.002 80.001 4.002 mm}}}
time: {end: 0.4 s}
output: {precision: double, every: 0.5 ms, series every: 1 ms}
)";

/// Released from its straight shape it swings about its deflection at rest. From the start to the last return of the
/// tip these are whole periods of the first mode, over which it means to the deflection at rest; what higher modes
/// leave is below 1e-4 (the second has 1.6 % of the amplitude and a sixth of the period). The last return is found
/// within half a frame, 0.25 ms of 0.4 s, at the place of least deflection.
TEST(FibresOfAScenario, ARootDeflectsLikeACantilever) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(kRoot), dir / "out"), exit_ok);
  const FramesFile frames(dir / "out" / "run.h5");
  ASSERT_EQ(frames.fibre(), [] {
    std::vector<std::int32_t> expected(21, 0);
    expected[0] = -1;
    return expected;
  }());
  std::vector<double> tip;
  for (std::size_t f = 0; f < frames.times().size(); ++f) tip.push_back(frame_positions(dir / "out", f).back().x);
  std::size_t last = 0, returns = 0;
  for (std::size_t f = 1; f + 1 < tip.size(); ++f)
    if (tip[f] < tip[f - 1] && tip[f] <= tip[f + 1]) last = f, ++returns;
  ASSERT_GE(returns, 8U);
  double mean = 0;
  for (std::size_t f = 0; f < last; ++f) mean += 0.5 * (tip[f] + tip[f + 1]) / static_cast<double>(last);

  const int n = 19;  // bonds and free spheres
  const double d = 4e-3, modulus = 10e6, ratio = 2.5, area = M_PI * d * d / 4, inertia = M_PI * d * d * d * d / 64;
  const double weight = 150 * area * d * 1.0;  // of a sphere, N
  double deflection = 0;
  for (int k = 1; k <= n; ++k) {
    double force = 0, moment = 0;
    for (int j = k; j <= n; ++j) force += weight, moment += weight * (j - k + 0.5) * d;
    deflection += moment * d / (modulus * inertia) * (n - k + 0.5) * d + force * d * ratio / (modulus * area);
  }
  EXPECT_NEAR(mean - tip[0], deflection, 5e-3 * deflection);
  // First mode of equal masses on these springs: largest eigenvalue of their flexibility, by repeated multiplication.
  const auto flexibility = [&](int i, int j) {
    double sum = 0;
    for (int k = 1; k <= std::min(i, j); ++k)
      sum += d / (modulus * inertia) * (i - k + 0.5) * d * (j - k + 0.5) * d + d * ratio / (modulus * area);
    return sum;
  };
  std::vector<double> shape(n, 1.0);
  double largest = 0;
  for (int turn = 0; turn < 50; ++turn) {
    std::vector<double> next(n, 0.0);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        next[static_cast<std::size_t>(i)] += flexibility(i + 1, j + 1) * shape[static_cast<std::size_t>(j)];
    largest = next.back();
    for (int i = 0; i < n; ++i) shape[static_cast<std::size_t>(i)] = next[static_cast<std::size_t>(i)] / largest;
  }
  const double omega = 1 / std::sqrt(weight / 1.0 * largest);
  EXPECT_NEAR(2 * M_PI * static_cast<double>(returns) / frames.times()[last], omega, 3e-3 * omega)
      << "the last return is within 0.25 ms of 0.4 s; rotary inertia";
  const nlohmann::json summary = summary_of(dir / "out"), root = summary["fibres"]["root"];
  EXPECT_EQ(root["at the end"]["intact bonds"], 19);
  EXPECT_NEAR(root["at the start"]["angle to the horizontal [rad]"], M_PI / 2, 1e-6);
  EXPECT_NEAR(root["at the start"]["nematic order"], 1, 1e-9);
  EXPECT_LT(std::abs(summary["energy"]["bed closure [J]"].get<double>()), 1e-3 * weight * n * deflection);
}

// ---- straw on a bed under a blade ----------------------------------------------------------------------------------

constexpr double kMassPerArea = 1, kLength = 48e-3, kDiameter = 8e-3, kStraw = 600, kSoilRadius = 8e-3;

/// The law of the soil, with itself and with straw, is put in place of LAW.
constexpr const char* kPass = R"(subsoil: 1
title: a blade through straw
gravity: 9.81 m/s^2
materials:
  soil: {density: 2500 kg/m^3}
  straw: {density: 600 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - &law {between: [soil, soil], LAW}
  - {<<: *law, between: [soil, steel]}
  - {<<: *law, between: [soil, straw]}
  - &straw {between: [straw, steel], law: linear, k_n: 8 kN/m, restitution: 0.3, mu: 0.3, mu_r: 0.05}
  - <<: *straw
    between: [straw, straw]
    bond: fibre
    bond modulus: 1 MPa
    bond tensile strength: 60 kPa
    bond shear strength: 60 kPa
    bond yield stress: 30 kPa
    bond damping: 0.05
soil:
  container: {size: 240 120 120 mm, at: 0 0 0 mm, material: steel, open after settling: [-x]}
  surface: 0 mm
  bed:
    fill: rest-lattice
    material: soil
    radius: 8 mm
    depth: 50 mm
    settle: {for: 60 ms}
    fibres: {straw: {material: straw, length: 50 mm, diameter: 8 mm, mass per area: 1 kg/m^2, orientation: horizontal}}
boundaries:
  - {name: blade, shape: {box: 10 120 60 mm}, at: -8 38 60 mm, material: steel, moves: [{velocity: 0.6 0 0 m/s}]}
time: {end: 0.15 s, accuracy: 1}
output: {precision: double, contact forces: yes, every: 15 ms, series every: 5 ms}
)";

std::string pass(const std::string& law) {
  std::string text = kPass;
  return text.replace(text.find("LAW"), 3, law);
}
constexpr const char* kLinear = "law: linear, k_n: 10 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.1";

/// Mass of straw with soil above it, of a frame: every sphere of straw against every sphere of soil that is not in
/// flight.
struct Burial {
  double buried = 0, mass = 0;
  std::vector<double> depths;  ///< of the spheres that are buried, m
};
Burial buried_in(const std::filesystem::path& out, std::size_t frame) {
  const FramesFile frames(out / "run.h5");
  const std::vector<Vec3> x = frame_positions(out, frame);
  const std::vector<std::int32_t>& fibre = frames.fibre();
  Burial b;
  const double sphere = kStraw * M_PI / 4 * kDiameter * kDiameter * kDiameter;
  std::vector<bool> flies(x.size(), true);
  for (std::size_t j = 0; j < x.size(); ++j)
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double touching = kSoilRadius + (fibre[k] < 0 ? kSoilRadius : 0.5 * kDiameter);
      if (k != j && dem::norm(x[k] - x[j]) < touching + 0.1 * kSoilRadius) flies[j] = false;
    }
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (fibre[i] < 0) continue;
    b.mass += sphere;
    double above = 0;
    for (std::size_t j = 0; j < x.size(); ++j) {
      const double off = std::hypot(x[j].x - x[i].x, x[j].z - x[i].z);
      if (fibre[j] < 0 && !flies[j] && off < kSoilRadius)
        above = std::max(above, x[j].y + std::sqrt(kSoilRadius * kSoilRadius - off * off) - x[i].y);
    }
    if (above > 0) b.buried += sphere, b.depths.push_back(above);
  }
  return b;
}

class StrawUnderABlade : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(StrawUnderABlade, EnergyClosesAndItsMassIsCounted) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(pass(GetParam().second)), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), straw = summary["fibres"]["straw"];
  const double one = kStraw * M_PI / 4 * kDiameter * kDiameter * kLength;
  EXPECT_NEAR(straw["mass of a fibre [kg]"], one, 1e-12);
  EXPECT_NEAR(straw["at the start"]["mass [kg]"], kMassPerArea * 0.24 * 0.12, 0.5 * one) << "mass per area";
  EXPECT_EQ(straw["at the end"]["mass [kg]"], straw["at the start"]["mass [kg]"]);

  const nlohmann::json energy = summary["energy"];
  EXPECT_LT(std::abs(energy["closure over energy there or put in"].get<double>()), 1e-3);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_EQ(series.at("soil.broken").size(), series.rows());

  const std::size_t last = frame_times(dir / "out").size() - 1;
  for (const auto& [when, frame] : std::map<const char*, std::size_t>{{"at the start", 0}, {"at the end", last}}) {
    const Burial counted = buried_in(dir / "out", frame);
    EXPECT_NEAR(straw[when]["mass [kg]"], counted.mass, 1e-9);
    EXPECT_NEAR(straw[when]["buried [kg]"], counted.buried, 1e-9) << when;
    EXPECT_NEAR(straw[when]["on the surface [kg]"], counted.mass - counted.buried, 1e-9);
    double in_bands = 0, band = straw[when]["by depth"][0]["to [m]"].is_null()
                                    ? 1
                                    : straw[when]["by depth"][0]["to [m]"].get<double>();
    for (const auto& row : straw[when]["by depth"]) in_bands += row["mass [kg]"].get<double>();
    EXPECT_NEAR(in_bands, counted.buried, 1e-9);
    const auto shallow =
        std::count_if(counted.depths.begin(), counted.depths.end(), [&](double d) { return d < band; });
    EXPECT_NEAR(straw[when]["by depth"][0]["mass [kg]"], static_cast<double>(shallow) * one * kDiameter / kLength,
                1e-9);
  }
  EXPECT_NEAR(series.at("straw.buried").back(), straw["at the end"]["buried share"].get<double>(), 1e-6);
  EXPECT_EQ(series.at("straw.broken bonds").back(), straw["at the end"]["broken bonds"].get<double>());
  EXPECT_LT(straw["at the start"]["angle to the horizontal [rad]"], 0.4) << "laid flat";
}

INSTANTIATE_TEST_SUITE_P(
    Laws, StrawUnderABlade,
    testing::Values(
        std::pair{"Linear", kLinear},
        std::pair{"Hertz", "law: hertz-mindlin, E_eff: 0.5 MPa, G_eff: 0.2 MPa, restitution: 0.4, mu: 0.5, mu_r: 0.1"},
        std::pair{"Wet",
                  "law: wet, K_X: 15 kN/m, C_X: 0.6 N s/m, K_Y: 12 kN/m, C_Y: 0.6 N s/m, K_B: 1 kN/m, dc: 1 mm, "
                  "dB: 1 mm, mu: 0.5, mu_r: 0.1"},
        std::pair{"Cohesive",
                  "law: linear, k_n: 10 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.1, cohesion: dmt, "
                  "work of adhesion: 5 J/m^2"}),
    [](const auto& info) { return info.param.first; });

/// What sleeps far from the blade, soil and straw, leaves the blade its work and the balance closed. Particle blocks of
/// 256 spheres sleep, and only beside others that are slow for 2 below/(0.02 g) = 0.05 s: the bed is long enough for
/// several, the blade slow, and the bed settles until the last stalk has come to rest.
TEST(FibresOfAScenario, SleepWithTheSoil) {
  std::string text = pass(kLinear);
  const auto put = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put("size: 240 120 120 mm", "size: 1000 120 60 mm");
  put("fill: rest-lattice", "fill: random"), put("depth: 50 mm", "depth: 34 mm");
  put("settle: {for: 60 ms}", "settle: {until: 0.4 mm/s}");
  put("orientation: horizontal", "orientation: z, scatter: 0.2 rad");
  put("box: 10 120 60 mm}, at: -8 38 60 mm", "box: 10 120 50 mm}, at: -8 38 30 mm");
  put("velocity: 0.6 0 0 m/s", "velocity: 0.1 0 0 m/s"), put("end: 0.15 s", "end: 0.12 s");
  const RunDirectory dir;
  const std::string file = dir.scenario(text);
  ASSERT_EQ(run_scenario(file, dir / "awake"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "asleep", {"soil.active={within: 30 mm, below: 5 mm/s}", "output.every=5 ms"}),
            exit_ok);
  const Series series = read_series(dir / "asleep" / "series.csv");
  const std::vector<double>& frozen = series.at("soil.frozen spheres");
  const auto work = [&](const char* name) {
    const nlohmann::json energy = summary_of(dir / name)["energy"];
    EXPECT_LT(std::abs(energy["closure over energy there or put in"].get<double>()), 1e-3);
    return energy["work of given motions [J]"].get<double>();
  };
  const double awake = work("awake"), asleep = work("asleep");
  std::printf("work of the blade: %.4f J awake, %.4f J with up to %.0f spheres asleep\n", awake, asleep,
              *std::max_element(frozen.begin(), frozen.end()));
  EXPECT_GT(*std::max_element(frozen.begin(), frozen.end()), 100);
  EXPECT_LT(frozen.back(), *std::max_element(frozen.begin(), frozen.end())) << "none wakes";
  EXPECT_NEAR(asleep, awake, 0.1 * awake);
  // Stalks that sleep stand still in a frame.
  const FramesFile frames(dir / "asleep" / "run.h5");
  const std::vector<std::int32_t>& fibre = frames.fibre();
  bool still = false;
  for (std::size_t f = 1; f < frames.times().size(); ++f) {
    const std::vector<Vec3> before = frame_positions(dir / "asleep", f - 1), now = frame_positions(dir / "asleep", f);
    for (std::size_t i = 0; i < now.size(); ++i) still = still || (fibre[i] >= 0 && now[i] == before[i]);
  }
  EXPECT_TRUE(still);
}

/// The same soil and straw in a window of three periods that is continued twice: stalks lie across its ends, come in
/// with their bonds and leave. A continued run ends with the same bits.
TEST(FibresOfAScenario, GoWithAMovingBed) {
  std::string text = pass(kLinear);
  const auto put = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put("  container: {size: 240 120 120 mm, at: 0 0 0 mm, material: steel, open after settling: [-x]}\n",
      "  container: {size: 360 120 120 mm, at: 0 0 0 mm, material: steel}\n  moving: {follows: blade, block: 120 "
      "mm}\n");
  put("    fill: rest-lattice\n", "    fill: random\n    inside machine: carve\n");
  put("settle: {for: 60 ms}", "settle: {until: 10 mm/s}");
  put("at: -8 38 60 mm", "at: 100 38 60 mm");
  put("time: {end: 0.15 s", "time: {end: 0.45 s");
  const RunDirectory dir;
  const std::string file = dir.scenario(text);
  ASSERT_EQ(run_scenario(file, dir / "out", {"output.state every=0.25 s"}), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), straw = summary["fibres"]["straw"];
  EXPECT_EQ(summary["moving bed"]["blocks gone on"], 2);
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 5e-3);
  // By mass per area: 10 stalks a period. What the blade is carved out of is missing at the start.
  const double one = kStraw * M_PI / 4 * kDiameter * kDiameter * kLength, period = 10 * one;
  EXPECT_EQ(straw["fibres of a period"], 10);
  EXPECT_LE(straw["at the start"]["mass [kg]"].get<double>(), 3 * period + 1e-9);
  EXPECT_GT(straw["at the start"]["mass [kg]"].get<double>(), 2.5 * period);
  EXPECT_GT(straw["at the end"]["mass [kg]"].get<double>(), 2.5 * period);
  EXPECT_GT(straw["at the end"]["intact bonds"].get<int>(), 2 * 10 * 5);
  // Soil and straw are apart in the frames, by the number in the period.
  const auto fibre = h5::read<std::int32_t>(h5::open_file(dir / "out" / "run.h5"), "/particles/fibre");
  EXPECT_EQ(std::count_if(fibre.begin(), fibre.end(), [](std::int32_t f) { return f >= 0; }), 10 * 6);
  EXPECT_EQ(*std::max_element(fibre.begin(), fibre.end()), 9);
  const FramesFile frames(dir / "out" / "run.h5");
  for (const std::uint32_t i : frames.spheres(frames.times().size() - 1, false).index)
    EXPECT_EQ(frames.fibre().at(i), fibre[i % fibre.size()]) << i;

  std::filesystem::path state;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "out"))
    if (entry.path().filename().string().rfind("state-0.25", 0) == 0) state = entry.path();
  ASSERT_FALSE(state.empty());
  ASSERT_EQ(run_scenario(file, dir / "again", {}, state), exit_ok);
  const std::vector<Vec3> x = frame_positions(dir / "out", frame_times(dir / "out").size() - 1),
                          y = frame_positions(dir / "again", frame_times(dir / "again").size() - 1);
  ASSERT_EQ(x.size(), y.size());
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_EQ(x[i], y[i]) << i;
  // All but the forces of frames: the continued run has those from its start on alone.
  nlohmann::json again = summary_of(dir / "again")["fibres"]["straw"], whole = straw;
  again.erase("force on surfaces [N]"), whole.erase("force on surfaces [N]");
  EXPECT_EQ(again, whole);
}

/// A knife and one stalk across a slot: the load grows to sigma_e A and no more. In a row of 1 us it grows by
/// 300/2 kN/m 0.5 m/s 1 us = 0.08 N at most, 0.3 % of it.
TEST(FibresOfAScenario, AreCutByAKnife) {
  const RunDirectory dir;
  const std::string file = config("straw-cutter"), straw = "soil.bed.fibres.straw.";
  ASSERT_EQ(run_scenario(file, dir / "one", {straw + "count=1", "output.series every=1 us"}), exit_ok);
  const Series one = read_series(dir / "one" / "series.csv");
  const std::vector<double>&cuts = one.at("straw.cut bonds"), &load = one.at("load");
  const auto row = std::find(cuts.begin(), cuts.end(), 1.0) - cuts.begin();
  ASSERT_LT(row, static_cast<std::ptrdiff_t>(cuts.size()));
  const double force = 2.2e6 * M_PI / 4 * 4e-3 * 4e-3, most = *std::max_element(load.begin(), load.begin() + row);
  std::printf("load of the knife %.2f N at most before the cut; sigma_e A = %.2f N\n", most, force);
  EXPECT_NEAR(most, force, 3e-3 * force);
  EXPECT_EQ(most, *std::max_element(load.begin(), load.end())) << "no more after it";
  EXPECT_EQ(cuts.back(), 1);

  ASSERT_EQ(run_scenario(file, dir / "all"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "all"), all = summary["fibres"]["straw"]["at the end"];
  EXPECT_EQ(all["cut by edges"], 8);
  EXPECT_EQ(all["broken bonds"], 8);
  EXPECT_EQ(summary["bonds"]["cut by edges"], 8);
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 2e-3);
}

/// In soil of rigid clumps, too.
TEST(FibresOfAScenario, LieOnClumps) {
  std::string text = pass(kLinear);
  const std::string bed = "    fill: rest-lattice\n    material: soil\n    radius: 8 mm\n";
  text.replace(text.find(bed), bed.size(),
               "    fill: lattice\n    material: soil\n    radius: 8 mm\n    clumps: [{shape: clod, share: 0.5}]\n");
  text.replace(
      text.find("  surface: 0 mm\n"), 16,
      "  surface: 0 mm\n  clumps: {clod: {spheres: [{at: 0 0 0 mm, radius: 7 mm}, {at: 8 0 0 mm, radius: 7 mm}]}}\n");
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 1e-2);
  EXPECT_GT(summary["soil"]["clumps"].get<int>(), 10);
  EXPECT_GT(summary["fibres"]["straw"]["at the end"]["mass [kg]"].get<double>(), 0.01);
}

/// A bed from a file has spheres of its own densities. Fibres are laid on it, so the file states none of theirs.
TEST(FibresOfAScenario, LieOnABedFromAFile) {
  std::string text = pass(kLinear);
  const std::string bed = "    fill: rest-lattice\n    material: soil\n    radius: 8 mm\n    depth: 50 mm\n";
  text.replace(text.find(bed), bed.size(), "    fill: file\n    material: soil\n    file: bed.csv\n");
  const RunDirectory dir;
  std::string rows = "x [m],y [m],z [m],radius [m],density [kg/m^3]\n";
  for (int i = 0; i < 14; ++i)
    for (int k = 0; k < 7; ++k) rows += fmt::format("{},0.008,{},0.008,1900\n", 0.009 + 0.0165 * i, 0.009 + 0.0165 * k);
  write_file(dir / "bed.csv", rows);
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out", {"time.end=5 ms"}), exit_ok);
  const std::string warnings = summary_of(dir / "out")["warnings"].dump();
  EXPECT_NE(warnings.find("spheres of `soil` have the 1900 kg/m^3 of the file"), std::string::npos) << warnings;
  EXPECT_EQ(warnings.find("spheres of `straw`"), std::string::npos) << warnings;
}

/// Bits of the whole state: positions and velocities, histories and bonds, and which sphere belongs to which fibre.
TEST(FibresOfAScenario, ARestartEndsWithTheSameBits) {
  const RunDirectory dir;
  const std::string file = dir.scenario(pass(kLinear));
  ASSERT_EQ(run_scenario(file, dir / "whole", {"output.state every=75 ms"}), exit_ok);
  std::filesystem::path state;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "whole"))
    if (entry.path().filename().string().rfind("state-0.07", 0) == 0) state = entry.path();
  ASSERT_FALSE(state.empty());
  ASSERT_EQ(run_scenario(file, dir / "again", {}, state), exit_ok);
  const std::size_t a = frame_times(dir / "whole").size() - 1, b = frame_times(dir / "again").size() - 1;
  const std::vector<Vec3> x = frame_positions(dir / "whole", a), y = frame_positions(dir / "again", b);
  ASSERT_EQ(x.size(), y.size());
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_EQ(x[i], y[i]) << i;
  const nlohmann::json one = summary_of(dir / "whole")["fibres"]["straw"],
                       other = summary_of(dir / "again")["fibres"]["straw"];
  for (const char* when : {"at the start", "at the end"}) EXPECT_EQ(one[when], other[when]) << when;
  EXPECT_EQ(FramesFile(dir / "whole" / "run.h5").fibre(), FramesFile(dir / "again" / "run.h5").fibre());
}

/// A settling that continues from a state under the fibres, or before they are laid, ends with the same bits.
TEST(FibresOfAScenario, ASettlingThatContinuesEndsWithTheSameBits) {
  const Loaded loaded = load_scenario_text(pass(kLinear));
  std::vector<dem::SettleState> kept;
  BuildOptions options;
  options.threads = 1;
  long asked = 0;
  options.keep_settling_due = [&] { return ++asked % 50 == 0; };
  options.keep_settling = [&](const dem::SettleState& state, const dem::Bed&) { kept.push_back(state); };
  const World whole = build_world(loaded, options);
  ASSERT_GT(kept.size(), 3U);
  ASSERT_GT(kept.back().bed.bonds.size(), 0U) << "the last one has fibres";
  ASSERT_EQ(kept.front().bed.bonds.size(), 0U) << "the first one has none";
  for (const dem::SettleState* from : {&kept.front(), &kept.back()}) {
    BuildOptions again;
    again.threads = 1, again.settling = from;
    const World other = build_world(loaded, again);
    const dem::Bed::State a = whole.bed->save(), b = other.bed->save();
    ASSERT_EQ(a.spheres.size(), b.spheres.size());
    for (std::size_t i = 0; i < a.spheres.size(); ++i) {
      ASSERT_EQ(a.spheres[i].id, b.spheres[i].id);
      ASSERT_EQ(a.spheres[i].x, b.spheres[i].x);
      ASSERT_EQ(a.spheres[i].v, b.spheres[i].v);
    }
    EXPECT_EQ(a.bonds.size(), b.bonds.size());
    EXPECT_EQ(other.soil.fibres_from, whole.soil.fibres_from);
    EXPECT_EQ(other.fibres.front().first, whole.fibres.front().first);
    EXPECT_EQ(other.soil.fibres.front().buried, whole.soil.fibres.front().buried);
  }
}

/// In a region in the bed they take the place of soil: none of it lies in a fibre.
TEST(FibresOfAScenario, RootsTakeThePlaceOfSoil) {
  const RunDirectory dir;
  const std::string file = dir.scenario(pass(kLinear));
  const std::vector<std::string> sets{"soil.bed.fibres.straw.region={at: 60 5 10 mm, size: 120 40 100 mm}",
                                      "time.end=1 ms", "soil.bed.fibres.straw.mass per area=1.5 kg/m^2"};
  ASSERT_EQ(run_scenario(file, dir / "out", sets), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_GT(summary["soil"]["left out for fibres"].get<int>(), 5);
  // In the bed: below its mean surface, which is at 0.
  const FramesFile frames(dir / "out" / "run.h5");
  const std::vector<Vec3> x = frame_positions(dir / "out", 0);
  std::size_t all = 0, below = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (frames.fibre()[i] >= 0) ++all, below += x[i].y < 0 ? 1 : 0;
  EXPECT_GT(below, 0.9 * static_cast<double>(all));
  EXPECT_LT(summary["run"]["largest overlap [share of a radius]"].get<double>(), 0.1);
  const double plan = 0.12 * 0.1;
  EXPECT_NEAR(summary["fibres"]["straw"]["at the start"]["mass [kg]"].get<double>(), 1.5 * plan,
              0.5 * kStraw * M_PI / 4 * kDiameter * kDiameter * kLength);
}

TEST(FibresOfAScenario, RefusesWhatCannotBe) {
  const RunDirectory dir;
  const std::string file = dir.scenario(pass(kLinear));
  const auto refusal = [&](const std::vector<std::string>& sets) {
    return subsoil::test::message_of([&] { run_scenario(file, dir / "out", sets); });
  };
  const auto holds = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const std::string straw = "soil.bed.fibres.straw.";
  EXPECT_PRED2(holds, refusal({straw + "length=8 mm"}), "a fibre is two diameters long at least");
  EXPECT_PRED2(holds, refusal({straw + "count=10"}), "has `count` and `mass per area`; keep one of them");
  EXPECT_PRED2(holds, refusal({straw + "mass per area=1e-5 kg/m^2"}), "is less than half a fibre");
  EXPECT_PRED2(holds, refusal({straw + "scatter=0.1 rad"}), "give `orientation: x`");
  EXPECT_PRED2(holds, refusal({straw + "material=soil"}), "has no `bond: fibre` in its contact with itself");
  EXPECT_PRED2(holds, refusal({straw + "material=hay"}), "hay");
  EXPECT_PRED2(holds, refusal({straw + "length=400 mm"}), "find no room");
  EXPECT_PRED2(holds,
               refusal({straw + "region={at: 60 5 10 mm, size: 60 40 60 mm}", straw + "mass per area=50 kg/m^2"}),
               "fewer or shorter ones, or more room");
  EXPECT_PRED2(holds, refusal({"gravity=0 0 -9.81 m/s^2", "soil.surface=~"}), "there is no surface to lay fibres on");
  EXPECT_PRED2(holds, refusal({"soil.bed.save=bed.h5"}), "whose bonds the file of a bed does not keep");
  EXPECT_PRED2(holds, refusal({"soil.bed.fibres=~"}), "joins the spheres of a fibre");
}

/// Edges of tools and the strength of fibres against them act on each other only. Each refusal names its line.
TEST(FibresOfAScenario, RefusesEdgesAndStrengthsWithoutEffect) {
  const RunDirectory dir;
  const std::string edges = "cutting edges: 30 deg", strength = "bond cutting strength: 1 MPa";
  const std::string blade = "shape: {box: 10 120 60 mm}", yield = "bond yield stress: 30 kPa";
  const auto refusal = [&](const std::string& given, bool has_strength, const std::string& shape = "") {
    std::string text = pass(kLinear);
    text.replace(text.find(blade), blade.size(),
                 (shape.empty() ? blade : shape) + (given.empty() ? "" : ",\n     " + given));
    if (has_strength) text.replace(text.find(yield), yield.size(), strength);
    const std::string file = dir.scenario(text), key = has_strength && given.empty() ? strength : given;
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find(key)), '\n');
    const std::string message = subsoil::test::message_of([&] { run_scenario(file, dir / "out"); });
    EXPECT_NE(message.find(fmt::format("{}:{}:", file, line)), std::string::npos) << message;
    return message;
  };
  const auto holds = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_PRED2(holds, refusal(edges, false), "no `bond: fibre` has a `bond cutting strength`; give one");
  EXPECT_PRED2(holds, refusal("", true), "no surface has `cutting edges`; give the tool its edges");
  EXPECT_PRED2(holds, refusal(edges, true), "the sharpest has 90 deg; raise the angle");
  EXPECT_PRED2(holds, refusal("cutting edges: 200 deg", true), "must be in (0, 3.1]");
  EXPECT_PRED2(holds, refusal("cutting edges: 0 deg", true), "must be in (0, 3.1]");
  EXPECT_PRED2(holds, refusal(edges, true, "shape: {plane: {point: -0.1 0 0 m, normal: 1 0 0}}"),
               "a plane or a cylinder has none");
  EXPECT_PRED2(holds, refusal(edges, true, "shape: {cylinder: {radius: 5 mm, length: 60 mm}}"),
               "a plane or a cylinder has none");
}

/// Not after a bed has settled for minutes.
TEST(FibresOfAScenario, AreRefusedBeforeTheBedSettles) {
  const RunDirectory dir;
  const std::string file = dir.scenario(pass(kLinear));
  const auto settles = [&](const std::vector<std::string>& sets) {
    int reports = 0;
    const std::string text = subsoil::test::message_of([&] {
      build_world(load_scenario(file, sets), {.threads = 1, .progress = [&](double, double) { return ++reports < 3; }});
    });
    return std::pair(reports, text);
  };
  EXPECT_GT(settles({}).first, 0);
  const auto [reports, text] = settles({"soil.bed.fibres.straw.length=400 mm"});
  EXPECT_EQ(reports, 0);
  EXPECT_NE(text.find("find no room"), std::string::npos) << text;
}

}  // namespace
}  // namespace subsoil::sim::fibres
