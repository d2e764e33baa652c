#include "libdem/geometry/surface_contact.hpp"

#include <algorithm>

namespace subsoil::dem {

void match_contacts(std::span<const SurfaceContact> now, std::span<const Vec3> previous_normals, int* from) {
  constexpr double least_cosine = 0.5;
  std::fill_n(from, now.size(), -1);
  // Contacts of one sphere with one body are a handful, so the quadratic search needs no memory of its own.
  const auto taken = [&](size_t j) {
    return std::find(from, from + now.size(), static_cast<int>(j)) != from + now.size();
  };
  for (;;) {
    double best = least_cosine;
    size_t best_now = now.size(), best_previous = 0;
    for (size_t i = 0; i < now.size(); ++i) {
      if (from[i] >= 0) continue;
      for (size_t j = 0; j < previous_normals.size(); ++j) {
        const double cosine = dot(now[i].normal, previous_normals[j]);
        if (cosine > best && !taken(j)) best = cosine, best_now = i, best_previous = j;
      }
    }
    if (best_now == now.size()) return;
    from[best_now] = static_cast<int>(best_previous);
  }
}

}  // namespace subsoil::dem
