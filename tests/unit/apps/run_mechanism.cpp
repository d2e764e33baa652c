#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libsim/plot/plot.hpp"
#include "libsim/plot/strip.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/xml.hpp"

/// What a run of a mechanism leaves to look at: measures, outlines in frames, strips. Oracle: the geometry of Hoeken's
/// linkage, whose knee is where two circles meet.
namespace subsoil::sim::run_mechanism {
namespace {

using namespace test;

struct Place {
  double x, y;
};
/// Crank pin, knee and foot of configs/hoeken.yaml at time t.
struct Hoeken {
  Place elbow, knee, foot;
  explicit Hoeken(double t) {
    const double turn = std::numbers::pi * (1 + 2 * t);
    elbow = {0.1 * std::cos(turn), 0.1 * std::sin(turn)};
    const double dx = 0.2 - elbow.x, dy = -elbow.y, apart = std::hypot(dx, dy);
    const double height = std::sqrt(0.25 * 0.25 - apart * apart / 4);  // two bars of 0.25 m
    knee = {elbow.x + dx / 2 - height * dy / apart, elbow.y + dy / 2 + height * dx / apart};
    foot = {2 * knee.x - elbow.x, 2 * knee.y - elbow.y};
  }
};

class HoekenRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = std::make_unique<RunDirectory>();
    ASSERT_EQ(run_scenario(config("hoeken"), out()), exit_ok);
  }
  static void TearDownTestSuite() { dir_.reset(); }
  static std::filesystem::path out() { return *dir_ / "out"; }
  static std::unique_ptr<RunDirectory> dir_;
};
std::unique_ptr<RunDirectory> HoekenRun::dir_;

// The driven linkage follows the circles to the error of the fixed step, the straight stretch is what the file says.
TEST_F(HoekenRun, MeasuresAreColumnsWithTheValuesOfTheGeometry) {
  const Series series = read_series(out() / "series.csv");
  const std::vector<double>& t = series.at("time");
  ASSERT_EQ(t.size(), 201U);
  double straightest = 0, least = 4, largest = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const Hoeken at(t[i]);
    ASSERT_NEAR(series.at("path.x")[i], at.foot.x, 1e-12);
    ASSERT_NEAR(series.at("path.y")[i], at.foot.y, 1e-12);
    const double chord = std::hypot(at.elbow.x - 0.2, at.elbow.y);
    ASSERT_NEAR(series.at("transmission angle")[i], std::acos(1 - chord * chord / (2 * 0.25 * 0.25)), 1e-11);
    if (t[i] < 0.25 || t[i] > 0.75) straightest = std::max(straightest, std::abs(at.foot.y - 0.4));
    least = std::min(least, series.at("transmission angle")[i]);
    largest = std::max(largest, series.at("transmission angle")[i]);
  }
  EXPECT_LT(straightest, 1e-3);
  EXPECT_NEAR(least, std::acos(0.92), 1e-11);
  EXPECT_NEAR(largest, std::acos(0.28), 1e-11);
  // The bearing pushes on the frame with what the column of the joint, the frame's own, holds.
  for (const char* axis : {"x", "y"})
    EXPECT_EQ(series.at(std::string("on the frame.") + axis), series.at(std::string("bearing.f") + axis));
  EXPECT_EQ(series.columns[static_cast<std::size_t>(series.find("knee force"))].unit, "N");
  EXPECT_TRUE(summary_of(out())["columns"].contains("transmission angle")) << "extremes of measures are in the summary";
}

std::vector<double> numbers(const std::filesystem::path& out, const std::string& path) {
  return h5::read<double>(h5::open_file(out / "run.h5"), path);
}

// Frames of a machine without surfaces: outlines turn with their bodies, joints and markers are where they belong,
// measures stand beside them. Float32 of numbers below 1 m is good to 3e-8 m.
TEST_F(HoekenRun, FramesHoldOutlinesJointsMarkersAndMeasures) {
  const Hoeken at(0.3);
  const std::string frame = "/frames/000015/";
  const std::vector<double> joints = numbers(out(), frame + "surfaces/machine joints");
  const Place pins[] = {{0, 0}, at.elbow, at.knee, {0.2, 0}};
  ASSERT_EQ(joints.size(), 12U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(joints[3 * i], pins[i].x, 1e-7);
    EXPECT_NEAR(joints[3 * i + 1], pins[i].y, 1e-7);
  }
  EXPECT_NEAR(numbers(out(), frame + "surfaces/machine markers")[1], at.foot.y, 1e-7);
  // The given outline of the coupler begins 10 mm beyond the elbow, on the line from the foot.
  const std::vector<double> outline = numbers(out(), frame + "surfaces/coupler outline");
  ASSERT_EQ(outline.size(), 24U);
  EXPECT_NEAR(outline[0], at.knee.x + 0.26 / 0.25 * (at.elbow.x - at.knee.x), 1e-7);
  EXPECT_NEAR(outline[1], at.knee.y + 0.26 / 0.25 * (at.elbow.y - at.knee.y), 1e-7);
  const auto segments = [](const std::string& body) {
    return h5::read<std::int32_t>(h5::open_file(out() / "run.h5"), "/surfaces/" + body + " outline/segments").size() /
           2;
  };
  EXPECT_EQ(segments("coupler"), 8U);
  EXPECT_EQ(segments("rocker"), 1U) << "a bar between its two pins";
  EXPECT_NEAR(numbers(out(), frame + "values")[0], at.foot.x, 1e-12) << "path.x comes first";
  const Xml xdmf(text_of(out() / "run.xdmf"));
  const auto topologies = xdmf.all("Topology");
  const auto lines = std::count_if(topologies.begin(), topologies.end(), [](const Xml::Element* t) {
    return t->attributes.at("TopologyType") == "Polyline" && t->attributes.at("NodesPerElement") == "2";
  });
  EXPECT_EQ(lines, 3 * 51) << "three bodies in every frame";
}

TEST_F(HoekenRun, AStripShowsInstantsNamesAndScale) {
  if (!gnuplot_found()) GTEST_SKIP() << "gnuplot is not installed";
  StripOptions options;
  options.count = 5;
  strip(out(), *dir_ / "strip.svg", options);
  const std::string svg = text_of(*dir_ / "strip.svg");
  for (const char* words :
       {"Hoeken", "t = 0 s", "t = 0.25 s", "t = 0.5 s", "t = 1 s", "crank", "coupler", "rocker", "mm"})
    EXPECT_NE(svg.find(words), std::string::npos) << words;
  EXPECT_EQ(svg.find("t = 0.2 s"), std::string::npos);
}

TEST_F(HoekenRun, StripsRefuseWhatIsNotThere) {
  const auto refusal = [&](const StripOptions& options) {
    return message_of<std::invalid_argument>([&] { strip(out(), *dir_ / "no.svg", options); });
  };
  StripOptions options;
  options.paths = {"fot"};
  EXPECT_EQ(refusal(options), "--paths fot: no marker on a body, and no body; did you mean `foot`?");
  options.paths = {}, options.follow = "crunk";
  EXPECT_EQ(refusal(options), "--follow crunk: there is no body of this name; did you mean `crank`?");
  options.follow = "", options.times = {1.5};
  EXPECT_EQ(refusal(options), "--times 1.5: the run goes from 0 to 1 s; choose times in it");
  EXPECT_NE(message_of<std::invalid_argument>([&] {
              strip(*dir_ / "nothing", *dir_ / "no.svg");
            }).find("holds no scenario.yaml: is it the result directory of a run?"),
            std::string::npos);
}

// A rod hangs from a pin at rest: its one mode swings by so much that the end goes a tenth of the rod's length, stated
// as a factor on the table's shape; frames of the mode go once around, and the end's way is the same on both sides.
TEST(MechanismModes, ShapesAreFramesAndPictures) {
  const RunDirectory dir;
  const std::string file = dir.scenario(
      "subsoil: 1\nanalysis: modes\nmachine:\n  bodies:\n    rod: {mass: 1 kg, inertia: 0.0833333333333333 kg m^2, at: "
      "0 "
      "-0.5 m, angle: -90 deg, outline: [-0.5 -0.01 m, 0.5 -0.01 m, 0.5 0.01 m, -0.5 0.01 m]}\n  joints:\n    pin: "
      "{revolute: [ground, rod], at: 0 0 m}\n");
  ASSERT_EQ(run_scenario(file, dir / "out"), exit_ok);
  const std::vector<double> times = frame_times(dir / "out");
  ASSERT_EQ(times.size(), 24U);
  EXPECT_EQ(times.front(), 1) << "mode 1 runs from 1 to 2";
  EXPECT_EQ(times[12], 1.5);
  const auto end_at = [&](int frame) {
    return numbers(dir / "out", "/frames/0000" + std::string(frame < 10 ? "0" : "") + std::to_string(frame) +
                                    "/surfaces/rod outline")[3];
  };
  EXPECT_NEAR(std::abs(end_at(0) - end_at(12)) / 2, 0.1, 5e-4) << "along an arc of 0.1 rad";
  EXPECT_NEAR(end_at(6), -0.01, 1e-6) << "at a quarter of the period it passes its rest";
  EXPECT_TRUE(is_still(dir / "out"));
  if (!gnuplot_found()) GTEST_SKIP() << "gnuplot is not installed";
  strip(dir / "out", dir / "modes.svg");
  // sqrt(1.5 g / 1 m) / 2 pi; the largest entry of the table's shape is the end's way or the angle's, 1 or less.
  EXPECT_NE(text_of(dir / "modes.svg").find("mode 1: 0.6105 Hz, damping 0, shape x 0."), std::string::npos);
}

// With soil, columns of N are means over a row, so a measure of the pull and the joint's own column are the same mean.
TEST(MechanismMeasures, StandBesideTheSoilToo) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out",
                         {"time.end=20 ms", "machine.measures.rail force={reaction: rail, on: trolley}",
                          "machine.measures.way={position: tine, from: trolley, component: x}"}),
            exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  for (std::size_t i = 0; i < series.rows(); ++i) {
    // Nine digits are written; both columns are of the same number but its sign.
    EXPECT_NEAR(series.at("rail force.y")[i], -series.at("rail.fy")[i], 1e-8 * std::abs(series.at("rail.fy")[i]));
    EXPECT_NEAR(series.at("way")[i], series.at("tine.x")[i] - series.at("trolley.x")[i], 1e-9);
  }
  EXPECT_GT(std::abs(series.at("rail force.y")[5]), 10) << "the weight of trolley and tine";
}

/// A wheel is driven to and fro. Where it turns round, its own rut becomes the ground ahead: what the new ground had
/// stored under it is lost, and the balance closes to what the method is asked for.
TEST(RunMechanism, TheBalanceClosesWhereAWheelTurnsRound) {
  for (const char* integrator : {"cvode", "ida", "adams-moulton"}) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {{w: {{mass: 200 kg, inertia: 8 kg m^2, at: 0 0.3 m, velocity: 1.884955592153874 0 m/s}}}}
  drivers: {{d: {{coordinate: w.x, position: {{harmonic: {{amplitude: 0.3 m, frequency: 1 Hz}}}}}}}}
  forces:
    s: {{wheel on soil: w, radius: 0.3 m, width: 0.2 m, n: 0.7, k_c: 0 N/m^(1.7), k_phi: 1e6 N/m^(2.7), heave: reversible}}
time: {{end: 0.6 s, machine: {{integrator: {}}}}}
)",
                                         integrator);
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok) << integrator;
    const Series series = read_series(dir / "out" / "series.csv");
    double off = 0;
    for (const double b : series.at("energy.balance")) off = std::max(off, std::abs(b));
    const double lost = series.at("energy.lost").back();
    EXPECT_GT(lost, 100);
    // Steps of 1 ms of adams-moulton integrate what the slope of the rut swallows to 3e-5.
    EXPECT_LT(off, (std::string(integrator) == "adams-moulton" ? 1e-4 : 1e-6) * lost) << integrator;
  }
}

/// A point that is driven into the ground while it moves along, and the same 2^20 times as large in consistent units
/// (lengths, velocities by their root, masses by the third power): the depths are to scale, ruts included.
TEST(RunMechanism, TheRutOfAPointIsToScale) {
  const auto depth = [](double scale) {
    const RunDirectory dir;
    const double root = std::sqrt(scale), mass = scale * scale * scale;
    const std::string text =
        fmt::format(R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {{a: {{mass: {0} kg, inertia: {1} kg m^2, at: 0 {2} m, velocity: {3} 0 m/s}}}}
  forces:
    g:
      ground element: a
      stiffness: {{power: {4} N/m, depth exponent: 0.2, depth: {5} m, speed: {3} m/s, mass: {6} kg}}
      least speed: {7} m/s
      leaving speed: {8} m/s
      contact time: {9} s
    f: {{force: a, along y: {{harmonic: {{amplitude: {10} N, frequency: {11} Hz}}}}}}
time: {{end: {12} s}}
output: {{series every: {13} s}}
)",
                    20 * mass, mass * scale * scale, 0.05 * scale, root, 50e3 * scale * scale, 0.01 * scale, mass,
                    0.01 * root, 0.02 * root, 2e-3 * root, 600 * mass, 2.6 / root, root, 0.01 * root);
    EXPECT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
    const Series series = read_series(dir / "out" / "series.csv");
    return *std::max_element(series.at("g.depth").begin(), series.at("g.depth").end()) / scale;
  };
  const double large = depth(1);
  EXPECT_GT(large, 0.01);
  for (const double scale : {std::pow(2, -16), std::pow(2, 16)})
    EXPECT_NEAR(depth(scale), large, 1e-4 * large) << scale;
}

/// A block on a guide stops at 0.0406 s and sticks: it passes 0 m/s once, and has been above it for that long, with
/// every method. What is left of its speed is rounding.
TEST(RunMechanism, WhatSticksIsCountedAtRest) {
  for (const char* integrator : {"cvode", "ida", "adams-moulton"}) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {{b: {{mass: 2 kg, inertia: 0.02 kg m^2, at: 0 0 m, velocity: 0.3 0.1 m/s}}}}
  joints: {{g: {{translational: [ground, b], at: 0 0 m, along: 3 1}}}}
  forces: {{f: {{joint friction: g, guide: 0.2 m, mu_s: 0.6, mu_k: 0.5, stick stiffness: 1 MN/m}}}}
time: {{end: 2 s, machine: {{integrator: {}}}}}
output: {{monitor: {{n: {{count: b.vy}}, up: {{time above: b.vy, at: 0 m/s}}}}}}
)",
                                         integrator);
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok) << integrator;
    const Series series = read_series(dir / "out" / "series.csv");
    EXPECT_LE(series.at("n").back(), 2) << integrator;
    EXPECT_NEAR(series.at("up").back(), 0.0406482, 2e-6) << integrator;
  }
}

/// A disk that sticks on the ground while a joint beside it has friction, and its mirror image.
TEST(RunMechanism, WhatSticksIsDampedAlikeInAMirror) {
  const auto angles = [](double side) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
gravity: 10 m/s^2
machine:
  bodies:
    disk: {{mass: 2 kg, inertia: 0.02 kg m^2, at: 0 0.1 m, velocity: {0} 0 m/s}}
    arm: {{mass: 3 kg, inertia: 0.06 kg m^2, at: {1} 0.3 m, velocity: {0} 0 m/s}}
  joints: {{p: {{revolute: [disk, arm], at: {2} 0.14 m}}}}
  forces:
    c: {{line contact: [ground, disk], ends: [0 0.0001666666667 m, 0 0.1 m], along: 1 0, radius: 0.1 m, n: 1,
        stiffness: 300 kN/m, damping: 3 s/m, friction: 0.5, stick stiffness: 2 kN/m}}
    jf: {{joint friction: p, radius: 90 mm, mu_s: 0.8, mu_k: 0.8}}
time: {{end: 0.3 s}}
)",
                                         0.3 * side, 0.25 * side, 0.02 * side);
    EXPECT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
    return read_series(dir / "out" / "series.csv").at("arm.angle");
  };
  const std::vector<double> one = angles(1), other = angles(-1);
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(one[i], -other[i], 1e-6) << i;
}

/// A block on two corners is pushed to and fro and sticks at each turn, on both corners at once. They share what they
/// hold, so that it comes back to the same place in every period, and the other push, and the other order of corners,
/// give the same path.
TEST(RunMechanism, CornersThatStickAtOnceShareWhatTheyHold) {
  for (const char* integrator : {"cvode", "ida", "adams-moulton"}) {
    const auto places = [&](int push, const char* corners) {
      const RunDirectory dir;
      const std::string text = fmt::format(R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {{block: {{mass: 3 kg, inertia: 0.1 kg m^2, at: 0 2 m}}}}
  forces:
    push: {{force: block, along x: {{harmonic: {{amplitude: {} N, frequency: 1 Hz}}}}}}
    fr: {{outline contact: [ground, block], first: {{flat: 0 1.9 m}}, second: {{polygon: [{}]}},
         stiffness: 1 MN/m, n: 1, damping: 50 s/m, friction: 0.35, stick stiffness: 200 kN/m}}
time: {{end: 3 s, machine: {{integrator: {}}}}}
output: {{series every: 1 s}}
)",
                                           push, corners, integrator);
      EXPECT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
      return read_series(dir / "out" / "series.csv").at("block.x");
    };
    const char* const one = "-0.3 -0.1 m, 0.3 -0.1 m, 0.3 0.1 m, -0.3 0.1 m";
    const char* const other = "0.3 -0.1 m, 0.3 0.1 m, -0.3 0.1 m, -0.3 -0.1 m";
    const std::vector<double> x = places(16, one), mirrored = places(-16, one), turned = places(16, other);
    ASSERT_EQ(x.size(), 4u);
    EXPECT_GT(x[1], 3e-3);
    for (std::size_t k = 1; k < x.size(); ++k) {
      EXPECT_NEAR(x[k], x[1], 1e-6) << integrator << k;
      EXPECT_NEAR(mirrored[k], -x[k], 1e-6) << integrator << k;
      EXPECT_NEAR(turned[k], x[k], 1e-6) << integrator << k;
    }
  }
}

}  // namespace
}  // namespace subsoil::sim::run_mechanism
