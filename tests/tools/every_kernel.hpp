#pragma once
#include <cstring>
#include <stdexcept>
#include <vector>

#include "libdem/contacts/blocks.hpp"

namespace subsoil::dem::test {

/// Of each instruction set that the build has and this machine can run: one at least.
inline std::vector<Kernel> every_kernel() {
  std::vector<Kernel> found;
  for (const char* set : {"portable", "avx2", "avx512"}) try {
      found.push_back(choose_kernel(set));
    } catch (const std::invalid_argument&) {  // without it
    }
  if (found.empty()) throw std::logic_error("this build has no kernel that this machine can run");
  return found;
}

/// Sums for spheres 0 to size - 1, which a kernel adds to in one of the precisions.
struct Sums {
  std::vector<Accumulator> doubles;
  std::vector<MixedAccumulator> singles;

  /// @param size power of two
  explicit Sums(std::size_t size) : doubles(size, Accumulator{}), singles(size, MixedAccumulator{}) {}
  Ring ring() { return {doubles.data(), singles.data(), static_cast<std::uint32_t>(doubles.size() - 1)}; }
  Accumulator of(std::size_t i, bool mixed) const {
    if (!mixed) return doubles[i];
    return {__builtin_convertvector(singles[i].f, Four), __builtin_convertvector(singles[i].t, Four)};
  }
  /// To both.
  void add(std::size_t i, const Four& f, const Four& t) {
    doubles[i].f += f, doubles[i].t += t;
    singles[i].f += __builtin_convertvector(f, FourFloats), singles[i].t += __builtin_convertvector(t, FourFloats);
  }
  /// Of the first `count`.
  bool same_bits(const Sums& other, bool mixed, std::size_t count) const {
    return mixed ? std::memcmp(singles.data(), other.singles.data(), count * sizeof(MixedAccumulator)) == 0
                 : std::memcmp(doubles.data(), other.doubles.data(), count * sizeof(Accumulator)) == 0;
  }
};

}  // namespace subsoil::dem::test
