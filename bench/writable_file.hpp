#pragma once
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace subsoil::bench {

/// Makes the folder of a file that is to be written and tries to write into it: before the work whose result it shall
/// hold, not after. Throws std::runtime_error that names what cannot be made.
inline void require_writable(const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::absolute(fs::path(file)).parent_path();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": the folder cannot be made: " + error.message());
  const std::string trial = file + ".trial";
  std::FILE* out = std::fopen(trial.c_str(), "w");
  if (out == nullptr) throw std::runtime_error(file + ": cannot be written; name a folder that can");
  std::fclose(out);
  fs::remove(trial, error);
}

}  // namespace subsoil::bench
