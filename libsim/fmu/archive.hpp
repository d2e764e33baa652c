#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace subsoil::sim {

/// A ZIP archive under construction, with deflate. It is put in place complete or not at all.
class ZipWriter {
 public:
  /// Throws std::invalid_argument where no file can be written: before the content is made, which may take hours.
  explicit ZipWriter(std::filesystem::path path);
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;
  void add_text(const std::string& name, std::string text) { texts_.emplace_back(name, std::move(text)); }
  void add_file(const std::string& name, const std::filesystem::path& file) { files_.emplace_back(name, file); }
  /// Throws std::runtime_error naming the archive and the entry.
  void commit();

 private:
  std::filesystem::path path_;
  std::vector<std::pair<std::string, std::string>> texts_;
  std::vector<std::pair<std::string, std::filesystem::path>> files_;
};

}  // namespace subsoil::sim
