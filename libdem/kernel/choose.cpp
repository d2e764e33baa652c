#include <stdexcept>
#include <string>

#include "libdem/kernel/streams.hpp"

namespace subsoil::dem {

namespace portable {
Kernel kernel();
}
#if defined(__x86_64__)
namespace avx2 {
Kernel kernel();
}
namespace avx512 {
Kernel kernel();
}
#endif

Kernel choose_kernel(const char* name) {
  const std::string want = name;
  if (want == "portable") return portable::kernel();
#if defined(__x86_64__)
  const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool has_avx512 = has_avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("avx512vl");
  if (want == "auto") return has_avx512 ? avx512::kernel() : has_avx2 ? avx2::kernel() : portable::kernel();
  if (want == "avx512" && has_avx512) return avx512::kernel();
  if (want == "avx2" && has_avx2) return avx2::kernel();
#else
  if (want == "auto") return portable::kernel();
#endif
  throw std::invalid_argument("simd '" + want + "': this machine has no such instruction set; use auto or portable");
}

}  // namespace subsoil::dem
