#include "libsim/setup/fibres.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libdem/particles/fixed.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/moving_soil.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

dem::FibreField::Orientation orientation_of(const FibreSection& f) {
  using Orientation = dem::FibreField::Orientation;
  switch (f.orientation) {
    case FibreOrientation::random:
      return Orientation::random;
    case FibreOrientation::horizontal:
      return Orientation::horizontal;
    default:
      return Orientation::along;
  }
}

Vec3 axis_of(const FibreSection& f) {
  if (f.orientation == FibreOrientation::y) return {0, 1, 0};
  if (f.orientation == FibreOrientation::z) return {0, 0, 1};
  return {1, 0, 0};
}

/// The container's periods along x and z that the fibres' region spans: there they may lie across the sides.
dem::PeriodicCell periods_spanned(const FibreSection& f, const Container& c) {
  dem::PeriodicCell cell = periodic_cell(c);
  cell.length.y = 0;
  for (const int d : {0, 2})
    if (f.region && (f.region->at[d] > cell.low[d] || f.region->size[d] < cell.length[d])) cell.length[d] = 0;
  return cell;
}

/// Distance of a point from the axis of a fibre, m.
double distance(const Vec3& x, const dem::FibrePose& pose, const dem::FibreShape& shape) {
  const Vec3 from = x - pose.centre;
  const double half = 0.5 * (shape.chain_length() - shape.diameter);
  return dem::norm(from - std::clamp(dem::dot(from, pose.direction), -half, half) * pose.direction);
}

}  // namespace

std::vector<FibreGroup> fibre_groups(const Scenario& s) {
  std::vector<FibreGroup> out;
  if (!s.soil || !s.soil->bed) return out;
  for (const FibreSection& f : s.soil->bed->fibres) {
    const int material = material_index(s, f.material);
    const double density = s.materials[static_cast<std::size_t>(material)].density;
    out.push_back({f.name, {f.length, f.diameter, {density, material}}, count_of(f, s)});
  }
  return out;
}

std::vector<FibreGroup> groups_without_fibres(const Scenario& s) {
  std::vector<FibreGroup> out = fibre_groups(s);
  for (FibreGroup& group : out) group.count = 0, group.first = dem::kAllSpheres;
  return out;
}

bool is_of_fibres_only(const Scenario& s, int material) {
  if (!s.soil || !s.soil->bed || s.soil->bed->fill == Fill::file) return false;
  const BedSection& bed = *s.soil->bed;
  const std::string& name = s.materials[static_cast<std::size_t>(material)].name;
  const auto of = [&](const auto& one) { return one.material == name; };
  const auto any = [&](const auto& list) { return std::any_of(list.begin(), list.end(), of); };
  return any(bed.fibres) && bed.material != name && !any(bed.layers) && !any(bed.particles) && !any(bed.placed) &&
         !any(s.soil->inlets);
}

dem::StepQuestion question_between(const Scenario& s, const dem::StepQuestion& soil, int a, int b) {
  dem::StepQuestion q = soil;
  if (is_of_fibres_only(s, a) && is_of_fibres_only(s, b))
    q.smallest_radius = q.density = std::numeric_limits<double>::infinity(), q.largest_radius = 0;
  for (const FibreGroup& group : fibre_groups(s)) {
    const dem::FibreShape& shape = group.shape;
    if (shape.of.material != a && shape.of.material != b) continue;
    const double radius = 0.5 * shape.diameter;
    q.smallest_radius = std::min(q.smallest_radius, radius);
    q.largest_radius = std::max(q.largest_radius, radius);
    q.density = std::min(q.density, shape.mass() / shape.spheres() / dem::sphere_volume(radius));
  }
  return q;
}

void number_fibres(World& world) {
  std::uint32_t next = world.soil.fibres_from;
  const std::size_t period = world.moving ? world.moving->window.block().size() : 0;
  for (FibreGroup& group : world.fibres)
    group.first = next, next = group.end(), group.period = static_cast<std::uint32_t>(period);
}

bool is_of_fibres(const World& world, std::uint32_t id) {
  return std::any_of(world.fibres.begin(), world.fibres.end(), [&](const FibreGroup& g) { return g.has(id); });
}

std::int32_t fibre_of(const std::vector<FibreGroup>& groups, std::uint32_t id) {
  std::size_t before = 0;
  for (const FibreGroup& group : groups) {
    if (group.has(id)) return static_cast<std::int32_t>(before + group.fibre_of(id));
    before += group.count;
  }
  return -1;
}

dem::BedCover::Laid FibreCover::lay(dem::Bed& bed, const std::uint32_t first) {
  const std::vector<FibreSection>& sections = loaded_.scenario.soil->bed->fibres;
  const auto& container = loaded_.scenario.soil->container;
  const double surface = dem::highest_top(bed.spheres(), container ? container->at.y : 0);
  std::vector<dem::PlacedFibre> taken;
  Laid laid{.first = first};
  std::uint32_t next = first;
  const std::vector<FibreGroup> groups = fibre_groups(loaded_.scenario);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const FibreGroup& group = groups[k];
    const std::vector<dem::FibrePose> poses = place_group(group, k, taken, surface);
    try {
      if (sections[k].region) laid.left_out += make_room(bed, group.shape, poses);
      bed.insert(dem::fibres_at(group.shape, poses, next));
      next += static_cast<std::uint32_t>(poses.size()) * group.per_fibre();
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded_.where("soil.bed.fibres." + group.name) + ": " + error.what());
    }
  }
  laid.height = dem::highest_top(bed.spheres(), surface);
  return laid;
}

void FibreCover::laid(const Laid& what) {
  world_.soil.fibres_from = what.first, world_.soil.displaced = what.left_out;
  world_.fibres = fibre_groups(loaded_.scenario);
  number_fibres(world_);
  raise_(what.height);
}

void FibreCover::refuse_without_room() const {
  const auto& container = loaded_.scenario.soil->container;
  std::vector<dem::PlacedFibre> taken;
  const std::vector<FibreGroup> groups = fibre_groups(loaded_.scenario);
  for (std::size_t k = 0; k < groups.size(); ++k) place_group(groups[k], k, taken, container ? container->at.y : 0);
}

std::vector<dem::FibrePose> FibreCover::place_group(const FibreGroup& group, std::size_t index,
                                                    std::vector<dem::PlacedFibre>& taken, double top) const {
  try {
    std::vector<dem::FibrePose> poses = place(loaded_.scenario.soil->bed->fibres[index], group, index, taken, top);
    for (const dem::FibrePose& pose : poses) taken.push_back({group.shape, pose});
    return poses;
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(loaded_.where("soil.bed.fibres." + group.name) + ": " + error.what());
  }
}

std::vector<dem::FibrePose> FibreCover::place(const FibreSection& f, const FibreGroup& group, std::size_t index,
                                              const std::vector<dem::PlacedFibre>& taken, double top) const {
  const Soil& soil = *loaded_.scenario.soil;
  dem::FibreField field;
  field.shape = group.shape, field.count = group.count;
  field.orientation = orientation_of(f), field.axis = axis_of(f), field.scatter = f.scatter;
  // Groups alike are laid differently.
  field.seed = static_cast<std::uint64_t>(f.seed.value_or(soil.bed->seed)) + 1000003 * index;
  field.piles = !f.region;
  if (soil.container) field.cell = periods_spanned(f, *soil.container);
  if (f.region) {
    field.region = {f.region->at, f.region->at + f.region->size};
  } else {
    const Container& c = *soil.container;
    field.region = {{c.at.x, top, c.at.z}, {c.at.x + c.size.x, top + 2 * f.diameter, c.at.z + c.size.z}};
  }
  return dem::place_fibres(field, taken);
}

/// Nearest fibres of each sphere are not searched for: some thousand of either take less than a second.
std::size_t FibreCover::make_room(dem::Bed& bed, const dem::FibreShape& shape,
                                  const std::vector<dem::FibrePose>& poses) const {
  const dem::PeriodicCell cell = bed.options().periodic;
  const auto meets = [&](const dem::Sphere& s) {
    return std::any_of(poses.begin(), poses.end(), [&](const dem::FibrePose& pose) {
      const Vec3 nearest = pose.centre + cell.shortest(s.x - pose.centre);
      return distance(nearest, pose, shape) < s.r + 0.5 * shape.diameter;
    });
  };
  for (const dem::Sphere& s : bed.spheres())
    if (dem::is_fixed(s) && meets(s))
      throw std::invalid_argument(fmt::format(
          "a fibre in `region` meets the fixed sphere {} at ({:.4g}, {:.4g}, {:.4g}) m, which cannot be left out; move "
          "the region or the sphere",
          s.id, s.x.x, s.x.y, s.x.z));
  return bed.remove_if([&](const dem::Sphere& s) { return meets(s); });
}

}  // namespace subsoil::sim
