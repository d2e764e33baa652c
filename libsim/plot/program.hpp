#pragma once
#include <filesystem>
#include <string>
#include <vector>

/// Programs that draw for us: gnuplot, ffmpeg.
namespace subsoil::sim {

/// Whether PATH has a program of this name.
bool on_path(const std::string& name);

/// Runs a program of PATH, `words` its name and arguments, and waits for it; its output goes to `log`, its input is
/// empty. Returns the status as of waitpid(); throws std::runtime_error when it cannot be started.
int run_program(const std::vector<std::string>& words, const std::filesystem::path& log);

}  // namespace subsoil::sim
