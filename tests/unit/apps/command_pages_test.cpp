#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// What the program prints about its own command line: bash completes by it, man shows it.
namespace subsoil::sim::command_pages_test {
namespace {

std::string output_of(const std::string& command, const test::Scratch& scratch) {
  const std::string out = scratch / "out";
  EXPECT_EQ(std::system(("bash -c '" + command + "' >" + out + " 2>&1").c_str()), 0) << test::text_of(out);
  return test::text_of(out);
}

/// What bash offers where the last of the words is being typed.
class Completion : public testing::Test {
 protected:
  Completion() {
    output_of(subsoil::test::program() + " reference --completion bash >" + (scratch_ / "script").string(), scratch_);
    std::filesystem::create_directory(scratch_ / "here");
    std::filesystem::create_directory(scratch_ / "here/my run");
    for (const char* file : {"tine.yaml", "notes.txt"}) test::write_file(scratch_ / "here" / file, "\n");
  }
  std::string offers(const std::string& words) const {
    return output_of(". " + (scratch_ / "script").string() + " && cd " + (scratch_ / "here").string() +
                         " && COMP_WORDS=(" + words + ") && COMP_CWORD=$((${#COMP_WORDS[@]} - 1)) && _subsoil && " +
                         "printf \"%s;\" \"${COMPREPLY[@]}\"",
                     scratch_);
  }

 private:
  test::Scratch scratch_;
};

TEST_F(Completion, Commands) {
  EXPECT_EQ(offers("subsoil re"), "resume;reference;report;");
  EXPECT_EQ(offers("subsoil --v"), "--version;");
}

TEST_F(Completion, OptionsOfACommand) {
  EXPECT_EQ(offers("subsoil run --st"), "--strict;");
  EXPECT_EQ(offers("subsoil plot --st"), "--strip;");
  EXPECT_EQ(offers("subsoil run tine.yaml --thr"), "--threads;");
}

TEST_F(Completion, WordsOfAnOption) {
  EXPECT_EQ(offers("subsoil impact --pictures p"), "png;pdf;");
  EXPECT_EQ(offers("subsoil run tine.yaml --simd av"), "avx2;avx512;");
  EXPECT_EQ(offers("subsoil run --threads \"\""), ";") << "a number";
}

TEST_F(Completion, ArgumentsByPlace) {
  EXPECT_EQ(offers("subsoil test sh"), "shear;shatter;");
  EXPECT_EQ(offers("subsoil test --threads 2 shear t"), "tine.yaml;");
  EXPECT_EQ(offers("subsoil run \"\""), "tine.yaml;my run;") << "scenarios and folders that may hold some";
  EXPECT_EQ(offers("subsoil plot \"\""), "my run;");
  EXPECT_EQ(offers("subsoil new vib"), "vibrating-shank;");
}

/// The scripts of the other shells: read without fault where the shell is there, and they name what bash offers.
TEST(OtherShells, ScriptsAreReadAndNameEveryCommand) {
  const test::Scratch scratch;
  for (const std::string shell : {"zsh", "fish"}) {
    const std::string script = scratch / shell;
    output_of(subsoil::test::program() + " reference --completion " + shell + " >" + script, scratch);
    const std::string text = test::text_of(script);
    std::istringstream words("run resume check new plot impact test calibrate report sweep portable shatter strict");
    for (std::string word; words >> word;) EXPECT_NE(text.find(word), std::string::npos) << shell << ": " << word;
    if (std::system(("command -v " + shell + " >/dev/null 2>&1").c_str()) == 0) {
      EXPECT_EQ(output_of(shell + " -n " + script, scratch), "");
    }
  }
  if (std::system("command -v fish >/dev/null 2>&1") == 0) {
    EXPECT_EQ(
        output_of("fish -c \". " + (scratch / "fish").string() + "; complete -C \\\"subsoil test sh\\\"\"", scratch),
        "shatter\nshear\n");
  }
}

TEST(ManPage, NamesEveryCommandAndReadsClean) {
  const test::Scratch scratch;
  const std::string page = scratch / "subsoil.1";
  output_of(subsoil::test::program() + " reference --man >" + page, scratch);
  const std::string text = test::text_of(page);
  std::istringstream words("run resume check explain materials new reference plot impact test calibrate report sweep");
  for (std::string word; words >> word;) EXPECT_NE(text.find(".SS subsoil " + word), std::string::npos) << word;
  EXPECT_NE(text.find(".B \\-\\-checkpoint\\-every"), std::string::npos);
  if (std::system("command -v groff >/dev/null 2>&1") == 0) {
    EXPECT_EQ(output_of("groff -man -Tutf8 -ww -z " + page, scratch), "");
  }
  if (std::system("command -v mandoc >/dev/null 2>&1") == 0) {
    EXPECT_EQ(output_of("mandoc -T lint -W error " + page, scratch), "");
  }
}

}  // namespace
}  // namespace subsoil::sim::command_pages_test
