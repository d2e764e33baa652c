// What the fuzzers (scripts/fuzz) have found and what they start from: each input of tests/fuzz/corpus is read again,
// and changed copies of it, and read or refused, never more. Where apps/ changes the gate runs this under the
// sanitizers too.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tests/fuzz/targets.hpp"
#include "tests/tools/paths.hpp"

namespace subsoil::sim::replay_corpora_test {
namespace {

struct Input {
  std::filesystem::path path;
  std::string bytes;
};

/// In the order of their names: that of a directory is not the same everywhere.
std::vector<Input> inputs_of(const fuzz::Target& target) {
  const std::filesystem::path folder =
      std::filesystem::path(subsoil::test::source_dir()) / "tests/fuzz/corpus" / target.name;
  std::set<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) paths.insert(entry.path());
  std::vector<Input> out;
  for (const std::filesystem::path& path : paths) {
    std::ifstream in(path, std::ios::binary);
    out.push_back({path, {std::istreambuf_iterator<char>(in), {}}});
  }
  return out;
}

/// One of the inputs as a slip of an editor, a disk or a transfer leaves it: some bytes changed, doubled, taken out,
/// put in from another input, or the rest missing.
std::string changed(const std::vector<Input>& inputs, std::mt19937& random) {
  static const std::array<std::string, 7> pieces{
      "1e308", "-1", "nan", "((((", "999999999999", "\n: ", std::string(8, '\xff')};
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  const std::string& other = inputs[below(inputs.size())].bytes;
  std::string out = inputs[below(inputs.size())].bytes;
  for (std::size_t left = 1 + below(4); left > 0; --left) {
    const std::size_t at = below(out.size()), length = std::min(1 + below(64), out.size() - at);
    switch (below(8)) {
      case 0:
        out.insert(at, pieces[below(pieces.size())]);
        break;
      case 1:
        out.erase(at, length);
        break;
      case 2:
        out.insert(at, out.substr(at, length));
        break;
      case 3:
        out.insert(at, other.substr(below(other.size()), length));
        break;
      case 4:
        out.resize(at);
        break;
      default:
        if (!out.empty()) out[at] = static_cast<char>(random());
    }
  }
  return out;
}

/// How a process of its own ends that reads the bytes; status of waitpid. It exits with 0 when they are read or
/// refused, with 2 when the HDF5 library itself fails at them (libsim/io/read_guard.hpp), with 3 by an exception that
/// is no refusal. A fault of ours ends it by a signal, or by the sanitizers' exit code; a reader that hangs by SIGALRM.
int status_of_reading(const fuzz::Target& target, const std::string& bytes) {
  const pid_t child = fork();
  if (child == 0) {
    ::alarm(30);
    try {
      target.run(bytes);
    } catch (...) {
      ::_exit(3);
    }
    ::_exit(0);
  }
  int status = -1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return status;
}

std::string kept(const fuzz::Target& target, const std::string& bytes) {
  const auto path = std::filesystem::temp_directory_path() / (std::string("subsoil-changed-") + target.name);
  std::ofstream(path, std::ios::binary) << bytes;
  return path.string();
}

class Corpus : public testing::TestWithParam<fuzz::Target> {};

TEST_P(Corpus, IsReadOrRefused) {
  const std::vector<Input> inputs = inputs_of(GetParam());
  for (const Input& input : inputs) EXPECT_NO_THROW(GetParam().run(input.bytes)) << input.path;
  EXPECT_GT(inputs.size(), 2U) << "nothing to replay";
}

TEST_P(Corpus, IsReadOrRefusedWhenChanged) {
  const std::vector<Input> inputs = inputs_of(GetParam());
  const bool reads_hdf5 = inputs.front().path.extension() == ".h5";
  std::mt19937 random(20261125);
  for (int k = 0; k < 200; ++k) {
    const std::string bytes = changed(inputs, random);
    const int status = status_of_reading(GetParam(), bytes);
    const bool guarded = reads_hdf5 && WIFEXITED(status) && WEXITSTATUS(status) == 2;
    ASSERT_TRUE(status == 0 || guarded) << "status " << status << " at " << kept(GetParam(), bytes);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Corpus, testing::ValuesIn(fuzz::targets),
                         [](const auto& target) { return target.param.name; });

}  // namespace
}  // namespace subsoil::sim::replay_corpora_test
