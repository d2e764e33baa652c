#pragma once
#include <cstddef>
#include <memory>
#include <span>

namespace subsoil::dem {

/// An array whose new elements are not initialised: the threads that will work on them write them first, so pages are
/// touched in parallel and once. Nothing of an old content survives `renew`.
template <class T>
class Buffer {
 public:
  void renew(std::size_t size) {
    data_.reset();
    data_ = std::make_unique_for_overwrite<T[]>(size);
    size_ = size;
  }
  void clear() { data_.reset(), size_ = 0; }
  std::size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::span<const T> all() const { return {data_.get(), size_}; }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_ = 0;
};

}  // namespace subsoil::dem
