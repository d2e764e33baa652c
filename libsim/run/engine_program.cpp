#include "libsim/run/engine_program.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace subsoil::sim {
namespace {

/// Words of this process's command line, as the system keeps them.
std::vector<std::string> command_line() {
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(in), {}};
  std::vector<std::string> words;
  for (std::size_t at = 0; at < all.size(); at = all.find('\0', at) + 1) words.emplace_back(all.c_str() + at);
  return words;
}

/// As Open MPI tells what it starts; 1 without it.
int processes_of_mpirun() {
  const char* size = std::getenv("OMPI_COMM_WORLD_SIZE");
  return size == nullptr ? 1 : std::atoi(size);
}

}  // namespace

std::filesystem::path engine_program() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "subsoil-mpi";
}

void go_on_as_engine(const Loaded& loaded) {
  if (loaded.scenario.engine == SoilEngine::subsoil) {
    if (const int processes = processes_of_mpirun(); processes > 1)
      throw ScenarioError(
          fmt::format("{}mpirun started {} processes, and this engine works in one; give `--set engine=liggghts` "
                      "(docs/reference/many-nodes.md), or start it without mpirun (`subsoil sweep` runs many scenarios "
                      "side by side)",
                      loaded.where("engine") + " = subsoil: ", processes));
    return;
  }
  const std::filesystem::path program = engine_program();
  const std::string place = loaded.where("engine") + " = liggghts: ";
  if (!std::filesystem::exists(program))
    throw ScenarioError(
        fmt::format("{}needs {}, which is not there; build it after `scripts/setup --mpi`, or leave `engine` out",
                    place, program.string()));
  std::vector<std::string> words = command_line();
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw ScenarioError(fmt::format("{}{} does not start: {}", place, program.string(), std::strerror(errno)));
}

}  // namespace subsoil::sim
