#pragma once
#include <span>
#include <stdexcept>
#include <vector>

#include "libdem/base/vec3.hpp"

/// Numbers of a saved state: written one after the other, read in the same order.
namespace subsoil::dem {

inline void put(std::vector<double>& out, const Vec3& v) { out.insert(out.end(), {v.x, v.y, v.z}); }

/// Reads what put() and insert() wrote; throws where the state ends too early.
struct StateReader {
  std::span<const double> from;
  std::size_t at = 0;

  double operator()() {
    if (at == from.size()) throw std::invalid_argument("restart: the state ends too early; the file is damaged");
    return from[at++];
  }
  Vec3 vector() {
    const double x = (*this)(), y = (*this)(), z = (*this)();
    return {x, y, z};
  }
  std::span<const double> rest() const { return from.subspan(at); }
};

}  // namespace subsoil::dem
