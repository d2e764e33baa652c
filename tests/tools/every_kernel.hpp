#pragma once
#include <stdexcept>
#include <vector>

#include "libdem/kernel/streams.hpp"

namespace subsoil::dem::test {

/// Of each instruction set that the build has and this machine can run; the portable one always.
inline std::vector<Kernel> every_kernel() {
  std::vector<Kernel> found{choose_kernel("portable")};
  for (const char* set : {"avx2", "avx512"}) try {
      found.push_back(choose_kernel(set));
    } catch (const std::invalid_argument&) {  // without it
    }
  return found;
}

}  // namespace subsoil::dem::test
