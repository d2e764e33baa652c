#include "libsim/io/atomic_file.hpp"

#include <cerrno>

#include "libsim/io/disk.hpp"

namespace subsoil::sim {

std::filesystem::path temporary_name(const std::filesystem::path& path) {
  auto name = path;
  return name += ".part";
}

void rename_into_place(const std::filesystem::path& path) {
  std::error_code fault;
  std::filesystem::rename(temporary_name(path), path, fault);
  if (fault) refuse_write(path, fault.value());
}

void put_in_place(const std::filesystem::path& path, bool durable) {
  if (durable) sync_file(temporary_name(path));
  rename_into_place(path);
  if (durable) sync_folder(path.parent_path());
}

void write_atomically(const std::filesystem::path& path, const std::string& text) {
  OutFile file(temporary_name(path));
  file.write(text);
  file.close();
  put_in_place(path);
}

}  // namespace subsoil::sim
