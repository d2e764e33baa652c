#include "apps/output/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace subsoil::app {

std::filesystem::path temporary_name(const std::filesystem::path& path) {
  auto name = path;
  return name += ".part";
}

void put_in_place(const std::filesystem::path& path, bool durable) {
  const auto part = temporary_name(path);
  if (durable) {
    const int descriptor = ::open(part.c_str(), O_RDONLY | O_CLOEXEC);
    const bool kept = descriptor >= 0 && ::fsync(descriptor) == 0;
    const int error = errno;
    if (descriptor >= 0) ::close(descriptor);
    if (!kept) throw std::runtime_error("writing " + path.string() + ": " + std::strerror(error));
  }
  std::filesystem::rename(part, path);
}

void write_atomically(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(temporary_name(path), std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string() + ": is the directory writable, the disk full?");
  put_in_place(path);
}

}  // namespace subsoil::app
