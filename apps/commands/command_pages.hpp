#pragma once
#include <string>

namespace CLI {
class App;
}

/// Pages about the command line, of its own declarations.
namespace subsoil::sim {

/// Type names by which an option or argument states what it takes, in help and completion.
inline constexpr const char* takes_yaml = "FILE.yaml";
inline constexpr const char* takes_folder = "DIR";
inline constexpr const char* takes_simd = "{auto,portable,avx2,avx512}";

/// A script that bash sources: commands, options, words, files.
std::string bash_completion(const CLI::App& app);
/// The same for zsh: a file `_subsoil` of a folder in $fpath.
std::string zsh_completion(const CLI::App& app);
/// The same for fish: a file `subsoil.fish`.
std::string fish_completion(const CLI::App& app);
/// subsoil(1), in roff.
std::string man_page(const CLI::App& app);

}  // namespace subsoil::sim
