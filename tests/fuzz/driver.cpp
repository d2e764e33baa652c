// libFuzzer's entry; the target is the one that SUBSOIL_FUZZ_TARGET in the environment names.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/fuzz/targets.hpp"

namespace {

const subsoil::sim::fuzz::Target& asked_for() {
  const char* name = std::getenv("SUBSOIL_FUZZ_TARGET");
  for (const auto& target : subsoil::sim::fuzz::targets)
    if (name != nullptr && std::string_view(name) == target.name) return target;
  std::fputs("SUBSOIL_FUZZ_TARGET names no target of tests/fuzz/targets.hpp\n", stderr);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto& target = asked_for();
  target.run(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
