#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

#include "libsim/io/hdf5.hpp"
#include "libsim/io/rounding.hpp"
#include "libsim/io/run_writer.hpp"
#include "tests/tools/scratch.hpp"
#include "tests/tools/xdmf.hpp"

namespace subsoil::sim::output_run_writer_test {
namespace {

using dem::Vec3;
using test::check_xdmf;

/// A bed whose every number is a known function of particle, frame and column.
struct WrittenBed {
  explicit WrittenBed(std::size_t n) : position(n), velocity(n), spin(n), force(n), torque(n), contacts(n) {
    for (std::size_t i = 0; i < n; ++i) {
      table.id.push_back(static_cast<std::int64_t>(10 + 3 * i));
      table.radius.push_back(0.010 + 1e-5 * static_cast<double>(i % 7));
      table.density.push_back(1800);
      table.material.push_back(static_cast<int>(i % 2));
    }
    table.material_names = {"soil", "stone"};
  }
  void at(int frame) {
    for (std::size_t i = 0; i < position.size(); ++i) {
      const double a = static_cast<double>(i), t = 0.02 * frame;
      position[i] = {0.018 * a, -0.1 - 0.01 * t, 0.3 * t};
      velocity[i] = {0.1 + a * 1e-3, -t, 1.0 / (1 + a)};
      spin[i] = {a, -a, t};
      force[i] = {-1.5 * a, 1e-6 * t, 7};
      torque[i] = {1e-9 * a, 0, -t};
      contacts[i] = static_cast<int>(i) % 13;
    }
  }
  Frame frame(int number, std::span<const dem::Pose> poses) {
    at(number);
    return {.time = 0.02 * number,
            .step = 1000L * number,
            .id = {},
            .position = position,
            .velocity = velocity,
            .spin = spin,
            .force = force,
            .torque = torque,
            .contacts = contacts,
            .surfaces = poses};
  }
  ParticleTable table;
  std::vector<Vec3> position, velocity, spin, force, torque;
  std::vector<int> contacts;
};

std::vector<OutputSurface> tool_and_floor() {
  const std::vector<std::array<int, 3>> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return {{"shovel/tip", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, faces, true},
          {"floor", {{0, 0, 0}, {5, 0, 0}, {5, 0, 5}}, {{0, 1, 2}}, false}};
}

std::vector<dem::Pose> poses_at(double time) {
  return {{{0.5 * time, 0, 0}, dem::Quaternion::from_rotation_vector({0, 0, time})}, {}};
}

/// Frame `number` of a file is there in every digit that its precision promises.
void expect_frame(hid_t file, int number, WrittenBed& bed, double relative) {
  bed.at(number);
  const std::string group = "/frames/00000" + std::to_string(number);
  const h5::Handle place(H5Gopen2(file, group.c_str(), H5P_DEFAULT), H5Gclose, group);
  EXPECT_EQ(h5::number_attribute(place, "time"), 0.02 * number);
  EXPECT_EQ(h5::number_attribute(place, "step"), 1000.0 * number);
  EXPECT_EQ(h5::read<std::uint8_t>(file, group + "/written"), std::vector<std::uint8_t>{1});
  const auto compare = [&](const char* column, const std::vector<Vec3>& expected, double absolute) {
    const auto read = h5::read<double>(file, group + "/" + column);
    ASSERT_EQ(read.size(), 3 * expected.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      const double value = expected[i / 3][static_cast<int>(i % 3)];
      ASSERT_NEAR(read[i], value, absolute + relative * std::abs(value)) << column << " entry " << i;
    }
  };
  // A position is off by half a quantum at most; the quantum is at most 1e-4 of the smallest radius.
  compare("position", bed.position, relative > 1e-7 ? 0.5e-4 * 0.010 : 0);
  compare("velocity", bed.velocity, 0);
  compare("spin", bed.spin, 0);
  compare("force", bed.force, 0);
  compare("torque", bed.torque, 0);
  EXPECT_EQ(h5::read<std::int32_t>(file, group + "/contacts"), bed.contacts);
}

TEST(RunWriter, EveryNumberComesBackToItsPrecision) {
  // Rounded: 14 mantissa bits, so 2^-15. float32: half a unit in the last place, 2^-24. float64: as it was.
  const std::pair<FramePrecision, double> cases[] = {{FramePrecision::rounded, std::exp2(-15)},
                                                     {FramePrecision::float32, std::exp2(-24)},
                                                     {FramePrecision::float64, 0}};
  for (const auto& [precision, relative] : cases) {
    test::Scratch scratch;
    WrittenBed bed(500);
    RunOptions options;
    options.precision = precision;
    RunWriter writer(scratch.path(), bed.table, tool_and_floor(), options);
    for (int k = 0; k < 3; ++k) writer.write(bed.frame(k, poses_at(0.02 * k)));
    writer.finish();
    const auto file = h5::open_file(scratch / "run.h5");
    for (int k = 0; k < 3; ++k) expect_frame(file, k, bed, relative);
    EXPECT_FALSE(h5::exists(file, "/frames/000003"));
    EXPECT_EQ(h5::read<std::int64_t>(file, "/particles/id"), bed.table.id);
    EXPECT_EQ(h5::read_text(file, "/particles/material names"), bed.table.material_names);
    // Per frame: topology and geometry of two surfaces, position, point numbers, 5 columns and 4 properties of the
    // spheres.
    EXPECT_EQ(check_xdmf(scratch / "run.xdmf"), 3 * (2 * 2 + 2 + 5 + 4));
  }
}

TEST(RunWriter, SeveralChunksOfUnevenLengthComeBack) {
  test::Scratch scratch;
  WrittenBed bed(150001);  // ten chunks of 15001 rows, the last with 14992
  RunWriter writer(scratch.path(), bed.table, {}, {});
  writer.write(bed.frame(0, {}));
  writer.finish();
  const auto file = h5::open_file(scratch / "run.h5");
  expect_frame(file, 0, bed, std::exp2(-15));
  const auto radius = h5::read<float>(file, "/particles/radius");
  for (std::size_t i = 0; i < radius.size(); ++i) ASSERT_EQ(radius[i], static_cast<float>(bed.table.radius[i])) << i;
}

TEST(RunWriter, SurfacesStandWhereTheirPoseSays) {
  test::Scratch scratch;
  RunWriter writer(scratch.path(), {}, tool_and_floor(), {});
  const double quarter = std::acos(0.0);
  const std::vector<dem::Pose> poses{{{2, 3, 4}, dem::Quaternion::from_rotation_vector({0, 0, quarter})},
                                     {{9, 9, 9}, {}}};
  writer.write({.time = 1,
                .step = 5,
                .id = {},
                .position = {},
                .velocity = {},
                .spin = {},
                .force = {},
                .torque = {},
                .contacts = {},
                .surfaces = poses});
  writer.finish();
  const auto file = h5::open_file(scratch / "run.h5");
  const auto moved = h5::read<double>(file, "/frames/000000/surfaces/shovel_tip");
  const double expected[] = {2, 3, 4, 2, 4, 4, 1, 3, 4, 2, 3, 5};                      // x -> y, y -> -x, then shifted
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(moved[i], expected[i], 1e-6) << i;  // float32 of numbers near 5
  EXPECT_FALSE(h5::exists(file, "/frames/000000/surfaces/floor")) << "a fixed surface is written once";
  EXPECT_EQ(check_xdmf(scratch / "run.xdmf"), 4);
}

/// At 2 km a float has steps of 0.1 mm.
TEST(RunWriter, PositionsFarFromTheOriginKeepTheirPrecision) {
  test::Scratch scratch;
  WrittenBed bed(100);
  RunWriter writer(scratch.path(), bed.table, {}, {});
  for (const double away : {0.0, 2000.0}) {
    const Frame frame = bed.frame(away > 0 ? 1 : 0, {});
    for (Vec3& x : bed.position) x.x += away;
    writer.write(frame);
  }
  writer.finish();
  const auto file = h5::open_file(scratch / "run.h5");
  EXPECT_EQ(h5::kind_of(file, "/frames/000000/position").bytes, 4);
  EXPECT_EQ(h5::kind_of(file, "/frames/000001/position").bytes, 8);
  const auto read = h5::read<double>(file, "/frames/000001/position");
  ASSERT_EQ(read.size(), 3 * bed.position.size());
  for (std::size_t i = 0; i < read.size(); ++i)
    ASSERT_NEAR(read[i], bed.position[i / 3][static_cast<int>(i % 3)], 0.5e-4 * 0.010) << i;
  check_xdmf(scratch / "run.xdmf");
}

/// Spheres that inlets pour come later: until then the arrays are there, without rows.
TEST(RunWriter, AFrameWithoutSpheresHasEveryArray) {
  test::Scratch scratch;
  WrittenBed bed(6);
  RunWriter writer(scratch.path(), bed.table, {}, {});
  Frame frame = bed.frame(0, {});
  const std::vector<std::int64_t> none;
  frame.id = none;
  frame.position = {}, frame.contacts = {};
  for (auto column : {&Frame::velocity, &Frame::spin, &Frame::force, &Frame::torque}) frame.*column = {};
  writer.write(frame);
  writer.write(bed.frame(1, {}));
  writer.finish();
  const auto file = h5::open_file(scratch / "run.h5");
  for (const char* array : {"position", "velocity", "contacts", "id"})
    EXPECT_EQ(h5::shape(file, std::string("/frames/000000/") + array).front(), 0U) << array;
  check_xdmf(scratch / "run.xdmf");
}

TEST(RunWriter, AFrameWithFewerSpheresCarriesItsOwnIds) {
  test::Scratch scratch;
  WrittenBed bed(6);
  RunWriter writer(scratch.path(), bed.table, {}, {});
  writer.write(bed.frame(0, {}));
  auto frame = bed.frame(1, {});
  const std::vector<std::int64_t> left{10, 16, 25};  // rows 0, 2 and 5 of the table
  frame.id = left;
  frame.position = frame.position.first(3);
  for (auto column : {&Frame::velocity, &Frame::spin, &Frame::force, &Frame::torque})
    frame.*column = (frame.*column).first(3);
  frame.contacts = frame.contacts.first(3);
  writer.write(frame);
  const std::vector<std::int64_t> stranger{10, 16, 26};
  frame.id = stranger;
  EXPECT_NE(test::message_of<std::invalid_argument>([&] { writer.write(frame); }).find("sphere 26"), std::string::npos);
  frame.id = left;
  frame.time = 7;
  writer.write(frame);  // a frame refused half-way leaves its place free
  EXPECT_EQ(writer.frames(), 3);
  writer.finish();
  const auto file = h5::open_file(scratch / "run.h5");
  EXPECT_EQ(h5::read<std::int64_t>(file, "/frames/000002/id"), left);
  EXPECT_FALSE(h5::exists(file, "/frames/000000/id"));
  EXPECT_EQ(h5::read<std::int64_t>(file, "/frames/000001/id"), left);
  const auto radius = h5::read<float>(file, "/frames/000001/radius");
  EXPECT_EQ(radius, (std::vector<float>{0.01000f, 0.01002f, 0.01005f}));
  check_xdmf(scratch / "run.xdmf");
}

TEST(RunWriter, RegionAndColumnsLimitWhatIsWritten) {
  test::Scratch scratch;
  WrittenBed bed(100);
  RunOptions options;
  options.columns = {"velocity"};
  options.region = FrameBox{{0.5, -1, -1}, {1.0, 1, 1}};
  RunWriter writer(scratch.path(), bed.table, {}, options);
  writer.write(bed.frame(0, {}));
  writer.finish();
  const auto file = h5::open_file(scratch / "run.h5");
  // x = 0.018 i lies in [0.5, 1.0] for i = 28 ... 55.
  const auto ids = h5::read<std::int64_t>(file, "/frames/000000/id");
  ASSERT_EQ(ids.size(), 28u);
  EXPECT_EQ(ids.front(), 10 + 3 * 28);
  EXPECT_EQ(ids.back(), 10 + 3 * 55);
  EXPECT_TRUE(h5::exists(file, "/frames/000000/velocity"));
  EXPECT_FALSE(h5::exists(file, "/frames/000000/force"));
  check_xdmf(scratch / "run.xdmf");
}

/// Faster than the disk: they share files, and all are there.
TEST(RunWriter, ManyFramesAreWritten) {
  test::Scratch scratch;
  WrittenBed bed(3);
  RunWriter writer(scratch.path(), bed.table, {}, {});
  for (int k = 0; k < 70; ++k) writer.write(bed.frame(k, {}));
  EXPECT_EQ(writer.frames(), 70);
  writer.finish();
  const auto file = h5::open_file(scratch / "run.h5");
  EXPECT_TRUE(h5::exists(file, "/frames/000069/position"));
  EXPECT_FALSE(h5::exists(file, "/frames/000070"));
}

TEST(RunWriter, RefusesWhatDoesNotFit) {
  test::Scratch scratch;
  WrittenBed bed(4);
  RunOptions options;
  options.columns = {"speed"};
  EXPECT_NE(test::message_of<std::invalid_argument>([&] {
              RunWriter(scratch.path(), bed.table, {}, options);
            }).find("'speed': must be one of position"),
            std::string::npos);
  EXPECT_NE(test::message_of<std::runtime_error>([&] {
              RunWriter(scratch / "nowhere", bed.table, {}, {});
            }).find("nowhere/frames: No such file"),
            std::string::npos);
  RunWriter writer(scratch.path(), bed.table, {}, {});
  auto frame = bed.frame(0, {});
  frame.force = frame.force.first(3);
  EXPECT_NE(
      test::message_of<std::invalid_argument>([&] { writer.write(frame); }).find("force has 3 entries, 4 spheres"),
      std::string::npos);
}

/// Writes frames for ever; a test kills it.
[[noreturn]] void write_until_killed(const std::filesystem::path& directory) {
  WrittenBed bed(2000);
  RunWriter writer(directory, bed.table, tool_and_floor(), {});
  for (int k = 0;; ++k) writer.write(bed.frame(k % 10, poses_at(0.02 * k)));
}

TEST(RunWriter, AKilledRunKeepsItsFrames) {
  // SIGKILL at times spread over several frames, so that it falls into every part of one.
  for (int trial = 0; trial < 12; ++trial) {
    test::Scratch scratch;
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) write_until_killed(scratch.path());
    for (int wait = 0; test::text_of(scratch / "run.xdmf").find("frame 2") == std::string::npos; ++wait) {
      ASSERT_LT(wait, 60000) << "the writer wrote nothing";
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(std::chrono::microseconds(3700 * trial));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);

    check_xdmf(scratch / "run.xdmf");
    const auto frames = test::Xml(test::text_of(scratch / "run.xdmf")).all("Time").size();
    EXPECT_GE(frames, 3u);
    const auto file = h5::open_file(scratch / "run.h5");
    WrittenBed bed(2000);
    for (int k = 0; k < static_cast<int>(std::min<std::size_t>(frames, 10)); ++k)
      expect_frame(file, k, bed, std::exp2(-15));
    // The file takes a stranger's reader too: every group can be walked, unfinished ones included.
    EXPECT_GE(H5Ovisit2(
                  file, H5_INDEX_NAME, H5_ITER_NATIVE,
                  [](hid_t, const char*, const H5O_info_t*, void*) -> herr_t { return 0; }, nullptr, H5O_INFO_BASIC),
              0);
  }
}

TEST(Xdmf, ReaderOfThisTestSeesFaults) {
  for (const char* bad : {"<a><b></a></b>", "<a x=1/>", "<a>", "<a/><b/>", "<a>&what;</a>", "<a x=\"1\" x=\"2\"/>"})
    EXPECT_THROW(test::Xml{bad}, std::runtime_error) << bad;
  const test::Xml good("<?xml version=\"1.0\"?>\n<a x=\"&quot;&amp;\"><b/>\n<b>t&lt;</b></a>\n");
  ASSERT_EQ(good.all("b").size(), 2u);
  EXPECT_EQ(good.all("b")[1]->text, "t<");
  EXPECT_EQ(good.all("a")[0]->attributes.at("x"), "\"&");
}

TEST(Xdmf, NamesOfTheUserAreEscaped) {
  test::Scratch scratch;
  auto surfaces = tool_and_floor();
  surfaces[0].name = "wing <\"left\"> & tip";
  RunOptions options;
  options.title = "a & b";
  RunWriter writer(scratch.path(), {}, surfaces, options);
  WrittenBed none(0);
  writer.write(none.frame(0, poses_at(0)));
  writer.finish();
  EXPECT_EQ(check_xdmf(scratch / "run.xdmf"), 4);
  const test::Xml document(test::text_of(scratch / "run.xdmf"));
  EXPECT_EQ(document.all("Grid").at(2)->attributes.at("Name"), surfaces[0].name);
}

TEST(Rounding, MantissaIsRoundedToNearestAndKeepsSpecialValues) {
  for (const float x : {1.0f, -0.3f, 1e-30f, 123456.7f, 3.0e38f}) {
    const float y = round_mantissa(x, 14);
    EXPECT_LE(std::abs(y - x), std::exp2(-15) * std::abs(x)) << x;
    EXPECT_EQ(round_mantissa(y, 14), y) << "rounding twice is rounding once";
  }
  EXPECT_EQ(round_mantissa(0.0f, 14), 0.0f);
  EXPECT_TRUE(std::isinf(round_mantissa(INFINITY, 14)));
  EXPECT_TRUE(std::isnan(round_mantissa(NAN, 14)));
  EXPECT_EQ(power_of_two_below(1e-6), std::exp2(-20));
}

}  // namespace
}  // namespace subsoil::sim::output_run_writer_test
