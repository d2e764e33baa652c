#pragma once
#include <filesystem>
#include <functional>
#include <string>

namespace subsoil::sim {

/// Name beside `path` under which a file grows before it is put in place.
std::filesystem::path temporary_name(const std::filesystem::path& path);

/// Renames the temporary of `path` over it: a reader sees the old file or the new one, never half of one. With
/// `durable` the content is on the disk before, so that this also holds when the power goes.
void put_in_place(const std::filesystem::path& path, bool durable = true);

/// Writes text so.
void write_atomically(const std::filesystem::path& path, const std::string& text);

}  // namespace subsoil::sim
