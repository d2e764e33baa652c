#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "libdem/base/fault.hpp"
#include "libdem/geometry/world_box.hpp"
#include "libdem/neighbours/periodic_search.hpp"
#include "libdem/step/bed_impl.hpp"

/// What a rebuild does about periodic sides: spheres go to where they came round to, and the pairs across the sides get
/// images of their second particles. In between, spheres may be outside of the cell by the skin and nothing is special
/// but that images are renewed before each step. Such pairs lie in the runs across block interfaces: what an image gets
/// waits for its sphere as a remote contribution does, in an order that the lists fix.
///
/// A shift beside each pair, in place of records of images, lost: kernels would read it for every pair of every bed.
namespace subsoil::dem {
namespace {

/// Whether a surface that spans the bed is the same one period on: of a plane this is known.
bool is_invariant(const Boundary& b, int axis) {
  const auto* plane = std::get_if<Plane>(&b.shape);
  return plane == nullptr || std::abs(b.pose.attitude.rotate(plane->normal())[axis]) < 1e-12;
}

/// Whether spheres of the bed come near to a box, periodic directions left out.
bool is_beside(const Bounds& box, const Bounds& bed, const PeriodicCell& cell, double near) {
  for (int d = 0; d < 3; ++d)
    if (cell.length[d] == 0 && (box.low[d] > bed.high[d] + near || box.high[d] < bed.low[d] - near)) return false;
  return true;
}

}  // namespace

/// Of gravity's potential what a sphere has more on the other side is accounted for where energy leaves the bed.
void Bed::Impl::wrap() {
  for (Sphere& s : particles.spheres()) {
    const Vec3 was = s.x;
    s.x = options.periodic.wrapped(was);
    if (clumps.clump_of(s.id) != kGone)
      balance.removed += clumps.go_round(s, options.periodic.periods(s.x - was), options.gravity);
    else if (!is_fixed(s))
      balance.removed += s.m * dot(options.gravity, s.x - was);
  }
}

void Bed::Impl::add_images(NeighbourList& list, const Grid& grid, const ParticleStatistics& statistics, double cutoff) {
  particles.set_images(
      add_pairs_across(particles.spheres(), grid, statistics.box, options.periodic, statistics.largest, cutoff, list));
}

/// Throws where a sphere could meet another one, or a surface, from both sides.
void Bed::Impl::check_periodic_sides(const ParticleStatistics& statistics, double skin) const {
  const PeriodicCell& cell = options.periodic;
  if (particles.empty()) return;  // nothing meets, and the skin of no spheres has no size
  const double reach = 2 * statistics.largest + laws.largest_cutoff() + skin;
  require_period(cell, reach);
  if (clumps.any()) require_period_of_clumps(cell, clumps.widest_gap() + reach);
  double cutoff = 0;
  for (std::uint32_t law = 0; law < laws.count(); ++law) cutoff = std::max(cutoff, laws.surface_cutoff(law));
  const double near = statistics.largest + cutoff + skin;
  for (const Boundary& b : boundaries) {
    const Bounds box = world_box(bounds(b.shape), b.pose);
    if (!b.active || !is_beside(box, statistics.box, cell, near)) continue;
    for (int d = 0; d < 3; ++d) {
      const double low = cell.low[d], high = low + cell.length[d];
      if (cell.length[d] == 0) continue;
      const bool spans = box.low[d] <= low - near && box.high[d] >= high + near;
      const bool clear = box.low[d] >= low + near && box.high[d] <= high - near;
      if ((spans || clear) && is_invariant(b, d)) continue;
      char text[400];
      std::snprintf(text, sizeof text,
                    "the surface '%s' comes nearer than %.4g m to a periodic side of the bed in %c (it "
                    "reaches from %.6g to %.6g m, the bed from %.6g to %.6g m): surfaces have no image beyond it; keep "
                    "it away from both sides, or let it span the bed and reach that far beyond both",
                    b.name.c_str(), near, "xyz"[d], box.low[d], box.high[d], low, high);
      const double gap = std::max(0.0, std::min(std::abs(box.low[d] - low), std::abs(high - box.high[d])));
      throw BedFault({BedFault::Kind::periodic_side, now.time, BedFault::no_sphere, gap, near}, text);
    }
  }
}

}  // namespace subsoil::dem
