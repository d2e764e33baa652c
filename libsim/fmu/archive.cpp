#include "libsim/fmu/archive.hpp"

#include <minizip/zip.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "libsim/io/atomic_file.hpp"

namespace subsoil::sim {
namespace {

/// One archive, closed with its scope.
class OpenZip {
 public:
  explicit OpenZip(const std::filesystem::path& file) : zip_(zipOpen64(file.c_str(), APPEND_STATUS_CREATE)) {
    if (zip_ == nullptr) throw std::runtime_error("the file cannot be opened");
  }
  ~OpenZip() {
    if (zip_ != nullptr) zipClose(zip_, nullptr);
  }
  OpenZip(const OpenZip&) = delete;
  OpenZip& operator=(const OpenZip&) = delete;

  void begin(const std::string& name) {
    constexpr uLong unix_system = 3, utf8_names = 1UL << 11;
    zip_fileinfo info{};
    info.tmz_date = {0, 0, 0, 1, 0, 1980};  // the first that the format knows: equal input, equal archive
    info.external_fa = (0100755UL << 16);   // a regular file that all may read; the shared object may be loaded
    check(name, zipOpenNewFileInZip4_64(zip_, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                                        Z_DEFAULT_COMPRESSION, 0, -MAX_WBITS, DEF_MEM_LEVEL, Z_DEFAULT_STRATEGY,
                                        nullptr, 0, unix_system << 8, utf8_names, 1));
  }
  void write(const std::string& name, const char* data, std::size_t count) {
    constexpr std::size_t most = 1 << 20;  // the library takes 32 bits
    for (std::size_t at = 0; at < count; at += most)
      check(name, zipWriteInFileInZip(zip_, data + at, static_cast<unsigned>(std::min(most, count - at))));
  }
  void end(const std::string& name) { check(name, zipCloseFileInZip(zip_)); }
  void close() {
    const zipFile closed = zip_;
    zip_ = nullptr;
    check("the directory of entries", zipClose(closed, nullptr));
  }

 private:
  static void check(const std::string& what, int code) {
    if (code != ZIP_OK)
      throw std::runtime_error(what + ": code " + std::to_string(code) + " of minizip; is the disk full?");
  }
  zipFile zip_;
};

}  // namespace

ZipWriter::ZipWriter(std::filesystem::path path) : path_(std::move(path)) {
  if (!std::ofstream(temporary_name(path_)))
    throw std::invalid_argument("--out " + path_.string() + ": cannot be written; name a file in a folder that exists");
}

ZipWriter::~ZipWriter() {
  std::error_code ignored;
  std::filesystem::remove(temporary_name(path_), ignored);
}

void ZipWriter::commit() {
  const std::filesystem::path temporary = temporary_name(path_);
  try {
    OpenZip zip(temporary);
    for (const auto& [name, text] : texts_) {
      zip.begin(name);
      zip.write(name, text.data(), text.size());
      zip.end(name);
    }
    std::vector<char> part(1 << 20);
    for (const auto& [name, file] : files_) {
      std::ifstream in(file, std::ios::binary);
      if (!in) throw std::runtime_error(file.string() + ": cannot be read");
      zip.begin(name);
      while (in) {
        in.read(part.data(), static_cast<std::streamsize>(part.size()));
        zip.write(name, part.data(), static_cast<std::size_t>(in.gcount()));
      }
      if (in.bad()) throw std::runtime_error(file.string() + ": cannot be read to its end");
      zip.end(name);
    }
    zip.close();
    put_in_place(path_);
  } catch (const std::exception& error) {
    throw std::runtime_error(path_.string() + ": cannot be written: " + error.what());
  }
}

}  // namespace subsoil::sim
