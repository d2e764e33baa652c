#include "libdem/step/bed_impl.hpp"

/// The two records of a sphere in mixed precision: what the steps work on, and what everybody else sees.
namespace subsoil::dem {
namespace {

void copy_motion(const MixedSphere& from, Sphere& to) {
  to.x = from.x;
  for (int d = 0; d < 3; ++d) to.v[d] = static_cast<double>(from.v[d]), to.w[d] = static_cast<double>(from.w[d]);
}

}  // namespace

void Bed::Impl::sync_to_mixed() {
  if (!is_mixed()) return;
  mixed.resize(spheres.size());
  const auto count = static_cast<long>(spheres.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    mixed[i] = rounded(spheres[i]);
  }
}

void Bed::Impl::sync_from_mixed() {
  if (!spheres_behind) return;
  spheres_behind = false;
  const auto count = static_cast<long>(spheres.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long i = 0; i < count; ++i)
    copy_motion(mixed[static_cast<std::size_t>(i)], spheres[static_cast<std::size_t>(i)]);
}

Sphere Bed::Impl::sphere(std::uint32_t i) const {
  Sphere s = spheres[i];
  if (spheres_behind) copy_motion(mixed[i], s);
  return s;
}

}  // namespace subsoil::dem
