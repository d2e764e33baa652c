#pragma once
#include <filesystem>

namespace subsoil::sim {

/// Waits until no process locks the file, for that time at most (s); whether none does, or there is no such file.
bool await_unlocked(const std::filesystem::path& file, double patience);

}  // namespace subsoil::sim
