// libFuzzer's entry; scripts/fuzz compiles it once for each target of targets.hpp.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  subsoil::app::fuzz::SUBSOIL_FUZZ_TARGET(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
