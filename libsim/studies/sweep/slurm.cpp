#include "libsim/studies/sweep/slurm.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <stdexcept>

#include "libsim/io/atomic_file.hpp"

namespace subsoil::sim {
namespace {

/// In single quotes for the shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string command_of(const SlurmArray& a, const std::string& more) {
  std::string text = "exec " + quoted(std::filesystem::read_symlink("/proc/self/exe").string()) + " sweep " +
                     quoted(a.plan) + " --out " + quoted(a.folder.string());
  for (const std::string& set : a.sets) text += " --set " + quoted(set);
  return text + " " + more + "\n";
}

/// Output of a command; throws when it fails.
std::string output_of(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot start sbatch");
  std::string text;
  std::array<char, 256> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
  const int status = pclose(pipe);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  if (status != 0) throw std::runtime_error("sbatch refuses: " + text);
  return text;
}

}  // namespace

std::string task_list(const std::vector<std::size_t>& points) {
  std::string text;
  for (std::size_t i = 0; i < points.size();) {
    std::size_t j = i;
    while (j + 1 < points.size() && points[j + 1] == points[j] + 1) ++j;
    text += fmt::format("{}{}", text.empty() ? "" : ",", points[i]);
    if (j > i) text += fmt::format("-{}", points[j]);
    i = j + 1;
  }
  return text;
}

std::vector<std::filesystem::path> write_slurm(const SlurmArray& a) {
  const std::filesystem::path log = a.folder / "slurm";
  std::filesystem::create_directories(log);
  const std::string limit = a.at_once > 0 ? fmt::format("%{}", a.at_once) : "";
  const std::string array = fmt::format(
      "#!/bin/bash\n#SBATCH --job-name={}\n#SBATCH --array={}{}\n#SBATCH --ntasks=1\n#SBATCH --cpus-per-task={}\n"
      "#SBATCH --output={}/%a.txt\n",
      quoted(a.name), task_list(a.points), limit, a.threads, log.string());
  const std::string gather =
      fmt::format("#!/bin/bash\n#SBATCH --job-name={}\n#SBATCH --ntasks=1\n#SBATCH --output={}/gather.txt\n",
                  quoted(a.name + "-gather"), log.string());
  const std::vector<std::filesystem::path> scripts{a.folder / "sweep.sbatch", a.folder / "gather.sbatch"};
  write_atomically(scripts[0], array + command_of(a, "--point \"$SLURM_ARRAY_TASK_ID\""));
  write_atomically(scripts[1], gather + command_of(a, "--gather"));
  return scripts;
}

std::vector<std::string> submit_slurm(const std::vector<std::filesystem::path>& scripts) {
  if (std::system("command -v sbatch >/dev/null 2>&1") != 0)
    throw std::invalid_argument(
        fmt::format("--slurm: sbatch is not on the PATH; on a login node of the cluster: sbatch {}, then sbatch {}",
                    scripts[0].string(), scripts[1].string()));
  const std::string first = output_of("sbatch --parsable " + quoted(scripts[0].string()));
  const std::string number = first.substr(0, first.find(';'));
  const std::string second =
      output_of(fmt::format("sbatch --parsable --dependency=afterany:{} {}", number, quoted(scripts[1].string())));
  return {number, second.substr(0, second.find(';'))};
}

}  // namespace subsoil::sim
