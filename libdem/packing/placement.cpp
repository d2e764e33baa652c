#include "libdem/packing/placement.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace subsoil::dem {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("bed: " + what); }

std::string mm(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g mm", length * 1e3);
  return text;
}

void require_room(const Bounds& region, double radius) {
  const Vec3 size = region.high - region.low;
  for (int d = 0; d < 3; ++d)
    if (!(size[d] >= 2 * radius * (1 - 1e-9)))
      refuse("the region is " + mm(size[d]) + " long in " + "xyz"[d] + ", less than the diameter " + mm(2 * radius) +
             " of its spheres; enlarge the region or choose smaller spheres");
}

/// Rows of spheres of this radius that stand in a length. Lengths are decimal numbers that binary ones miss by 1e-16:
/// 1.98/0.018 is 110 rows apart, so a row that lacks a billionth of a pitch still counts.
std::size_t rows(double length, double radius, double pitch) {
  const double between = (length - 2 * radius) / pitch + 1e-9;
  return between < 0 ? 0 : 1 + static_cast<std::size_t>(std::floor(between));
}

/// Rows in a period: they must continue beyond the side as if it were not there.
std::size_t rows_around(double length, double pitch, char axis) {
  const double number = length / pitch, whole = std::max(1.0, std::round(number));
  if (std::abs(number - whole) > 1e-6 * whole)
    refuse("the period of " + mm(length) + " in " + axis + " is no whole number of pitches of " + mm(pitch) +
           "; make it " + mm(std::max(1.0, std::floor(number)) * pitch) + " or " +
           mm((std::floor(number) + 1) * pitch) + ", give another pitch, or fill at random");
  return static_cast<std::size_t>(whole);
}

}  // namespace

const ClumpPart* draw_part(const std::vector<ClumpPart>& clumps, RandomNumbers& random) {
  if (clumps.empty()) return nullptr;
  double left = random.uniform();
  for (const ClumpPart& part : clumps) {
    if (left < part.share) return &part;
    left -= part.share;
  }
  // Shares that sum to 1 but for rounding leave no room for a sphere.
  return left < 1e-9 ? &clumps.back() : nullptr;
}

Quaternion any_attitude(RandomNumbers& random) {
  const double u = random.uniform(), a = 2 * M_PI * random.uniform(), b = 2 * M_PI * random.uniform();
  const double p = std::sqrt(1 - u), q = std::sqrt(u);
  return {p * std::sin(a), p * std::cos(a), q * std::sin(b), q * std::cos(b)};
}

double largest_reach(const RadiusDistribution& sizes, const std::vector<ClumpPart>& clumps) {
  double largest = 0, share = 0;
  for (const ClumpPart& part : clumps) largest = std::max(largest, part.reach), share += part.share;
  return share < 1 - 1e-9 ? std::max(largest, largest_radius(sizes)) : largest;
}

ClumpPart clump_part(const Bed& bed, int shape, double share) {
  const ClumpShape& s = bed.clump_shapes().at(static_cast<std::size_t>(shape));
  return {shape, share, s.reach, s.volume};
}

void add(Bed& bed, const Grains& grains) {
  bed.add(grains.spheres);
  bed.add(grains.clumps);
}

LatticeCount lattice_count(const LatticePlan& plan) {
  const double r = largest_reach(plan.radius, plan.clumps);
  require_room(plan.region, r);
  if (!(plan.pitch > 0)) refuse("the pitch of a lattice must be positive, not " + mm(plan.pitch));
  const Vec3 size = plan.region.high - plan.region.low;
  const double height = plan.depth > 0 ? std::min(plan.depth, size.y) : size.y;
  const auto along = [&](int d, double length) {
    const bool around = plan.periodic[static_cast<std::size_t>(d)];
    return around ? rows_around(length, plan.pitch, "xyz"[d]) : rows(length, r, plan.pitch);
  };
  return {along(0, size.x), along(1, height), along(2, size.z)};
}

std::vector<SphereSpec> lattice(const LatticePlan& plan, const BedMaterial& of) {
  return lattice_of_grains(plan, of).spheres;
}

Grains lattice_of_grains(const LatticePlan& plan, const BedMaterial& of) {
  const RadiusSampler sampler(plan.radius, plan.shares);
  const LatticeCount n = lattice_count(plan);
  if (n.total() == 0) refuse("a depth of " + mm(plan.depth) + " holds no layer of spheres; the least is one diameter");
  if (!(plan.jitter >= 0)) refuse("the jitter must not be negative");
  const double r_largest = largest_reach(plan.radius, plan.clumps);
  const auto first = [&](double low, double high, std::size_t count) {
    return 0.5 * (low + high) - 0.5 * static_cast<double>(count - 1) * plan.pitch;
  };
  const Bounds& box = plan.region;
  Vec3 start{first(box.low.x, box.high.x, n.x), box.low.y + r_largest - plan.floor_overlap,
             first(box.low.z, box.high.z, n.z)};
  if (plan.periodic[1]) start.y = first(box.low.y, box.high.y, n.y);
  RandomNumbers random(plan.seed);
  Grains out;
  out.spheres.reserve(plan.clumps.empty() ? n.total() : 0);
  for (std::size_t j = 0; j < n.y; ++j)
    for (std::size_t i = 0; i < n.x; ++i)
      for (std::size_t k = 0; k < n.z; ++k) {
        const ClumpPart* const part = draw_part(plan.clumps, random);
        SphereSpec s;
        s.radius = part != nullptr ? part->reach : sampler.draw(random);
        s.density = of.density;
        s.material = of.material;
        s.position = start + plan.pitch * Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        if (plan.jitter > 0) {
          s.position += (plan.jitter * s.radius) * random.in_unit_ball();
          // A shift must not press a sphere into a wall deeper than the lowest layer lies in the floor.
          const double near = s.radius - plan.floor_overlap;
          if (!plan.periodic[1]) s.position.y = std::max(s.position.y, box.low.y + near);
          if (!plan.periodic[0]) s.position.x = std::clamp(s.position.x, box.low.x + near, box.high.x - near);
          if (!plan.periodic[2]) s.position.z = std::clamp(s.position.z, box.low.z + near, box.high.z - near);
        }
        if (part == nullptr)
          out.spheres.push_back(s);
        else
          out.clumps.push_back({part->shape, s.position, any_attitude(random), {}, {}, of.material});
      }
  return out;
}

std::vector<SphereSpec> rest_lattice(LatticePlan plan, double rest_overlap, const BedMaterial& of) {
  const auto* equal = std::get_if<EqualRadius>(&plan.radius);
  if (equal == nullptr)
    refuse("a rest lattice needs spheres of one radius; give one radius, or fill by lattice or random");
  if (!(plan.pitch > 0)) plan.pitch = 2 * equal->radius - rest_overlap;
  return lattice(plan, of);
}

LoosePlacer::LoosePlacer(const Bounds& region, RadiusDistribution sizes, ShareOf shares, std::uint64_t seed,
                         const BedMaterial& of, std::vector<ClumpPart> clumps)
    : region_(region), sampler_(sizes, shares), random_(seed), of_(of), clumps_(std::move(clumps)) {
  const double r = largest_reach(sizes, clumps_);
  const Vec3 size = region.high - region.low;
  require_room({region.low, {region.high.x, region.low.y + 2 * r, region.high.z}}, r);
  const double side = 2.1 * r;  // closer lost: rows that start in contact line up and stay a lattice
  across_x_ = std::max<std::size_t>(1, static_cast<std::size_t>(size.x / side));
  across_z_ = std::max<std::size_t>(1, static_cast<std::size_t>(size.z / side));
  cell_ = {size.x / static_cast<double>(across_x_), side, size.z / static_cast<double>(across_z_)};
}

Vec3 LoosePlacer::place_in(std::size_t cell, double from_height, double radius) {
  const std::size_t in_layer = cell % (across_x_ * across_z_);
  const Vec3 corner{region_.low.x + cell_.x * static_cast<double>(in_layer / across_z_),
                    from_height + cell_.y * static_cast<double>(cell / (across_x_ * across_z_)),
                    region_.low.z + cell_.z * static_cast<double>(in_layer % across_z_)};
  Vec3 position;
  for (int d = 0; d < 3; ++d) {
    const double room = std::max(0.0, cell_[d] - 2 * radius);
    position[d] = corner[d] + 0.5 * (cell_[d] - room) + room * random_.uniform();
  }
  return position;
}

double LoosePlacer::add_next(Grains& to, double from_height) {
  const std::size_t cell = to.count();
  if (const ClumpPart* const part = draw_part(clumps_, random_); part != nullptr) {
    const Vec3 position = place_in(cell, from_height, part->reach);
    to.clumps.push_back({part->shape, position, any_attitude(random_), {}, {}, of_.material});
    return part->volume;
  }
  SphereSpec s;
  s.radius = sampler_.draw(random_);
  s.density = of_.density;
  s.material = of_.material;
  s.position = place_in(cell, from_height, s.radius);
  to.spheres.push_back(s);
  return sphere_volume(s.radius);
}

Grains LoosePlacer::grains(std::size_t count, double from_height) {
  Grains out;
  if (clumps_.empty()) out.spheres.reserve(count);
  while (out.count() < count) add_next(out, from_height);
  return out;
}

Grains LoosePlacer::grains_of_volume(double volume, double from_height) {
  Grains out;
  while (volume > 0) volume -= add_next(out, from_height);
  return out;
}

}  // namespace subsoil::dem
