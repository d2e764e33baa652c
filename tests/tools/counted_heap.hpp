#pragma once
#include <atomic>
#include <cstdlib>

/// Counts every way to the heap, Eigen's (malloc) and the library's (new), of the test program that includes this in
/// one file; where a sanitizer has the heap for itself SUBSOIL_COUNTS_HEAP is not defined.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define SUBSOIL_COUNTS_HEAP

namespace subsoil::test {
/// Of all threads; atomic also since the compiler takes malloc for a function that changes no variable.
inline std::atomic<long> allocations{0};
}  // namespace subsoil::test

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) noexcept {
  ++subsoil::test::allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++subsoil::test::allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) noexcept {
  ++subsoil::test::allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++subsoil::test::allocations;
  return __libc_memalign(alignment, size);
}
}

#endif
