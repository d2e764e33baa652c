#include "libdem/base/archive.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>

#include "libdem/base/vec3.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::dem::test {
namespace {

enum class Colour { red, green };

struct Grain {
  double mass = 0;
  Vec3 place;
  std::vector<double> history;
  void archive(Archive& a) { a("mass", mass)("place", place)("history", history); }
  bool operator==(const Grain&) const = default;
};

struct Whole {
  double time = 0;
  long steps = 0;
  bool begun = false;
  Colour colour = Colour::red;
  std::string name;
  std::optional<double> given, left_out = 1.0;
  std::array<int, 3> counts{};
  Quaternion turn;
  std::vector<Vec3> path;
  std::vector<std::string> words;
  std::deque<std::pair<double, double>> waiting;
  std::vector<Grain> grains;

  void archive(Archive& a) {
    a("time", time)("steps", steps)("begun", begun)("colour", colour)("name", name)("given", given);
    a("left out", left_out)("counts", counts)("turn", turn)("path", path)("words", words)("waiting", waiting);
    a("grains", grains);
  }
};

Whole whole() {
  Whole w;
  w.time = std::nextafter(0.1, 1), w.steps = (1L << 53) - 1, w.begun = true, w.colour = Colour::green;
  w.name = "a b", w.given = 3, w.left_out.reset(), w.counts = {1, 2, 3}, w.turn = {0.5, 0.5, 0.5, 0.5};
  w.path = {{1, 2, 3}, {4, 5, 6}}, w.words = {"", "x"}, w.waiting = {{1, 2}};
  w.grains = {{1, {1, 0, 0}, {7, 8}}, {2, {0, 1, 0}, {}}, {3, {0, 0, 1}, {9}}};
  return w;
}

Archive written() {
  Archive a;
  whole().archive(a);
  return a;
}

TEST(Archive, ReadsWhatItWrote) {
  Archive a = written().to_read();
  Whole back;
  back.archive(a);
  a.end();
  const Whole w = whole();
  EXPECT_EQ(back.time, w.time);
  EXPECT_EQ(back.steps, w.steps);
  EXPECT_EQ(back.begun, w.begun);
  EXPECT_EQ(back.colour, w.colour);
  EXPECT_EQ(back.name, w.name);
  EXPECT_EQ(back.given, w.given);
  EXPECT_EQ(back.left_out, w.left_out);
  EXPECT_EQ(back.counts, w.counts);
  EXPECT_EQ(back.turn.w, w.turn.w);
  EXPECT_EQ(back.path, w.path);
  EXPECT_EQ(back.words, w.words);
  EXPECT_EQ(back.waiting, w.waiting);
  EXPECT_EQ(back.grains, w.grains);
  EXPECT_EQ(a.columns().at("grains/history"), (std::vector<double>{7, 8, 9})) << "a field of records is one column";
}

/// Whatever one number or text of any field is short of, or one too many, is refused with the field's name.
TEST(Archive, NamesAFieldThatDoesNotBelong) {
  const auto refusal = [](const Archive& damaged) {
    return subsoil::test::message_of([&] {
      Archive a = damaged;
      Whole back;
      back.archive(a);
      a.end();
    });
  };
  EXPECT_EQ(refusal(written().to_read()), "accepted");
  const Archive good = written();
  for (const auto& [name, column] : good.columns())
    for (const bool more : {false, true}) {
      Archive::Columns columns = good.columns();
      more ? columns.at(name).push_back(0) : columns.at(name).pop_back();
      EXPECT_NE(refusal(Archive(columns, good.texts())), "accepted") << name << more;
    }
  Archive::Columns columns = good.columns();
  columns.erase("time");
  EXPECT_NE(refusal(Archive(columns, good.texts())).find("`time`"), std::string::npos);
  columns = good.columns();
  columns["other"] = {1};
  EXPECT_NE(refusal(Archive(columns, good.texts())).find("`other`"), std::string::npos);
}

/// A length is only what the file states: nothing is asked for that no column can fill.
TEST(Archive, RefusesALengthBeyondItsColumns) {
  Archive::Columns columns = written().columns();
  columns.at("path/size")[0] = 1e15;
  Archive a(columns, written().texts());
  Whole back;
  EXPECT_THROW(back.archive(a), std::invalid_argument);
}

TEST(Archive, RefusesAWholeNumberThatItsFieldCannotHold) {
  for (const double number : {1e30, -1e30, 0x1p63, std::numeric_limits<double>::quiet_NaN()}) {
    Archive::Columns columns = written().columns();
    columns.at("steps")[0] = number;
    Archive a(columns, written().texts());
    Whole back;
    EXPECT_THROW(back.archive(a), std::invalid_argument) << number;
  }
}

TEST(Archive, FindsFieldsAndGroups) {
  const Archive a = written().to_read();
  EXPECT_TRUE(a.has("time"));
  EXPECT_TRUE(a.has("grains"));
  EXPECT_TRUE(a.has("grains/mass"));
  EXPECT_TRUE(a.has("name")) << "a text";
  EXPECT_FALSE(a.has("grain"));
  EXPECT_FALSE(a.has("tim"));
}

}  // namespace
}  // namespace subsoil::dem::test
