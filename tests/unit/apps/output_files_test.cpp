#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>

#include "libsim/io/bed_file.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/io/hdf5_driver.hpp"
#include "libsim/io/state_file.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/scratch.hpp"

namespace subsoil::sim::output_files_test {
namespace {

TEST(StateFile, ArraysComeBackAsTheyWere) {
  test::Scratch scratch;
  const auto path = state_path(scratch.path(), 0.25);
  EXPECT_EQ(path.filename(), "state-0.25.h5");
  std::vector<double> history(5000);
  for (std::size_t i = 0; i < history.size(); ++i) history[i] = std::sin(static_cast<double>(i)) / 3;
  const std::vector<std::uint32_t> partner{1, 4294967295u, 0};
  StateWriter writer(path);
  writer.put("soil/contacts/history", history);
  writer.put("soil/contacts/partner", partner);
  writer.put("soil/none", std::vector<std::int64_t>{});
  writer.put("time", 0.25);
  writer.put("step", std::int64_t{9007199254740993});  // 2^53 + 1: no double holds it
  writer.put_vectors("soil/position", std::vector<dem::Vec3>{{1, 2, 3}, {4, 5, 0.1}});
  writer.put_text("scenario", "title: Versuch mit Ümlaut\n");
  EXPECT_FALSE(std::filesystem::exists(path)) << "in place only when complete";
  writer.commit();

  const StateReader reader(path);
  EXPECT_EQ(reader.get<double>("soil/contacts/history"), history);
  EXPECT_EQ(reader.get<std::uint32_t>("soil/contacts/partner"), partner);
  EXPECT_TRUE(reader.get<std::int64_t>("soil/none").empty());
  EXPECT_EQ(reader.value<double>("time"), 0.25);
  EXPECT_EQ(reader.value<std::int64_t>("step"), 9007199254740993);
  EXPECT_EQ(reader.get_vectors("soil/position").at(1), (dem::Vec3{4, 5, 0.1}));
  EXPECT_EQ(reader.text("scenario"), "title: Versuch mit Ümlaut\n");
  EXPECT_FALSE(reader.has("machine/q"));
  EXPECT_FALSE(reader.has("soil/contacts/age"));
  EXPECT_NE(test::message_of<std::runtime_error>([&] { reader.get<double>("machine/q"); }).find("no machine/q"),
            std::string::npos);
  EXPECT_NE(test::message_of<std::runtime_error>([&] { reader.get<std::int32_t>("time"); }).find("another kind"),
            std::string::npos);
}

TEST(StateFile, RefusesAFormatOrAnArrayThatItDoesNotKnow) {
  test::Scratch scratch;
  const auto refusal = [&](const char* name, const std::function<void(StateWriter&)>& fill) {
    StateWriter writer(scratch / name);
    fill(writer);
    writer.commit();
    const StateReader reader(scratch / name);
    return test::message_of<std::runtime_error>([&] { reader.require_format(7, {"a", "group/"}); });
  };
  const auto expect = [](const std::string& said, const std::string& part) {
    EXPECT_NE(said.find(part), std::string::npos) << said;
    EXPECT_NE(said.find("this version reads states of format 7"), std::string::npos) << said;
  };
  expect(refusal("old.h5", [](StateWriter& w) { w.put("a", 1.0); }), "before states had a format number");
  expect(refusal("new.h5", [](StateWriter& w) { w.put_format(8); }), "is of format 8");
  expect(
      refusal("other.h5",
              [](StateWriter& w) { w.put_format(7), w.put("a", 1.0), w.put("group/b", 1.0), w.put("groups/c", 1.0); }),
      "holds `groups/c`");
  EXPECT_EQ(refusal("right.h5", [](StateWriter& w) { w.put_format(7), w.put("a", 1.0), w.put("group/b", 1.0); }),
            "accepted");
}

TEST(StateFile, AnUnfinishedStateLeavesTheOldOne) {
  test::Scratch scratch;
  const auto path = scratch / "state-1.h5";
  {
    StateWriter writer(path);
    writer.put("a", 1.0);
    writer.commit();
  }
  {
    StateWriter writer(path);
    writer.put("a", 2.0);  // no commit: an exception passed by
  }
  EXPECT_EQ(StateReader(path).value<double>("a"), 1.0);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1) << "no litter";
}

TEST(StateFile, AChangedByteOfAnArrayOrTextIsFound) {
  const test::Scratch scratch;
  const auto path = scratch / "state-1.h5";
  StateWriter writer(path);
  writer.put("a", std::vector<std::int64_t>{0x1122334455667788, 2});
  writer.put_texts("scenario", {"title: an unmistakable line", "more"});
  writer.commit();
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::size_t trailer = bytes.rfind("subsoil: all before");
  ASSERT_EQ(bytes.size() - trailer, 43U);
  // Each byte counts, of the structure too, which never comes to the library then.
  for (const std::size_t at : {std::size_t{0}, trailer / 7, trailer / 2, trailer - 1}) {
    std::string other = bytes;
    other[at] ^= 1;
    test::write_file(path, other);
    EXPECT_NE(test::message_of<std::runtime_error>([&] { StateReader{path}; }).find("the file is damaged"),
              std::string::npos)
        << at;
  }
  test::write_file(path, bytes);
  EXPECT_EQ(StateReader{path}.texts("scenario").size(), 2U);
  // In a file without a trailer each array is compared by itself.
  const auto refusal = [&](const std::string& changed) {
    std::string other = bytes.substr(0, trailer);
    const std::size_t at = other.find(changed);
    EXPECT_NE(at, std::string::npos);
    other[at] ^= 1;
    test::write_file(path, other);
    const StateReader reader(path);
    return test::message_of<std::runtime_error>([&] { reader.get<std::int64_t>("a"), reader.texts("scenario"); });
  };
  EXPECT_NE(refusal("\x88\x77\x66\x55\x44").find("`a` is not what was written: the file is damaged"),
            std::string::npos);
  EXPECT_NE(refusal("unmistakable").find("`scenario` is not what was written: the file is damaged"), std::string::npos);
}

/// A length is only what the file says: nothing is asked for that it cannot hold.
TEST(StateFile, ALengthWithoutItsBytesIsRefused) {
  const test::Scratch scratch;
  const auto path = scratch / "state-1.h5";
  {
    const h5::Handle file = h5::create_file(path);
    const hsize_t length = hsize_t{1} << 50, chunk = 1024;
    const h5::Handle space(H5Screate_simple(1, &length, nullptr), H5Sclose, "space");
    const h5::Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "list");
    h5::checked(H5Pset_chunk(list, 1, &chunk), "chunk");
    const h5::Handle set(H5Dcreate2(file, "a", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, list, H5P_DEFAULT), H5Dclose,
                         "set");
    const h5::Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "type");
    h5::checked(H5Tset_size(type, H5T_VARIABLE), "type");
    const h5::Handle text(H5Dcreate2(file, "text", type, space, H5P_DEFAULT, list, H5P_DEFAULT), H5Dclose, "text");
    const h5::Handle number(H5Dcreate2(file, "number", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, list, H5P_DEFAULT),
                            H5Dclose, "number");
  }
  const StateReader reader(path);
  const auto said = [&](auto read) { return test::message_of<std::runtime_error>(read); };
  EXPECT_NE(said([&] { reader.get<double>("a"); }).find("dataset a says it holds 1.126e+15 values and takes 0 bytes"),
            std::string::npos);
  EXPECT_NE(said([&] { reader.texts("text"); }).find("dataset text says it holds"), std::string::npos);
  EXPECT_NE(said([&] { reader.texts("number"); }).find("dataset number holds no text"), std::string::npos);
}

TEST(StateFile, LatestIsByTimeNotByName) {
  test::Scratch scratch;
  EXPECT_FALSE(latest_state(scratch.path()));
  for (const double time : {9.0, 10.0, 0.5}) {
    StateWriter writer(state_path(scratch.path(), time));
    writer.commit();
  }
  test::write_file(scratch / "state-99.h5.part", "cut off");
  test::write_file(scratch / "state-of-the-art.h5", "no state");
  EXPECT_EQ(latest_state(scratch.path())->filename(), "state-10.h5");
}

BedTable three_spheres() {
  return {{1, 2, 7},
          {{0.1, -1.0 / 3, 0}, {1e-9, 2, 3}, {-4, 5, 6}},
          {0.01, 0.011, 0.2},
          {1800, 1800, std::nan("")},
          {"soil", "a, \"b\"", ""},
          {{1, 0, 0}, {0, 0, 0}, {0, 0.1, 0}},
          {{0, 0, 1}, {0, 0, 0}, {0, 0, 1e29}}};
}

/// Numbers whose first `noisy` bytes are noise, and those before them zero; the others rise slowly.
template <class T>
std::vector<T> with_noise(std::size_t count, int zeros, int noisy) {
  std::mt19937_64 random(7);
  std::vector<T> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<unsigned char, sizeof(T)> bytes{};
    for (std::size_t b = 0; b < sizeof(T); ++b) {
      const int at = static_cast<int>(b) - zeros;
      bytes[b] = static_cast<unsigned char>(at < 0 ? 0 : at < noisy ? random() : i / 5000);
    }
    std::memcpy(&out[i], bytes.data(), sizeof(T));
  }
  return out;
}

template <class T>
void expect_back(const std::filesystem::path& path, std::size_t count, double most) {
  for (int zeros = 0; zeros < static_cast<int>(sizeof(T)); ++zeros)
    for (int noisy = 0; zeros + noisy < static_cast<int>(sizeof(T)); ++noisy)
      for (const int level : {0, 1, 4, 9}) {
        const std::vector<T> values = with_noise<T>(count, zeros, noisy);
        {
          h5::Handle file = h5::create_file(path);
          h5::write(file, "values", std::span<const T>(values), 1, level);
          h5::close_file(file);
        }
        const h5::Handle file = h5::open_file(path);
        const std::vector<T> back = h5::read<T>(file, "values");
        ASSERT_EQ(back.size(), count);
        EXPECT_EQ(std::memcmp(back.data(), values.data(), count * sizeof(T)), 0)
            << sizeof(T) << " bytes, " << zeros << " zero, " << noisy << " noise, level " << level;
        const auto bytes = static_cast<double>(std::filesystem::file_size(path));
        const double noise = static_cast<double>(count) * noisy;
        if (level > 0) {
          EXPECT_LT(bytes, noise + most) << zeros << " zero, " << noisy << " noise, level " << level;
        }
      }
}

/// What HDF5's own filters read of chunks that were packed here is what was written, to the last bit, wherever the
/// bytes of the numbers are zeros, noise or neither. Beside the noise a chunk takes less than a kilobyte for each of
/// its bytes.
TEST(Hdf5, NumbersOfNoiseAndZerosComeBack) {
  test::Scratch scratch;
  for (const std::size_t count : {1500u, 16384u, 70000u}) {  // one chunk, a full one, five
    const double most = 1e4 + 1e3 * 8 * 5;
    expect_back<float>(scratch.path() / "a.h5", count, most);
    expect_back<double>(scratch.path() / "b.h5", count, most);
    expect_back<std::int32_t>(scratch.path() / "c.h5", count, most);
    expect_back<std::uint8_t>(scratch.path() / "d.h5", 10 * count, most);
  }
}

TEST(BedFile, BothFormatsKeepEveryBit) {
  for (const char* name : {"bed.h5", "bed.csv"}) {
    test::Scratch scratch;
    const auto bed = three_spheres();
    save_bed(scratch / name, bed);
    const auto back = load_bed(scratch / name);
    EXPECT_EQ(back.id, bed.id) << name;
    EXPECT_EQ(back.position, bed.position) << name;
    EXPECT_EQ(back.radius, bed.radius) << name;
    EXPECT_EQ(back.material, bed.material) << name;
    EXPECT_EQ(back.velocity, bed.velocity) << name;
    EXPECT_EQ(back.spin, bed.spin) << name;
    EXPECT_EQ(back.density.at(1), 1800) << name;
    EXPECT_TRUE(std::isnan(back.density.at(2))) << name;
  }
}

TEST(BedFile, AHandWrittenListNeedsOnlyPlacesAndRadii) {
  test::Scratch scratch;
  test::write_file(scratch / "two.csv",
                   "radius [mm], x [m], y [m], z [m], vx [m/s]\n10, 0, 0, 0, 0.5\n\n12,1e-1,+2,3,\n");
  const auto millimetres = [](std::string_view unit, std::string_view si) {
    return unit == "mm" && si == "m" ? 1e-3 : 1.0;
  };
  const auto bed = load_bed(scratch / "two.csv", millimetres);
  EXPECT_EQ(bed.id, (std::vector<std::int64_t>{1, 2}));
  EXPECT_DOUBLE_EQ(bed.radius.at(1), 0.012);
  EXPECT_EQ(bed.position.at(1), (dem::Vec3{0.1, 2, 3}));
  EXPECT_EQ(bed.velocity.at(0), (dem::Vec3{0.5, 0, 0}));
  EXPECT_EQ(bed.velocity.at(1), (dem::Vec3{}));
  EXPECT_EQ(bed.material.at(0), "");
}

TEST(BedFile, RefusalsNamePlaceValueAndRule) {
  test::Scratch scratch;
  const auto refusal = [&](const std::string& text) {
    test::write_file(scratch / "b.csv", text);
    return test::message_of<std::invalid_argument>([&] { load_bed(scratch / "b.csv"); });
  };
  const auto expect = [&](const std::string& text, const std::string& part) {
    EXPECT_NE(refusal(text).find(part), std::string::npos) << refusal(text);
  };
  expect("x [m],y [m],z [m]\n", "b.csv:1: column 'radius' is missing");
  expect("x [m],y [m],z [m],radius\n", "column 'radius' has no unit; write 'radius [m]'");
  expect("x [mm],y [m],z [m],radius [m]\n", "column 'x': unit 'mm': must be m");
  expect("x [m],y [m],z [m],radius [m],weight [kg]\n", "column 'weight' is unknown; known are id, x");
  expect("x [m],y [m],z [m],radius [m]\n0,0,0,0.1\n0,0,0,-0.1\n", "b.csv:3: radius = -0.1 m: must be in (0, inf)");
  expect("x [m],y [m],z [m],radius [m]\n0,0,oops,0.1\n", "b.csv:2: z = 'oops': must be a finite number");
  expect("x [m],y [m],z [m],radius [m]\n0,0,0.1\n", "b.csv:2: 3 fields under 4 columns");
  expect("id,x [m],y [m],z [m],radius [m]\n4,0,0,0,1\n4,1,0,0,1\n", "id 4 stands twice");
  expect("x [m],y [m],z [m],radius [m]\n0,0,1e308,0.1\n", "b.csv:2: z = '1e308': must be a finite number below 1e30");
  expect("id,x [m],y [m],z [m],radius [m]\n1e20,0,0,0,1\n", "id = 1e+20: must be a whole number below 1e15");
  BedTable bed = three_spheres();
  bed.velocity[1].y = std::numeric_limits<double>::infinity();
  save_bed(scratch / "b.h5", bed);
  EXPECT_NE(test::message_of<std::invalid_argument>([&] {
              load_bed(scratch / "b.h5");
            }).find("b.h5: sphere 2 has radius 0.011 m, density 1800 kg/m^3, place (1e-09, 2, 3) m, speed inf m/s"),
            std::string::npos);
  EXPECT_NE(test::message_of<std::invalid_argument>([&] { load_bed(scratch / "bed.txt"); }).find(".h5 or .csv"),
            std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::output_files_test
