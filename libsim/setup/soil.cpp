#include "libsim/setup/soil.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/step/stability.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/setup/fibres.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/shapes.hpp"

namespace subsoil::sim {
namespace {

/// Face f (-x +x -y +y -z +z) of a box, normal inward.
dem::TriangleMesh face_mesh(const Vec3& at, const Vec3& size, int f) {
  const int axis = f / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto along = [&](int k) {
    const double x[3] = {k == 0 ? size.x : 0, k == 1 ? size.y : 0, k == 2 ? size.z : 0};
    return Vec3{x[0], x[1], x[2]};
  };
  const bool upper = f % 2 == 1;
  const Vec3 corner = upper ? at + along(axis) : at;
  return upper ? dem::rectangle_mesh(corner, along(v), along(u)) : dem::rectangle_mesh(corner, along(u), along(v));
}

}  // namespace

dem::ShareOf shares_of(ShareOf s) { return s == ShareOf::mass ? dem::ShareOf::mass : dem::ShareOf::number; }

dem::RadiusDistribution sizes_of(const RadiusDistribution& d) {
  struct Convert {
    dem::RadiusDistribution operator()(const EqualRadius& r) const { return dem::EqualRadius{r.radius}; }
    dem::RadiusDistribution operator()(const NormalRadius& r) const {
      return dem::NormalRadius{r.mean, r.deviation, r.least, r.largest};
    }
    dem::RadiusDistribution operator()(const UniformRadius& r) const { return dem::UniformRadius{r.least, r.largest}; }
    dem::RadiusDistribution operator()(const TableRadius& r) const { return dem::TableRadius{r.radius, r.share}; }
  };
  return std::visit(Convert{}, d);
}

SoilBuilder::SoilBuilder(World& world, const Loaded& loaded, const BuildOptions& options)
    : world_(world), loaded_(loaded), options_(options) {}

void SoilBuilder::add_walls() {
  const Scenario& s = loaded_.scenario;
  if (!s.soil || !s.soil->container) return;
  const Container& c = *s.soil->container;
  for (std::size_t f = 0; f < face_names.size(); ++f) {
    if (!has_wall(c, f)) continue;
    dem::Boundary wall;
    wall.name = wall_name(f);
    wall.material = material_index(s, c.material);
    wall.meets_fixed = false;
    const int index = world_.bed->add(std::move(wall));
    wall_[f] = index;
    world_.surfaces.push_back(
        {.name = world_.bed->boundary(index).name, .owner = SurfaceRecord::Owner::container, .boundary = index});
  }
  add_plate();
  shape_walls(0);
}

/// Of the container's size, beyond periodic sides as walls are. It acts on nothing but while the bed is pressed.
void SoilBuilder::add_plate() {
  if (!has_bed() || !bed().settle || !bed().settle->pressure) return;
  Container c = *loaded_.scenario.soil->container;
  for (int d = 0; d < 3; ++d)
    if (c.periodic[static_cast<std::size_t>(d)]) c.at[d] -= 0.5 * c.size[d], c.size[d] *= 2;
  dem::Boundary plate;
  plate.name = "compaction plate";
  plate.material = material_index(loaded_.scenario, c.material);
  plate.meets_fixed = plate.active = false;
  plate.shape = dem::MeshSurface(face_mesh(c.at, {c.size.x, 0, c.size.z}, 3));
  plate_ = world_.bed->add(std::move(plate));
}

/// Walls as high as the container, or higher while spheres rain in. Along periodic directions they reach beyond both
/// sides, by more than spheres do.
void SoilBuilder::shape_walls(double extra_height) {
  if (!loaded_.scenario.soil || !loaded_.scenario.soil->container) return;
  Container c = *loaded_.scenario.soil->container;
  for (int d = 0; d < 3; ++d)
    if (c.periodic[static_cast<std::size_t>(d)]) c.at[d] -= 0.5 * c.size[d], c.size[d] *= 2;
  const Vec3 size{c.size.x, c.size.y + extra_height, c.size.z};
  for (int f = 0; f < 6; ++f)
    if (const int index = wall_[static_cast<std::size_t>(f)]; index >= 0) {
      // A lid stays where it is; rain falls through the place of an open one only.
      const Vec3& used = f == 3 ? c.size : size;
      world_.bed->boundary(index).shape = dem::MeshSurface(face_mesh(c.at, used, f));
    }
  world_.bed->surfaces_changed();
}

dem::Bounds SoilBuilder::region() const {
  const Soil& soil = *loaded_.scenario.soil;
  if (soil.bed && soil.bed->region) return {soil.bed->region->at, soil.bed->region->at + soil.bed->region->size};
  if (soil.container) return {soil.container->at, soil.container->at + soil.container->size};
  return dem::box_of(world_.bed->spheres());
}

/// Where the bed is measured: one that has settled lies on the container's floor, wherever its region was.
dem::Bounds SoilBuilder::measured() const {
  dem::Bounds box = region();
  const Soil& soil = *loaded_.scenario.soil;
  if (settles() && soil.container && !soil.container->periodic[1] && acts_down(loaded_.scenario.gravity))
    box.low.y = soil.container->at.y, box.high.y = soil.container->at.y + soil.container->size.y;
  return box;
}

/// In which directions the region goes on beyond its sides.
Directions SoilBuilder::periodic_region() const {
  Directions out{};
  const Soil& soil = *loaded_.scenario.soil;
  if (!soil.container) return out;
  const Container& c = *soil.container;
  const dem::Bounds box = region();
  for (int d = 0; d < 3; ++d)
    out[static_cast<std::size_t>(d)] =
        c.periodic[static_cast<std::size_t>(d)] && std::abs(box.high[d] - box.low[d] - c.size[d]) <= 1e-9 * c.size[d];
  return out;
}

dem::BedMaterial SoilBuilder::material_of(const std::string& name) const {
  const int index = material_index(loaded_.scenario, name);
  return {loaded_.scenario.materials[static_cast<std::size_t>(index)].density, index};
}

/// The depth that is asked for, or what all thicknesses make, or the whole region.
double SoilBuilder::depth_of_layers() const {
  const std::vector<Layer>& layers = bed().layers;
  double sum = 0;
  for (const Layer& l : layers) sum += l.depth ? (*l.depth)[1] - (*l.depth)[0] : l.thickness.value_or(0);
  const bool open = !layers.back().depth && !layers.back().thickness;
  if (!open) return sum;
  if (bed().depth) return *bed().depth;
  const bool made = bed().fill <= Fill::random;
  return made ? region().high.y - region().low.y : sum + 1e3;  // of given spheres: however deep
}

/// From below, as the bed makers take them.
std::vector<dem::BedLayer> SoilBuilder::layers() const {
  std::vector<dem::BedLayer> out;
  double top = depth_of_layers();
  for (const Layer& l : bed().layers) {
    const auto* own = std::get_if<EqualRadius>(&l.radius);
    const RadiusDistribution& radius = own != nullptr && std::isnan(own->radius) ? bed().radius : l.radius;
    out.push_back({.top = top,
                   .radius = sizes_among(l.clumps, radius),
                   .shares = shares_of(bed().shares),
                   .of = material_of(l.material),
                   .clumps = parts_of(l.clumps, loaded_.scenario, *world_.bed)});
    top -= l.depth ? (*l.depth)[1] - (*l.depth)[0] : l.thickness.value_or(0);
  }
  std::reverse(out.begin(), out.end());
  return out;
}

double SoilBuilder::rest_overlap(int a, int b) const {
  const int law = world_.laws.of(a, b);
  if (law < 0) return 0;
  return world_.laws.laws[static_cast<std::size_t>(law)]->rest_overlap();
}

/// Of the material of what uses it, kg/m3; 0: nothing that has one does.
double SoilBuilder::density_of(const ClumpSection& clump) const {
  if (clump.density) return *clump.density;
  const auto names = [&](const auto& uses) {
    return std::any_of(uses.begin(), uses.end(), [&](const auto& use) { return use.shape == clump.name; });
  };
  std::vector<std::string> materials;
  const Soil& soil = *loaded_.scenario.soil;
  if (has_bed() && (names(bed().clumps) || names(bed().placed))) materials.push_back(bed().material);
  if (has_bed())
    for (const Layer& l : bed().layers)
      if (names(l.clumps)) materials.push_back(l.material);
  for (const InletSection& i : soil.inlets)
    if (names(clumps_of(i, soil.bed))) materials.push_back(sim::material_of(i, soil.bed));
  double density = 0;
  for (const std::string& name : materials) {
    if (name.empty()) continue;
    const double other = material_of(name).density;
    if (density > 0 && other != density)
      throw std::invalid_argument(fmt::format(
          "is of materials of {:.6g} and {:.6g} kg/m^3; give it `density`, or a shape to each", density, other));
    density = other;
  }
  return density > 0 || !has_bed() || bed().material.empty() ? density : material().density;
}

dem::ClumpShape clump_shape_of(const ClumpSection& c, double density) {
  std::vector<dem::ClumpMember> members;
  for (const ClumpSphere& s : c.spheres) members.push_back({c.scale * s.at, c.scale * s.radius});
  std::optional<dem::GivenMass> given;
  if (c.mass) given = dem::GivenMass{.mass = *c.mass, .centre = c.centre, .inertia = {}};
  if (c.mass && c.inertia) {
    const Vec3 &j = *c.inertia, p = c.products.value_or(Vec3{});
    given->inertia = dem::SquareMatrix<3>{{{j.x, p.x, p.z}, {p.x, j.y, p.y}, {p.z, p.y, j.z}}};
  }
  return dem::clump_shape(c.name, members, density, given);
}

void SoilBuilder::add_shapes() {
  if (!loaded_.scenario.soil) return;
  for (const ClumpSection& c : loaded_.scenario.soil->clumps) {
    try {
      const double density = c.mass ? 0 : density_of(c);
      if (!c.mass && !(density > 0)) throw std::invalid_argument("needs `density`: the bed has no material of its own");
      world_.bed->add_shape(clump_shape_of(c, density));
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded_.where("soil.clumps." + c.name) + ": " + error.what());
    }
  }
}

namespace {

/// The bed has them in the order of the scenario.
int shape_index(const Scenario& s, const std::string& name) {
  const Names names = names_of(s.soil->clumps);
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

}  // namespace

std::vector<dem::ClumpPart> parts_of(const std::vector<ClumpShare>& clumps, const Scenario& s, const dem::Bed& bed) {
  std::vector<dem::ClumpPart> out;
  for (const ClumpShare& c : clumps) out.push_back(dem::clump_part(bed, shape_index(s, c.shape), c.share));
  return out;
}

std::vector<dem::ClumpPart> SoilBuilder::parts() const { return parts_of(bed().clumps, loaded_.scenario, *world_.bed); }

/// Where there are no spheres, whatever the clumps are made of.
dem::RadiusDistribution SoilBuilder::sizes_among(const std::vector<ClumpShare>& clumps,
                                                 const RadiusDistribution& radius) const {
  if (!only_clumps(clumps)) return sizes_of(radius);
  return dem::EqualRadius{world_.bed->clump_shapes().front().members.front().radius};
}
dem::RadiusDistribution SoilBuilder::sizes() const { return sizes_among(bed().clumps, bed().radius); }

namespace {

double radius_of_mean_grain(const dem::RadiusDistribution& sizes, dem::ShareOf shares,
                            const std::vector<dem::ClumpPart>& clumps) {
  const double sphere = dem::radius_of_mean_volume(sizes, shares);
  if (clumps.empty()) return sphere;
  double volume = dem::sphere_volume(sphere);
  for (const dem::ClumpPart& part : clumps) volume += part.share * (part.volume - dem::sphere_volume(sphere));
  return std::cbrt(volume / dem::sphere_volume(1));
}

}  // namespace

double SoilBuilder::radius_of_mean_grain() const {
  return sim::radius_of_mean_grain(sizes(), shares_of(bed().shares), parts());
}

double SoilBuilder::spheres_per_grain(const std::vector<dem::ClumpPart>& clumps) const {
  double number = 1;
  for (const dem::ClumpPart& part : clumps) {
    const auto& members = world_.bed->clump_shapes()[static_cast<std::size_t>(part.shape)].members;
    number += part.share * (static_cast<double>(members.size()) - 1);
  }
  return number;
}

/// Spheres in a box at the density of poured beds of equal spheres. @param ends of the height where the packing ends,
/// at the floor and at the surface: less dense there, as at walls
double poured(const dem::Bounds& box, const Directions& periodic, double height, int ends, double radius,
              double overlap) {
  const double wall = 2 * radius / 6;
  const double closer = 2 * radius / (2 * radius - std::clamp(overlap, 0.0, radius));
  const Vec3 size = box.high - box.low;
  const auto less = [&](double length, int sides) { return std::max(length - sides * wall, 0.0); };
  const double x = periodic[0] ? size.x : less(size.x, 2), z = periodic[2] ? size.z : less(size.z, 2);
  return 0.61 * closer * closer * closer * x * z * less(height, ends) / dem::sphere_volume(radius);
}

double SoilBuilder::expected_spheres() const {
  if (!has_bed() || bed().fill != Fill::random) return static_cast<double>(world_.bed->spheres().size());
  return expected_grains() + static_cast<double>(fibre_spheres(loaded_.scenario));
}

/// Of a random bed, without fibres.
double SoilBuilder::expected_grains() const {
  if (bed().count) {
    // Which grains are clumps of which shape is drawn: as placed, where all are.
    long members = 0, alone = 0;
    for (const dem::Sphere& one : world_.bed->spheres()) {
      members += one.kind == dem::SphereKind::member ? 1 : 0;
      alone += one.kind == dem::SphereKind::free && one.id < world_.soil.fibres_from ? 1 : 0;
    }
    if (alone + static_cast<long>(world_.bed->clumps().size()) == *bed().count)
      return static_cast<double>(alone + members);
    return spheres_per_grain(parts()) * static_cast<double>(*bed().count);
  }
  const dem::Bounds box = region();
  if (!layered()) {
    const double denser = has_clumps() ? 1 : dem::denser_than_equal(sizes(), shares_of(bed().shares));
    return denser * spheres_per_grain(parts()) *
           poured(box, periodic_region(), bed().depth.value_or(box.high.y - box.low.y) + below_region(), 2,
                  radius_of_mean_grain(), rest_overlap(material().material, material().material));
  }
  double sum = 0;
  for (const dem::BedLayer& l : layers()) sum += spheres_per_grain(l.clumps) * expected_grains(l);
  return sum;
}

double SoilBuilder::expected_grains(const dem::BedLayer& layer) const {
  const std::vector<dem::BedLayer> all = layers();
  double below = 0;
  for (const dem::BedLayer& l : all)
    if (l.top < layer.top) below = l.top;
  const int ends = (below == 0 ? 1 : 0) + (layer.top == all.back().top ? 1 : 0);
  return (layer.clumps.empty() ? dem::denser_than_equal(layer.radius, layer.shares) : 1) *
         poured(region(), periodic_region(), layer.top - below + (below == 0 ? below_region() : 0), ends,
                sim::radius_of_mean_grain(layer.radius, layer.shares, layer.clumps),
                rest_overlap(layer.of.material, layer.of.material));
}

/// Lengths of which one has the wrong unit ask for more spheres than a computer holds.
void SoilBuilder::refuse_too_many() const {
  if (layered() || bed().fill > Fill::random) return;
  constexpr double most = 1e8;
  const double radius = radius_of_mean_grain();
  const dem::Bounds box = region();
  const Vec3 size = box.high - box.low;
  const double height = bed().depth.value_or(size.y), volume = size.x * height * size.z;
  const double count = bed().count ? static_cast<double>(*bed().count) : 0.6 * volume / dem::sphere_volume(radius);
  const std::string numbers = fmt::format("{:.2g} spheres of {:.4g} m radius in {:.4g} x {:.4g} x {:.4g} m", count,
                                          radius, size.x, height, size.z);
  if (count > most)
    throw ScenarioError(fmt::format(
        "{}: makes {}, {:.2g} bytes; at most {:g} spheres: is the unit of the radius or of the container's size "
        "right (a thousandth of it, mm for m, makes 1e9 times as many)?",
        loaded_.where("soil.bed.radius"), numbers, 520 * count, most));
  // While it rains walls stand four times as high; what is above the rim in the end lies outside.
  if (bed().count && count * dem::sphere_volume(radius) > 1.2 * volume)
    throw ScenarioError(
        fmt::format("{}: {} take {:.3g} m^3, {:.2g} times what there is; fewer, smaller, or a larger "
                    "container",
                    loaded_.where("soil.bed.count"), numbers, count * dem::sphere_volume(radius),
                    count * dem::sphere_volume(radius) / volume));
}

bool SoilBuilder::is_loose() const { return settles() && !options_.settle; }
bool SoilBuilder::settles() const { return has_bed() && options_.place_soil && bed().settles(); }

dem::StepQuestion SoilBuilder::question() const {
  dem::StepQuestion q{.smallest_radius = 1e300, .largest_radius = 0, .density = 1e300, .speed = 0, .neighbours = 0};
  for (const dem::Sphere& s : world_.bed->spheres()) {
    if (is_of_fibres_only(loaded_.scenario, s.material)) continue;  // question_between() has them
    q.largest_radius = std::max(q.largest_radius, s.r);
    q.smallest_radius = std::min(q.smallest_radius, s.r);
    if (s.kind != dem::SphereKind::member) q.density = std::min(q.density, dem::density(s));
  }
  q.neighbours = dem::most_neighbours(world_.bed->spheres().size() + fibre_spheres(loaded_.scenario));
  const auto spheres = world_.bed->spheres();
  if (rains() && (std::all_of(spheres.begin(), spheres.end(), dem::is_fixed) || !options_.settle)) {
    q.neighbours = 12;
    const auto expect = [&](const dem::RadiusDistribution& sizes, double density) {
      q.smallest_radius = std::min(q.smallest_radius, dem::least_radius(sizes));
      q.largest_radius = std::max(q.largest_radius, dem::largest_radius(sizes));
      q.density = std::min(q.density, density);
    };
    if (!layered() && !only_clumps(bed().clumps)) expect(sizes(), material().density);
    if (layered())
      for (const dem::BedLayer& l : layers()) expect(l.radius, l.of.density);
  }
  for (const InletSection& inlet :
       loaded_.scenario.soil ? loaded_.scenario.soil->inlets : std::vector<InletSection>{}) {
    q.neighbours = 12;
    if (only_clumps(clumps_of(inlet, loaded_.scenario.soil->bed))) continue;
    const dem::RadiusDistribution sizes = sizes_of(inlet, loaded_.scenario);
    q.smallest_radius = std::min(q.smallest_radius, dem::least_radius(sizes));
    q.largest_radius = std::max(q.largest_radius, dem::largest_radius(sizes));
    q.density = std::min(q.density, material_of(sim::material_of(inlet, loaded_.scenario.soil->bed)).density);
  }
  // A clump's end yields like a lighter sphere: what impacts on clumps must be resolved by.
  for (const dem::ClumpShape& shape : world_.bed->clump_shapes()) {
    if (!uses_clump(loaded_.scenario, shape.name)) continue;
    for (const dem::ClumpMember& m : shape.members) {
      q.largest_radius = std::max(q.largest_radius, m.radius);
      q.smallest_radius = std::min(q.smallest_radius, m.radius);
    }
    for (const dem::ClumpMember& m : shape.members)
      q.density = std::min(q.density, dem::least_effective_mass(shape) / dem::sphere_volume(m.radius));
  }
  return q;
}

/// To the datum of the bed.
void SoilBuilder::shift_walls() {
  for (const SurfaceRecord& s : world_.surfaces)
    if (s.owner == SurfaceRecord::Owner::container) {
      dem::Boundary& wall = world_.bed->boundary(s.boundary);
      wall.pose.position += Vec3{0, world_.container_shift, 0};
      wall.pose_before = wall.pose;  // a change of datum is no motion that does work
    }
}

void SoilBuilder::open_walls() {
  const Soil& soil = *loaded_.scenario.soil;
  if (!soil.container) return;
  for (int f = 0; f < 6; ++f)
    if (soil.container->open_after_settling[static_cast<std::size_t>(f)] && wall_[static_cast<std::size_t>(f)] >= 0)
      world_.bed->boundary(wall_[static_cast<std::size_t>(f)]).active = false;
  world_.bed->set_floor_drop(soil.container->at.y + world_.container_shift - soil.removal_below);
  world_.bed->surfaces_changed();
}

void SoilBuilder::place_walls() {
  add_walls();
  shift_walls();
  open_walls();
}

void SoilBuilder::check_wheel_datum() const {
  const Scenario& s = loaded_.scenario;
  if (!s.machine || !has_bed() || world_.bed->spheres().empty()) return;
  if (!options_.place_soil) return;  // a bed of a state, which has been worked
  for (const NamedForce& f : s.machine->forces)
    if (const auto* wheel = f.element.get_if<mbd::WheelOnSoil>()) {
      const double off = world_.soil.surface_mean - wheel->surface;
      const double radius = dem::mean_radius(world_.bed->spheres());
      if (options_.settle && std::abs(off) > radius)
        throw ScenarioError(
            fmt::format("{} = {} m: the bed's surface is at {:.4f} m, {:.1f} mm off the datum of the wheel's law, more "
                        "than a sphere's "
                        "radius; set `soil.surface` to the datum, or move the datum",
                        loaded_.where("machine.forces." + f.name + ".surface"), wheel->surface,
                        world_.soil.surface_mean, off * 1e3));
    }
}

}  // namespace subsoil::sim
