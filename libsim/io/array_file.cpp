#include "libsim/io/array_file.hpp"

#include <system_error>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/hdf5_driver.hpp"

namespace subsoil::sim {

void ArrayFile::begin(const std::string& name) {
  name_ = name;
  file_ = h5::create_file(temporary_name(directory_ / name));
}

void ArrayFile::check() const { h5::status_of(file_)->check(); }

std::uint64_t ArrayFile::end() {
  h5::close_file(file_);
  put_in_place(directory_ / name_);
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(directory_ / name_, unknown);
  return unknown ? 0 : bytes;
}

void ArrayFile::drop() {
  unnamed_.clear();
  file_ = {};
  std::error_code ignored;
  if (!name_.empty()) std::filesystem::remove(temporary_name(directory_ / name_), ignored);
}

void ArrayFile::name_all() {
  for (const auto& [path, object] : unnamed_) h5::link(object, file_, path);
  unnamed_.clear();
}

}  // namespace subsoil::sim
