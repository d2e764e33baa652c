// What the fuzzers (scripts/fuzz) have found and what they start from: each input of tests/fuzz/corpus is read again,
// and read or refused, never more. Where apps/ changes the gate runs this under the sanitizers too.

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/targets.hpp"
#include "tests/tools/paths.hpp"

namespace subsoil::app::replay_corpora_test {
namespace {

class Corpus : public testing::TestWithParam<fuzz::Target> {};

TEST_P(Corpus, IsReadOrRefused) {
  const std::filesystem::path folder =
      std::filesystem::path(subsoil::test::source_dir()) / "tests/fuzz/corpus" / GetParam().name;
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NO_THROW(GetParam().run(bytes)) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 2) << folder << " holds nothing to replay";
}

INSTANTIATE_TEST_SUITE_P(All, Corpus, testing::ValuesIn(fuzz::targets),
                         [](const auto& target) { return target.param.name; });

}  // namespace
}  // namespace subsoil::app::replay_corpora_test
