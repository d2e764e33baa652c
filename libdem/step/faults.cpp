#include <algorithm>
#include <cmath>
#include <cstdio>

#include "libdem/step/bed_impl.hpp"

/// Whether the bed still makes sense after a step, and which sphere does not.
namespace subsoil::dem {

/// Place of the sphere with the deepest contact; after the move, which changes overlaps by a step's path.
std::uint32_t Bed::Impl::deepest_sphere() const {
  std::uint32_t deepest = 0;
  double largest = 0;
  const auto offer = [&](double share, std::uint32_t sphere) {
    if (exceeds(share, largest)) largest = share, deepest = sphere;
  };
  for (const SurfaceChunk& c : surfaces.chunks) offer(c.max_overlap, c.worst);
  for (const PairBlock& block : contacts.blocks.all())
    for (std::uint32_t l = 0; l < kBlock; ++l) {
      const Sphere &a = particles[block.i[l]], &b = particles[block.j[l]];
      offer((a.r + b.r - norm(a.x - b.x)) / std::min(a.r, b.r), block.i[l]);
    }
  for (const PlaneRun& run : surfaces.plane_runs)
    for (std::uint32_t k = 0; k < run.contacts; ++k) {
      const PlaneBlock& p = surfaces.plane_blocks[run.first + k / kBlock];
      const std::uint32_t l = k % kBlock;
      const Sphere& s = particles[p.sphere[l]];
      const Vec3 n{p.normal[0][l], p.normal[1][l], p.normal[2][l]};
      offer((s.r - dot(n, boundaries[run.boundary].pose.to_local(s.x)) + p.offset[l]) / s.r, p.sphere[l]);
    }
  return deepest;
}

/// A maximum passes over what is no number, a sum does not.
bool Bed::Impl::within_limits() const {
  const EnergyBalance::Extremes& e = balance.extremes();
  return e.speed2 <= options.speed_limit * options.speed_limit && std::isfinite(e.squares) &&
         e.overlap <= options.overlap_limit;
}

void Bed::Impl::check_faults() {
  char text[400];
  const EnergyBalance::Extremes& extremes = balance.extremes();
  // A maximum passes over what is no number, a sum does not.
  if (!(extremes.speed2 <= options.speed_limit * options.speed_limit) || !std::isfinite(extremes.squares)) {
    particles.sync_from_mixed(threads);
    std::size_t fastest = 0;
    double speed2 = 0;
    for (std::size_t i = 0; i < particles.size(); ++i)
      if (const double v2 = dot(particles[i].v, particles[i].v); exceeds(v2, speed2)) speed2 = v2, fastest = i;
    const Sphere& s = particles[fastest];
    const double speed = std::sqrt(speed2);
    std::snprintf(
        text, sizeof text,
        "sphere %u at (%.6g, %.6g, %.6g) m moves at %.6g m/s, limit %.6g m/s: the step is too long, a "
        "surface moves too fast, or spheres were placed into each other; raise limits.speed only if this speed "
        "is meant",
        s.id, s.x.x, s.x.y, s.x.z, speed, options.speed_limit);
    throw BedFault({BedFault::Kind::speed, now.time, s.id, speed, options.speed_limit}, text);
  }
  if (!(extremes.overlap <= options.overlap_limit)) {
    particles.sync_from_mixed(threads);
    const Sphere& s = particles[deepest_sphere()];
    std::snprintf(text, sizeof text,
                  "sphere %u at (%.6g, %.6g, %.6g) m overlaps by %.4g of a radius, limit %.4g: the law is too "
                  "soft for this load, or spheres or surfaces were placed into each other",
                  s.id, s.x.x, s.x.y, s.x.z, extremes.overlap, options.overlap_limit);
    throw BedFault({BedFault::Kind::overlap, now.time, s.id, extremes.overlap, options.overlap_limit}, text);
  }
}

}  // namespace subsoil::dem
