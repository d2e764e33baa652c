#pragma once
#include <string>

#include "libsim/io/hdf5.hpp"

namespace subsoil::sim {

/// A dataset that gets its rows piece by piece. Shuffled and deflated in chunks.
class GrowingArray {
 public:
  /// @param columns of a row; 1: the dataset is one-dimensional
  GrowingArray(hid_t parent, std::string name, hid_t type, hsize_t columns = 1);
  /// @param data rows x columns numbers of the dataset's type
  void append(const void* data, hsize_t rows);
  template <class T>
  void append(const std::vector<T>& values) {
    append(values.data(), values.size() / columns_);
  }
  hsize_t rows() const { return rows_; }
  hsize_t columns() const { return columns_; }

 private:
  std::string name_;
  h5::Handle type_, set_;
  hsize_t columns_, rows_ = 0;
};

}  // namespace subsoil::sim
