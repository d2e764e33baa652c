#include "libdem/particles/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "libdem/base/fault.hpp"
#include "libdem/particles/particle_store.hpp"

namespace subsoil::dem {
namespace {

struct Count {
  Bounds box;
  double smallest = std::numeric_limits<double>::infinity(), largest = 0, sum = 0;
  std::vector<char> present;
  bool all_free = true;
  std::uint32_t not_finite = kGone;  ///< first of these
};

Count count_part(std::span<const Sphere> part, std::uint32_t first, int materials) {
  Count c;
  c.present.assign(static_cast<std::size_t>(materials), 0);
  for (std::size_t i = 0; i < part.size(); ++i) {
    const Sphere& s = part[i];
    if (!(std::isfinite(s.x.x) && std::isfinite(s.x.y) && std::isfinite(s.x.z)))
      c.not_finite = std::min(c.not_finite, first + static_cast<std::uint32_t>(i));
    c.box.include(s.x);
    c.smallest = std::min(c.smallest, s.r), c.largest = std::max(c.largest, s.r), c.sum += s.r;
    c.all_free = c.all_free && s.kind == SphereKind::free;
    char& present = c.present[s.material];
    present = present == 0 ? 1 : 2;
  }
  return c;
}

}  // namespace

ParticleStatistics particle_statistics(std::span<const Sphere> spheres, int materials, int threads, double time) {
  constexpr std::size_t part = 4096;  // fixed, and not by thread: the sum of radii is rounded in its order
  std::vector<Count> counts((spheres.size() + part - 1) / part);
  const auto parts = static_cast<long>(counts.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long k = 0; k < parts; ++k) {
    const std::size_t first = part * static_cast<std::size_t>(k);
    counts[static_cast<std::size_t>(k)] = count_part(spheres.subspan(first, std::min(part, spheres.size() - first)),
                                                     static_cast<std::uint32_t>(first), materials);
  }
  ParticleStatistics out;
  out.present.assign(static_cast<std::size_t>(materials), 0);
  double smallest = std::numeric_limits<double>::infinity(), sum = 0;
  for (const Count& c : counts) {
    if (c.not_finite != kGone)
      throw BedFault({BedFault::Kind::position, time, spheres[c.not_finite].id},
                     "sphere " + std::to_string(spheres[c.not_finite].id) + ": position is not finite");
    out.box.include(c.box.low), out.box.include(c.box.high);
    smallest = std::min(smallest, c.smallest), out.largest = std::max(out.largest, c.largest), sum += c.sum;
    out.all_free = out.all_free && c.all_free;
    for (std::size_t m = 0; m < out.present.size(); ++m) {
      const int both = out.present[m] + c.present[m];
      out.present[m] = static_cast<char>(std::min(both, 2));
    }
  }
  if (spheres.empty()) return out;
  out.smallest = smallest, out.mean = sum / static_cast<double>(spheres.size());
  return out;
}

}  // namespace subsoil::dem
