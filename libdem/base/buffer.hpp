#pragma once
#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>

#include "libdem/base/large_pages.hpp"

namespace subsoil::dem {

/// An array whose new elements are not initialised: the threads that will work on them write them first, so pages are
/// touched in parallel and once. Nothing of an old content survives `renew`, only its storage where that is long
/// enough: the system takes longer to hand out pages than a rebuild to fill them. For elements that need no constructor
/// and no destructor.
template <class T>
class Buffer {
 public:
  void renew(std::size_t size) {
    size_ = size;
    if (size <= capacity()) return;
    const std::size_t room = size + capacity() / 16;  // lists of a moving bed are now longer, now shorter
    data_ = nullptr;
    data_ = {LargePages<T>().allocate(room), Free{room}};
  }
  void copy(const Buffer& from) {
    renew(from.size_);
    std::copy_n(from.data(), size_, data());
  }
  void shorten(std::size_t size) { size_ = size; }  ///< the first elements stay
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::span<const T> all() const { return {data_.get(), size_}; }

 private:
  struct Free {
    std::size_t count = 0;
    void operator()(T* data) const { LargePages<T>().deallocate(data, count); }
  };
  std::size_t capacity() const { return data_ == nullptr ? 0 : data_.get_deleter().count; }

  std::unique_ptr<T[], Free> data_;
  std::size_t size_ = 0;
};

}  // namespace subsoil::dem
