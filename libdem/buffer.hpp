#pragma once
#include <cstddef>
#include <memory>
#include <span>

namespace subsoil::dem {

/// An array whose new elements are not initialised: the threads that will work on them write them first, so pages are
/// touched in parallel and once. Nothing of an old content survives `renew`, only its storage where that is long
/// enough: the system takes longer to hand out pages than a rebuild to fill them. (Pages of 2 MB changed nothing.)
template <class T>
class Buffer {
 public:
  void renew(std::size_t size) {
    size_ = size;
    if (size <= capacity_) return;
    data_.reset();
    const std::size_t room = size + capacity_ / 16;  // lists of a moving bed are now longer, now shorter
    capacity_ = 0;
    data_ = std::make_unique_for_overwrite<T[]>(room);
    capacity_ = room;
  }
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::span<const T> all() const { return {data_.get(), size_}; }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace subsoil::dem
