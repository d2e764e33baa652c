#include "libsim/setup/bed_profile.hpp"

#include <algorithm>
#include <cmath>

#include "libsim/base/coarse_graining.hpp"
#include "libsim/base/periodic_images.hpp"

namespace subsoil::sim {
namespace {

/// Centres of rigid grains by the id of their spheres: a clump transmits force as one body.
class GrainCentres {
 public:
  explicit GrainCentres(const dem::Bed& bed) : cell_(bed.options().periodic) {
    for (const dem::Sphere& s : bed.spheres()) {
      if (s.id >= centre_.size()) centre_.resize(s.id + 1);
      const long clump = bed.clump_of(s);
      centre_[s.id] = clump < 0 ? s.x : bed.clumps()[static_cast<std::size_t>(clump)].position;
    }
  }
  /// The image nearest to a point.
  Vec3 near(std::uint32_t id, const Vec3& point) const { return point + cell_.shortest(centre_[id] - point); }

 private:
  const dem::PeriodicCell& cell_;
  std::vector<Vec3> centre_;
};

struct Line {
  double low = 0, spacing = 0;
  std::size_t n = 1;
};
/// Points over a period, each of which stands for as much of it.
Line over_period(double low, double length, double spacing) {
  const double n = std::max(1.0, std::round(length / spacing));
  return {low + 0.5 * length / n, length / n, static_cast<std::size_t>(n)};
}
/// Points between two sides, this far from them and so far apart; one in the middle where there is no room.
Line between(double low, double high, double margin, double spacing) {
  const double room = high - low - 2 * margin;
  if (room <= 0) return {0.5 * (low + high), spacing, 1};
  const auto gaps = std::max(1.0, std::floor(room / spacing));
  return {low + margin, room / gaps, static_cast<std::size_t>(gaps) + 1};
}

}  // namespace

std::vector<DepthRow> profile_by_depth(dem::Bed& bed, const dem::Bounds& region, std::uint32_t below) {
  const std::vector<dem::Sphere> spheres = dem::spheres_below(bed.spheres(), below);
  const double diameter = 2 * dem::mean_radius(spheres);
  const double surface = dem::surface_height(spheres, region).mean;
  if (!(diameter > 0) || !(surface > region.low.y)) return {};
  const FieldKernel kernel(FieldKernel::Kind::lucy, diameter);
  // A kernel is four diameters wide: points a diameter apart see all between them alike, farther ones only what is
  // near.
  constexpr double most_rows = 12, most_points = 24;
  const double reach = kernel.reach();
  const dem::PeriodicCell& cell = bed.options().periodic;
  const auto across = [&](int d) {
    if (cell.length[d] > 0)
      return over_period(cell.low[d], cell.length[d], std::max(diameter, cell.length[d] / most_points));
    const double low = region.low[d], high = region.high[d];
    return between(low, high, reach, std::max(diameter, (high - low) / most_points));
  };
  const Line x = across(0), z = across(2);
  const Line y = between(region.low.y, surface, reach, std::max(2 * diameter, (surface - region.low.y) / most_rows));
  const FieldGrid grid{
      .low = {x.low, y.low, z.low}, .spacing = {x.spacing, y.spacing, z.spacing}, .n = {x.n, y.n, z.n}};

  CoarseGraining fields(grid, kernel);
  const GrainCentres centres(bed);
  const auto add_contact = [&](std::uint32_t grain, const Vec3& point, const Vec3& force) {
    const Vec3 centre = centres.near(grain, point);
    Vec3 low = centre, high = centre;
    for (int d = 0; d < 3; ++d) low[d] = std::min(low[d], point[d]), high[d] = std::max(high[d], point[d]);
    each_image(low, high, cell, reach,
               [&](const Vec3& shift) { fields.add_contact(centre + shift, point + shift, force); });
  };
  std::vector<double> contacts;
  for (const dem::ContactRecord& c : bed.contacts()) {
    add_contact(c.i, c.point, c.force);
    if (c.at_surface) continue;
    add_contact(c.j, c.point, -c.force);
    for (const std::uint32_t id : {c.i, c.j}) {
      if (id >= contacts.size()) contacts.resize(id + 1);
      ++contacts[id];
    }
  }
  for (const dem::Sphere& s : spheres) {
    const Vec3 at = cell.wrapped(s.x);
    each_image(at, at, cell, reach, [&](const Vec3& shift) {
      fields.add({.position = at + shift,
                  .velocity = {},
                  .mass = s.m,
                  .volume = bed.volume_of(s),
                  .contacts = s.id < contacts.size() ? contacts[s.id] : 0});
    });
  }
  const GrainFields f = fields.finish();

  std::vector<DepthRow> out;
  for (std::size_t j = y.n; j-- > 0;) {
    DepthRow row{.depth = surface - (y.low + y.spacing * static_cast<double>(j))};
    double horizontal = 0, filled = 0;
    for (std::size_t k = 0; k < z.n; ++k)
      for (std::size_t i = 0; i < x.n; ++i) {
        const std::size_t at = i + x.n * (j + y.n * k);
        if (!(f.density[at] > 0)) continue;
        ++filled;
        row.density += f.density[at], row.coordination += f.coordination[at];
        const Tensor& stress = f.contact_stress[at];
        row.vertical_stress += stress[4], horizontal += 0.5 * (stress[0] + stress[8]);
      }
    if (filled == 0) continue;
    if (row.vertical_stress > 0) row.stress_ratio = horizontal / row.vertical_stress;
    row.density /= static_cast<double>(x.n * z.n);
    row.coordination /= filled, row.vertical_stress /= static_cast<double>(x.n * z.n);
    out.push_back(row);
  }
  return out;
}

}  // namespace subsoil::sim
