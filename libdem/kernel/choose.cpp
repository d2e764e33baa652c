#include <stdexcept>
#include <string>

#include "libdem/contacts/blocks.hpp"

/// Sets that the build has (SUBSOIL_HAS_..., libdem/CMakeLists.txt) and this machine too.
namespace subsoil::dem {

namespace portable {
Kernel kernel();
}
namespace avx2 {
Kernel kernel();
}
namespace avx512 {
Kernel kernel();
}

namespace {

using Make = Kernel (*)();

Make portable_here() {
#if defined(SUBSOIL_HAS_portable)
  return portable::kernel;
#endif
  return nullptr;
}

Make avx2_here() {
#if defined(SUBSOIL_HAS_avx2)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2::kernel;
#endif
  return nullptr;
}

Make avx512_here() {
#if defined(SUBSOIL_HAS_avx512)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return avx512::kernel;
#endif
  return nullptr;
}

}  // namespace

Kernel choose_kernel(const char* name) {
  const std::string want = name;
  const Make any = portable_here(), narrow = avx2_here(), wide = avx512_here();
  if (want == "auto" && (wide != nullptr || narrow != nullptr || any != nullptr))
    return wide != nullptr ? wide() : narrow != nullptr ? narrow() : any();
  if (want == "avx512" && wide != nullptr) return wide();
  if (want == "avx2" && narrow != nullptr) return narrow();
  if (want == "portable" && any != nullptr) return any();
  if (want == "auto")
    throw std::invalid_argument(
        "simd 'auto': this build has kernels of another machine's instruction set only; build it with "
        "-DSUBSOIL_SIMD=native on this one");
  if (want != "avx512" && want != "avx2" && want != "portable")
    throw std::invalid_argument("simd '" + want + "': must be auto, portable, avx2 or avx512");
  throw std::invalid_argument("simd '" + want + "': this machine or this build has no such instruction set; use auto" +
                              (any != nullptr ? " or portable" : ", or build with -DSUBSOIL_SIMD=native"));
}

}  // namespace subsoil::dem
