#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "libsim/io/disk.hpp"
#include "libsim/io/joined_frame.hpp"
#include "libsim/io/part_writer.hpp"
#include "libsim/io/run_writer.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/scratch.hpp"
#include "tests/tools/xdmf.hpp"

/// Frames whose spheres several processes write, without the processes: the same spheres written by one writer and
/// dealt to parts must be read back the same.
namespace subsoil::sim::output_parts_test {
namespace {

using dem::Vec3;

/// Some spheres, every number a function of the id and the frame.
struct Soil {
  Soil(const std::vector<std::int64_t>& ids, int frame) {
    for (const std::int64_t id : ids) {
      const double a = static_cast<double>(id), t = 0.02 * frame;
      table.id.push_back(id), table.radius.push_back(0.010 + 1e-5 * static_cast<double>(id % 7));
      table.density.push_back(1800 + 100 * static_cast<double>(id % 3));
      table.material.push_back(static_cast<int>(id % 2));
      position.push_back({0.018 * a, -0.1 - 0.01 * t, 0.3 * t});
      velocity.push_back({0.1 + a * 1e-3, -t, 1.0 / (1 + a)});
      spin.push_back({a, -a, t}), force.push_back({-1.5 * a, 1e-6 * t, 7}), torque.push_back({1e-9 * a, 0, -t});
      contacts.push_back(static_cast<int>(id) % 13);
    }
    table.material_names = {"soil", "stone"};
  }
  Frame frame(int number) const {
    Frame f;
    f.time = 0.02 * number, f.step = 1000L * number;
    f.position = position, f.velocity = velocity, f.spin = spin, f.force = force, f.torque = torque;
    f.contacts = contacts;
    return f;
  }
  ParticleTable table;
  std::vector<Vec3> position, velocity, spin, force, torque;
  std::vector<int> contacts;
};

std::vector<std::int64_t> all_ids(std::size_t n) {
  std::vector<std::int64_t> ids;
  for (std::size_t i = 0; i < n; ++i) ids.push_back(static_cast<std::int64_t>(10 + 3 * i));
  return ids;
}

/// Deals spheres to ranks by their id, otherwise in every frame; the last rank has none.
class DealtParts final : public FrameParts {
 public:
  DealtParts(std::vector<std::int64_t> ids, int ranks, RunOptions options)
      : ids_(std::move(ids)), ranks_(ranks), options_(std::move(options)) {}
  int count() const override { return ranks_; }
  void open(const std::filesystem::path& directory, double quantum) override {
    for (int k = 0; k < ranks_; ++k) writers_.push_back(std::make_unique<PartWriter>(directory, k, options_, quantum));
  }
  std::string write(const PartPlace& place, const Between&) override {
    std::string xml;
    for (int k = 0; k < ranks_; ++k) {
      std::vector<std::int64_t> mine;
      for (const std::int64_t id : ids_)
        if ((id / 3 + place.frame) % (ranks_ - 1) == k) mine.push_back(id);
      const Soil soil(mine, static_cast<int>(place.frame));
      xml += writers_[static_cast<std::size_t>(k)]->write(place, soil.table, soil.frame(0));
    }
    return xml;
  }
  void publish() override {
    for (const auto& writer : writers_) writer->publish();
  }
  void drop() override {
    for (const auto& writer : writers_) writer->drop();
  }
  dem::Snapshot gather() override { return {}; }
  void restore(const dem::Snapshot&) override {}

 private:
  std::vector<std::int64_t> ids_;
  int ranks_;
  RunOptions options_;
  std::vector<std::unique_ptr<PartWriter>> writers_;
};

void write_parts(const std::filesystem::path& folder, std::size_t spheres, int frames, const RunOptions& options = {},
                 int ranks = 4) {
  DealtParts parts(all_ids(spheres), ranks, options);
  RunWriter writer(folder, Soil(all_ids(spheres), 0).table, {}, options, {}, &parts);
  for (int k = 0; k < frames; ++k) {
    Frame frame;
    frame.time = 0.02 * k, frame.step = 1000L * k;
    writer.write(frame);
  }
  writer.finish();
}

void write_gathered(const std::filesystem::path& folder, std::size_t spheres, int frames,
                    const RunOptions& options = {}) {
  RunWriter writer(folder, Soil(all_ids(spheres), 0).table, {}, options);
  for (int k = 0; k < frames; ++k) {
    const Soil soil(all_ids(spheres), k);
    writer.write(soil.frame(k));
  }
  writer.finish();
}

std::string group(int frame) { return "/frames/00000" + std::to_string(frame); }

TEST(FrameParts, AreJoinedToWhatOneWriterWrites) {
  test::Scratch scratch;
  std::filesystem::create_directory(scratch / "parts"), std::filesystem::create_directory(scratch / "one");
  write_parts(scratch / "parts", 500, 3), write_gathered(scratch / "one", 500, 3);
  const auto parts = h5::open_file(scratch / "parts/run.h5"), one = h5::open_file(scratch / "one/run.h5");
  for (int k = 0; k < 3; ++k) {
    const JoinedFrame joined(parts, group(k)), whole(one, group(k));
    EXPECT_TRUE(joined.in_parts());
    EXPECT_FALSE(whole.in_parts());
    EXPECT_EQ(joined.read<std::int64_t>("id"), all_ids(500));
    for (const char* name : {"position", "velocity", "spin", "force", "torque"})
      EXPECT_EQ(joined.read<float>(name), whole.read<float>(name)) << name << " of frame " << k;
    EXPECT_EQ(joined.read<std::int32_t>("contacts"), whole.read<std::int32_t>("contacts"));
    for (const char* name : {"radius", "density"})
      EXPECT_EQ(joined.read<float>(name), h5::read<float>(one, std::string("/particles/") + name)) << name;
    EXPECT_EQ(joined.read<std::int32_t>("material"), h5::read<std::int32_t>(one, "/particles/material"));
  }
  // Per frame and part that has spheres: position, point numbers, 5 columns and 4 properties.
  EXPECT_EQ(test::check_xdmf(scratch / "parts/run.xdmf"), 3 * 3 * (2 + 5 + 4));
  const FramesFile a(scratch / "parts/run.h5"), b(scratch / "one/run.h5");
  EXPECT_EQ(a.times(), b.times());
  EXPECT_EQ(a.spheres(2, true).position, b.spheres(2, true).position);
  EXPECT_EQ(a.spheres(2, true).velocity, b.spheres(2, true).velocity);
  EXPECT_EQ(a.spheres(2, true).index, b.spheres(2, true).index);
  EXPECT_EQ(a.counts(2, "contacts"), b.counts(2, "contacts"));
}

/// The temporal collection holds frames, a frame the soil, the soil its parts.
TEST(FrameParts, AreOneSoilInEveryInstant) {
  test::Scratch scratch;
  write_parts(scratch.path(), 50, 2);
  const test::Xml document(test::text_of(scratch / "run.xdmf"));
  int frames = 0;
  for (const auto* grid : document.all("Grid")) {
    if (grid->attributes.at("Name").rfind("frame ", 0) != 0) continue;
    ++frames;
    const auto* soil = grid->child("Grid");
    EXPECT_EQ(soil->attributes.at("Name"), "soil");
    EXPECT_EQ(soil->attributes.at("CollectionType"), "Spatial");
    EXPECT_EQ(soil->children.size(), 3u) << "the last rank has no spheres, and no grid";
  }
  EXPECT_EQ(frames, 2);
}

TEST(FrameParts, OfARegionAreJoinedToo) {
  test::Scratch scratch;
  RunOptions options;
  options.columns = {"velocity"};
  options.region = FrameBox{{0.5, -1, -1}, {1.0, 1, 1}};
  write_parts(scratch.path(), 100, 1, options);
  std::vector<std::int64_t> inside;
  for (const std::int64_t id : all_ids(100))
    if (0.018 * static_cast<double>(id) >= 0.5 && 0.018 * static_cast<double>(id) <= 1.0) inside.push_back(id);
  const auto file = h5::open_file(scratch / "run.h5");
  const JoinedFrame joined(file, group(0));
  EXPECT_EQ(joined.read<std::int64_t>("id"), inside);
  EXPECT_TRUE(joined.holds("velocity"));
  EXPECT_FALSE(joined.holds("force"));
  test::check_xdmf(scratch / "run.xdmf");
}

TEST(FrameParts, AMissingOneIsRefusedByItsName) {
  test::Scratch scratch;
  write_parts(scratch.path(), 50, 1);
  std::filesystem::remove(scratch / "frames/000000.rank-01.h5");
  const std::string said =
      test::message_of<std::runtime_error>([&] { FramesFile(scratch / "run.h5").spheres(0, false); });
  EXPECT_NE(said.find((scratch / "frames/000000.rank-01.h5").string() + ": is missing"), std::string::npos) << said;
  EXPECT_NE(said.find("keep run.h5 and all of the folder frames together"), std::string::npos) << said;
}

TEST(FrameParts, ASphereInTwoIsRefused) {
  test::Scratch scratch;
  write_parts(scratch.path(), 50, 1);
  std::filesystem::copy_file(scratch / "frames/000000.rank-00.h5", scratch / "frames/000000.rank-01.h5",
                             std::filesystem::copy_options::overwrite_existing);
  const std::string said =
      test::message_of<std::runtime_error>([&] { FramesFile(scratch / "run.h5").spheres(0, false); });
  EXPECT_NE(said.find("is in two parts"), std::string::npos) << said;
}

TEST(FrameParts, AFolderThatAProcessDoesNotSeeIsRefusedWithTheCure) {
  test::Scratch scratch;
  const std::string said =
      test::message_of<std::invalid_argument>([&] { PartWriter(scratch / "elsewhere", 3, {}, 1e-6); });
  EXPECT_NE(said.find("elsewhere/frames: process 3 does not see this folder"), std::string::npos) << said;
  EXPECT_NE(said.find("frames: gathered"), std::string::npos) << said;
}

/// A run that goes on leaves no part of what came after the state.
TEST(FrameParts, OfFramesThatAreMadeAnewGo) {
  test::Scratch scratch;
  write_parts(scratch.path(), 50, 1);
  const WrittenFrames one{{0}};
  std::filesystem::copy_file(scratch / "frames/000000.rank-03.h5", scratch / "frames/000001.rank-03.h5");
  DealtParts parts(all_ids(50), 3, {});
  RunWriter writer(scratch.path(), Soil(all_ids(50), 0).table, {}, {}, one, &parts);
  EXPECT_TRUE(std::filesystem::exists(scratch / "frames/000000.rank-03.h5"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "frames/000001.rank-03.h5"));
}

TEST(FrameParts, AreRefusedWithAnEngineOfOneProcess) {
  const test::RunDirectory dir;
  const std::string said =
      test::message_of<ScenarioError>([&] { load_scenario(dir.scenario(test::small_pass), {"output.frames=parts"}); });
  EXPECT_NE(
      said.find(
          "output.frames: has no effect: it is of `engine: liggghts`, which works on many processes; leave it out"),
      std::string::npos)
      << said;
}

/// While it lives, no file of this process gets longer.
class LengthLimit {
 public:
  explicit LengthLimit(rlim_t bytes) : handler_(signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit least{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &least);
  }
  ~LengthLimit() { setrlimit(RLIMIT_FSIZE, &before_), signal(SIGXFSZ, handler_); }
  LengthLimit(const LengthLimit&) = delete;
  LengthLimit& operator=(const LengthLimit&) = delete;

 private:
  rlimit before_{};
  sighandler_t handler_;
};

/// 12 kB a file, less than a part takes: as on a disk that is full after the first frame.
TEST(FrameParts, AFullDiskNamesThePartAndKeepsEarlierFrames) {
  test::Scratch scratch;
  write_parts(scratch.path(), 2000, 1);
  DealtParts parts(all_ids(2000), 4, {});
  RunWriter writer(scratch.path(), Soil(all_ids(2000), 0).table, {}, {}, WrittenFrames{{0}}, &parts);
  Frame frame;
  frame.time = 0.02;
  std::string said;
  {
    const LengthLimit limit(12000);
    said = test::message_of<DiskFault>([&] { writer.write(frame), writer.publish(); });
  }
  EXPECT_NE(said.find("frames/000001.rank-00.h5"), std::string::npos) << said;
  const FramesFile file(scratch / "run.h5");
  EXPECT_EQ(file.times().size(), 1u);
  EXPECT_EQ(file.spheres(0, true).index.size(), 2000u);
  for (const auto& entry : std::filesystem::directory_iterator(scratch / "frames"))
    EXPECT_EQ(entry.path().filename().string().find("000001"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace subsoil::sim::output_parts_test
