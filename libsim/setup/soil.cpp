#include "libsim/setup/soil.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/step/stability.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/setup/compaction_plate.hpp"
#include "libsim/setup/fibres.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/shapes.hpp"

namespace subsoil::sim {
namespace {

dem::ShareOf shares_of(ShareOf s) { return s == ShareOf::mass ? dem::ShareOf::mass : dem::ShareOf::number; }

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

/// The first two spheres, in their order, that have one centre: no law knows in which direction they push each other.
std::optional<std::pair<std::size_t, std::size_t>> find_coincident(const std::vector<dem::SphereSpec>& spheres) {
  std::vector<std::size_t> order(spheres.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t i) {
    const Vec3& p = spheres[i].position;
    return std::tuple(p.x, p.y, p.z);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  const auto at =
      std::adjacent_find(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) == key(b); });
  if (at == order.end()) return {};
  return std::pair{at[0], at[1]};
}
std::string coincident_words(const Vec3& p) {
  return fmt::format("have the same centre ({:.6g}, {:.6g}, {:.6g}) m: no force is defined there; remove or move one",
                     p.x, p.y, p.z);
}

}  // namespace

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
  dem::Bounds box;
  for (const dem::Sphere& s : world_.bed->spheres()) {
    box.include(s.x - Vec3{s.r, s.r, s.r});
    box.include(s.x + Vec3{s.r, s.r, s.r});
  }
  return box;
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
    out.push_back(
        {.top = top, .radius = sizes_of(radius), .shares = shares_of(bed().shares), .of = material_of(l.material)});
    top -= l.depth ? (*l.depth)[1] - (*l.depth)[0] : l.thickness.value_or(0);
  }
  std::reverse(out.begin(), out.end());
  return out;
}

std::vector<dem::LatticeLayer> SoilBuilder::lattice_layers(const std::vector<dem::BedLayer>& layers,
                                                           bool at_rest) const {
  std::vector<dem::LatticeLayer> out;
  for (const dem::BedLayer& layer : layers) {
    dem::LatticeLayer l{layer};
    const double mean = 0.5 * (dem::least_radius(layer.radius) + dem::largest_radius(layer.radius));
    const int own = layer.of.material;
    l.pitch = at_rest ? 2 * mean - rest_overlap(own, own) : bed().pitch.value_or(2.02 * mean);
    if (!out.empty()) {
      const dem::LatticeLayer& below = out.back();
      const double below_mean = 0.5 * (dem::least_radius(below.radius) + dem::largest_radius(below.radius));
      l.rise = at_rest ? mean + below_mean - rest_overlap(own, below.of.material) : 0.5 * (l.pitch + below.pitch);
    }
    out.push_back(l);
  }
  return out;
}

void SoilBuilder::place_layers(bool at_rest) {
  const std::vector<dem::LatticeLayer> layers = lattice_layers(this->layers(), at_rest);
  dem::LatticePlan plan = lattice_plan(0);
  std::vector<std::size_t> numbers;
  world_.bed->add(dem::layered_lattice(plan, layers, numbers));
  for (std::size_t k = 0; k < numbers.size(); ++k) layer_.insert(layer_.end(), numbers[k], static_cast<int>(k));
}

/// Material and density by depth of spheres that are given one by one.
void SoilBuilder::assign_layers(std::vector<dem::SphereSpec>& spheres) {
  const std::vector<dem::BedLayer> layers = this->layers();
  std::vector<dem::Sphere> placed(spheres.size());
  dem::Bounds box;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const dem::SphereSpec& s = spheres[i];
    placed[i].x = s.position, placed[i].r = s.radius;
    box.include(s.position - Vec3{s.radius, s.radius, s.radius});
    box.include(s.position + Vec3{s.radius, s.radius, s.radius});
  }
  // Over the spheres' own box: where the container's floor is empty there is no surface.
  layer_ = dem::layers_by_depth(placed, box, layers);
  std::vector<std::size_t> count(layers.size());
  for (const int k : layer_) ++count[static_cast<std::size_t>(k)];
  for (std::size_t k = 0; k < count.size(); ++k)
    if (count[k] == 0)
      throw ScenarioError(fmt::format("{}: gets no sphere: the bed does not reach so deep, or the layer is too thin",
                                      loaded_.where(fmt::format("soil.bed.layers[{}]", count.size() - 1 - k))));
  const double top = dem::surface_height(placed, box).mean;
  if (const double deep = top - box.low.y; deep > layers.back().top + 2 * placed[0].r)
    throw ScenarioError(
        fmt::format("{}: are {:.6g} mm deep together, the spheres lie down to {:.6g} mm; leave the lowest "
                    "layer's thickness out, and it takes the rest",
                    loaded_.where("soil.bed.layers"), layers.back().top * 1e3, deep * 1e3));
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const dem::BedMaterial of = layers[static_cast<std::size_t>(layer_[i])].of;
    const Particle* own = bed().fill == Fill::particles ? &bed().particles[i] : nullptr;
    if (own == nullptr || own->material.empty()) {
      spheres[i].material = of.material;
      if (own == nullptr || !own->density) spheres[i].density = of.density;
    }
  }
}

double SoilBuilder::rest_overlap(int a, int b) const {
  const int law = world_.laws.of(a, b);
  if (law < 0) return 0;
  return world_.laws.laws[static_cast<std::size_t>(law)]->rest_overlap();
}

/// @param around rows go on beyond periodic sides, which refuses other pitches
dem::LatticePlan SoilBuilder::lattice_plan(double pitch, bool around) const {
  const dem::BedMaterial lowest = material_of(layered() ? bed().layers.back().material : bed().material);
  dem::LatticePlan plan;
  plan.region = region();
  refuse_too_deep();
  if (!layered()) plan.radius = sizes();
  plan.clumps = parts();
  plan.shares = shares_of(bed().shares);
  plan.pitch = pitch;
  if (around) plan.periodic = periodic_region();
  if (loaded_.scenario.soil->container)
    plan.floor_overlap =
        rest_overlap(lowest.material, material_index(loaded_.scenario, loaded_.scenario.soil->container->material));
  plan.depth = bed().depth.value_or(0);
  plan.jitter = bed().jitter;
  plan.seed = static_cast<std::uint64_t>(bed().seed);
  return plan;
}

std::vector<dem::SphereSpec> SoilBuilder::listed() const {
  std::vector<dem::SphereSpec> out;
  for (const Particle& p : bed().particles) {
    const std::string& name = !p.material.empty() ? p.material : layered() ? bed().layers[0].material : bed().material;
    const int m = material_index(loaded_.scenario, name);
    const dem::SphereSpec sphere{p.position,
                                 p.velocity,
                                 p.spin,
                                 p.radius,
                                 p.density.value_or(loaded_.scenario.materials[static_cast<std::size_t>(m)].density),
                                 m};
    out.push_back(p.fixed.empty() ? sphere : dem::fixed(sphere));
  }
  if (const auto twice = find_coincident(out))
    throw ScenarioError(fmt::format("{}: this sphere and `particles[{}]` {}",
                                    loaded_.where(fmt::format("soil.bed.particles[{}]", twice->second)), twice->first,
                                    coincident_words(out[twice->first].position)));
  return out;
}

/// In ascending id of the file: the bed numbers its spheres in this order, so a saved bed keeps its numbers.
std::vector<dem::SphereSpec> SoilBuilder::from_file() {
  const BedTable table = load_bed(bed().file, [](std::string_view unit, std::string_view si) {
    return unit.empty() || unit == si ? 1.0 : parse_quantity("1 " + std::string(unit), std::string(si));
  });
  if (table.size() == 0) throw std::invalid_argument(bed().file + ": holds no sphere");
  const auto& container = loaded_.scenario.soil->container;
  if (container && !container->periodic[1] && acts_down(loaded_.scenario.gravity)) datum_of_file_ = table.surface;
  std::vector<std::size_t> order(table.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return table.id[a] < table.id[b]; });
  std::vector<dem::SphereSpec> out;
  out.reserve(table.size());
  for (const std::size_t i : order) {
    const int m = material_of(table, i);
    const double density = std::isnan(table.density[i])
                               ? loaded_.scenario.materials[static_cast<std::size_t>(m)].density
                               : table.density[i];
    out.push_back({table.position[i], table.velocity[i], table.spin[i], table.radius[i], density, m});
  }
  refuse_idle_material(table);
  if (const auto twice = find_coincident(out))
    throw std::invalid_argument(fmt::format("{}: spheres {} and {} {}", bed().file, table.id[order[twice->first]],
                                            table.id[order[twice->second]],
                                            coincident_words(out[twice->first].position)));
  return out;
}

/// A file that names the material of every sphere leaves none to `soil.bed.material`, which changes nothing then.
void SoilBuilder::refuse_idle_material(const BedTable& table) const {
  if (layered()) return;
  const std::set<std::string> named(table.material.begin(), table.material.end());
  if (named.contains("") || named.contains(bed().material)) return;
  throw ScenarioError(
      fmt::format("{} = {}: is the material of no sphere in {}, which names {}; give one of these, or "
                  "the properties that the spheres shall have to that material",
                  loaded_.where("soil.bed.material"), bed().material, bed().file, fmt::join(named, ", ")));
}

int SoilBuilder::material_of(const BedTable& table, std::size_t row) const {
  if (layered()) return material_index(loaded_.scenario, bed().layers[0].material);  // until it is known by its depth
  const std::string& name = table.material[row].empty() ? bed().material : table.material[row];
  try {
    return material_index(loaded_.scenario, name);
  } catch (const std::invalid_argument&) {
    std::vector<std::string> known;
    for (const Material& m : loaded_.scenario.materials) known.push_back(m.name);
    throw std::invalid_argument(
        fmt::format("{}: sphere {} is of material '{}', which the scenario does not have; "
                    "it has {}",
                    bed().file, table.id[row], name, fmt::join(known, ", ")));
  }
}

void SoilBuilder::place() {
  add_walls();
  name_fixed();
  add_shapes();
  if (!options_.place_soil) world_.bed->add(options_.restored);
  if (!has_bed() || !options_.place_soil) return;
  refuse_save_folder();
  try {
    place_made();
  } catch (const ScenarioError&) {
    throw;
  } catch (const std::exception& error) {
    throw ScenarioError(loaded_.where("soil.bed") + ": " + error.what());
  }
}

/// Before the bed settles, which may take minutes.
void SoilBuilder::refuse_save_folder() const {
  const std::filesystem::path folder = std::filesystem::path(bed().save).parent_path();
  if (!bed().save.empty() && !folder.empty() && !std::filesystem::is_directory(folder))
    throw ScenarioError(fmt::format("{} = {}: there is no folder {}; make it, or save the bed elsewhere",
                                    loaded_.where("soil.bed.save"), bed().save, folder.string()));
  if (bed().save.empty()) return;
  const std::filesystem::path part = temporary_name(bed().save);
  const bool writable = !std::filesystem::is_directory(bed().save) && std::ofstream(part).good();
  std::error_code none;
  std::filesystem::remove(part, none);
  if (!writable)
    throw ScenarioError(fmt::format("{} = {}: cannot be written there; name a file in a folder that may be written to",
                                    loaded_.where("soil.bed.save"), bed().save));
}

/// Spheres are numbered in the order of the file, from 0.
void SoilBuilder::name_fixed() {
  if (!has_bed()) return;
  if (bed().rough_floor) world_.fixed.push_back({rough_floor_name, {}});
  for (std::size_t i = 0; i < bed().particles.size(); ++i) {
    const std::string& name = bed().particles[i].fixed;
    if (name.empty()) continue;
    auto at =
        std::find_if(world_.fixed.begin(), world_.fixed.end(), [&](const FixedBody& f) { return f.name == name; });
    if (at == world_.fixed.end()) at = world_.fixed.insert(at, {name, {}});
    at->ids.push_back(static_cast<std::uint32_t>(i));
  }
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

void SoilBuilder::add_shapes() {
  if (!loaded_.scenario.soil) return;
  for (const ClumpSection& c : loaded_.scenario.soil->clumps) {
    std::vector<dem::ClumpMember> members;
    for (const ClumpSphere& s : c.spheres) members.push_back({c.scale * s.at, c.scale * s.radius});
    std::optional<dem::GivenMass> given;
    if (c.mass) given = dem::GivenMass{.mass = *c.mass, .centre = c.centre, .inertia = {}};
    if (c.mass && c.inertia) {
      const Vec3 &j = *c.inertia, p = c.products.value_or(Vec3{});
      given->inertia = dem::SquareMatrix<3>{{{j.x, p.x, p.z}, {p.x, j.y, p.y}, {p.z, p.y, j.z}}};
    }
    try {
      const double density = c.mass ? 0 : density_of(c);
      if (!c.mass && !(density > 0)) throw std::invalid_argument("needs `density`: the bed has no material of its own");
      world_.bed->add_shape(dem::clump_shape(c.name, members, density, given));
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

/// Of the spheres among the grains; where there are none, whatever the clumps are made of.
dem::RadiusDistribution SoilBuilder::sizes() const {
  if (!only_clumps(bed().clumps)) return sizes_of(bed().radius);
  return dem::EqualRadius{world_.bed->clump_shapes().front().members.front().radius};
}

double SoilBuilder::radius_of_mean_grain() const {
  const double sphere = dem::radius_of_mean_volume(sizes(), shares_of(bed().shares));
  double volume = dem::sphere_volume(sphere);
  if (!has_clumps()) return sphere;
  for (const dem::ClumpPart& part : parts()) volume += part.share * (part.volume - dem::sphere_volume(sphere));
  return std::cbrt(volume / dem::sphere_volume(1));
}

double SoilBuilder::spheres_per_grain() const {
  double number = 1;
  for (const dem::ClumpPart& part : parts()) {
    const auto& members = world_.bed->clump_shapes()[static_cast<std::size_t>(part.shape)].members;
    number += part.share * (static_cast<double>(members.size()) - 1);
  }
  return number;
}

void SoilBuilder::place_clumps() {
  std::vector<dem::ClumpSpec> out;
  for (const PlacedClump& c : bed().placed) {
    const int index = shape_index(loaded_.scenario, c.shape);
    const dem::ClumpShape& shape = world_.bed->clump_shapes()[static_cast<std::size_t>(index)];
    const dem::Quaternion turned = placement({}, c.rotation).attitude;
    out.push_back({index, c.position, turned * shape.axes, c.velocity, c.spin,
                   material_index(loaded_.scenario, c.material.empty() ? bed().material : c.material)});
  }
  world_.bed->add(out);
}

void SoilBuilder::place_made() {
  const Fill fill = bed().fill;
  refuse_too_many();
  if (fill <= Fill::random && !bed().particles.empty()) {
    world_.bed->add(listed());
    layer_.assign(bed().particles.size(), -1);
  }
  if (fill == Fill::random) {
    if (!options_.settle) place_stand_in();
  } else if (fill == Fill::particles || fill == Fill::file) {
    std::vector<dem::SphereSpec> spheres = fill == Fill::particles ? listed() : from_file();
    if (layered()) assign_layers(spheres);
    world_.bed->add(spheres);
    place_clumps();
  } else if (layered()) {
    place_layers(fill == Fill::rest_lattice);
  } else if (fill == Fill::lattice) {
    double mean = 0.5 * (dem::least_radius(sizes()) + dem::largest_radius(sizes()));
    for (const dem::ClumpPart& part : parts()) mean = std::max(mean, part.reach);
    dem::add(*world_.bed, dem::lattice_of_grains(lattice_plan(bed().pitch.value_or(2.02 * mean)), material()));
  } else {
    world_.bed->add(dem::rest_lattice(lattice_plan(bed().pitch.value_or(0)),
                                      rest_overlap(material().material, material().material), material()));
  }
  if (fill <= Fill::random) clear_stones();
  if (has_fibres() && !(settles() && options_.settle)) lay_fibres();
}

/// On a bed that stands as it was placed.
void SoilBuilder::lay_fibres() {
  std::uint32_t first = 0;
  for (const dem::Sphere& s : world_.bed->spheres()) first = std::max(first, s.id + 1);
  FibreCover cover(world_, loaded_, [](double) {});
  const dem::BedCover::Laid laid = cover.lay(*world_.bed, first);
  cover.laid(laid);
  extend_layers();
  const auto& container = loaded_.scenario.soil->container;
  if (settles() || !container) return;
  if (const double rim = container->at.y + container->size.y; laid.height > rim)
    throw ScenarioError(
        fmt::format("{}: reach {:.4g} mm above the rim of the container; make it higher, or let the bed settle with "
                    "them: `settle: {{until: ...}}`",
                    loaded_.where("soil.bed.fibres"), 1e3 * (laid.height - rim)));
}

/// Fibres are of no layer.
void SoilBuilder::extend_layers() {
  if (!layer_.empty() && !world_.fibres.empty()) layer_.resize(world_.fibres.back().end(), -1);
}

/// While fibres come down.
void SoilBuilder::raise_walls(double height) {
  const auto& container = loaded_.scenario.soil->container;
  if (container) shape_walls(std::max(0.0, height - container->at.y - container->size.y));
}

/// Grains of a lattice that overlap the fixed spheres among them. Those that rain begin above all of them.
void SoilBuilder::clear_stones() {
  std::vector<dem::Sphere> stones;
  for (const dem::Sphere& s : world_.bed->spheres())
    if (dem::is_fixed(s)) stones.push_back(s);
  if (stones.empty()) return;
  world_.bed->remove_if([&](const dem::Sphere& s) {
    return !dem::is_fixed(s) && std::any_of(stones.begin(), stones.end(), [&](const dem::Sphere& stone) {
      return dem::norm(world_.bed->options().periodic.shortest(s.x - stone.x)) < s.r + stone.r;
    });
  });
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
    return spheres_per_grain() * static_cast<double>(*bed().count);
  }
  const dem::Bounds box = region();
  if (!layered()) {
    const double denser = has_clumps() ? 1 : dem::denser_than_equal(sizes(), shares_of(bed().shares));
    return denser * spheres_per_grain() *
           poured(box, periodic_region(), bed().depth.value_or(box.high.y - box.low.y), 2, radius_of_mean_grain(),
                  rest_overlap(material().material, material().material));
  }
  double sum = 0, below = 0;
  const std::vector<dem::BedLayer> all = layers();
  for (const dem::BedLayer& l : all) {
    const int ends = (&l == &all.front() ? 1 : 0) + (&l == &all.back() ? 1 : 0);
    sum += dem::denser_than_equal(l.radius, l.shares) * poured(box, periodic_region(), l.top - below, ends,
                                                               dem::radius_of_mean_volume(l.radius, l.shares),
                                                               rest_overlap(l.of.material, l.of.material));
    below = l.top;
  }
  return sum;
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

/// `check` only looks: a lattice at rest distance of spheres of mean volume has about the spheres and contacts of a
/// random bed.
void SoilBuilder::place_stand_in() {
  if (layered()) {
    std::vector<dem::BedLayer> alike = layers();
    for (dem::BedLayer& l : alike) l.radius = dem::EqualRadius{dem::radius_of_mean_volume(l.radius, l.shares)};
    std::vector<std::size_t> numbers;
    world_.bed->add(dem::layered_lattice(lattice_plan(0, false), lattice_layers(alike, true), numbers));
    return;
  }
  if (has_clumps()) {
    const auto grains = static_cast<std::size_t>(std::ceil(expected_grains() / spheres_per_grain()));
    dem::LoosePlacer placer(region(), sizes(), shares_of(bed().shares), static_cast<std::uint64_t>(bed().seed),
                            material(), parts());
    return dem::add(*world_.bed, placer.grains(grains, region().low.y));
  }
  const double mean = radius_of_mean_grain();
  dem::LatticePlan plan = lattice_plan(2 * mean - rest_overlap(material().material, material().material), false);
  plan.radius = dem::EqualRadius{mean};
  if (bed().count) {  // no more columns and layers than they need
    const auto columns = [&](double length) { return std::max(1.0, std::floor(length / plan.pitch)); };
    const double count = static_cast<double>(*bed().count);
    const Vec3 size = plan.region.high - plan.region.low;
    const double along = std::min(columns(size.x), count), across = std::min(columns(size.z), std::ceil(count / along));
    const Vec3 middle = 0.5 * (plan.region.low + plan.region.high);
    const auto shrink = [&](double Vec3::*axis, double count_there) {
      const double half = 0.5 * (count_there + 0.5) * plan.pitch;
      plan.region.low.*axis = middle.*axis - half, plan.region.high.*axis = middle.*axis + half;
    };
    if (along < columns(size.x)) shrink(&Vec3::x, along);
    if (across < columns(size.z)) shrink(&Vec3::z, across);
    plan.depth = std::min(size.y, (std::ceil(count / (along * across)) + 0.5) * plan.pitch);
  }
  std::vector<dem::SphereSpec> spheres = dem::lattice(plan, material());
  if (bed().count && spheres.size() > static_cast<std::size_t>(*bed().count))
    spheres.resize(static_cast<std::size_t>(*bed().count));
  world_.bed->add(spheres);
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
    for (const dem::ClumpMember& m : shape.members) {
      q.largest_radius = std::max(q.largest_radius, m.radius);
      q.smallest_radius = std::min(q.smallest_radius, m.radius);
    }
    for (const dem::ClumpMember& m : shape.members)
      q.density = std::min(q.density, dem::least_effective_mass(shape) / dem::sphere_volume(m.radius));
  }
  return q;
}

/// A bed deeper than its region would be cut at the rim in silence.
void SoilBuilder::refuse_too_deep() const {
  const double height = region().high.y - region().low.y;
  if (bed().depth && *bed().depth > height * (1 + 1e-9))
    throw ScenarioError(
        fmt::format("{} = {:.4g} m: is more than the {:.4g} m that the container (or `region`) is high; "
                    "make it higher, or the bed shallower",
                    loaded_.where("soil.bed.depth"), *bed().depth, height));
}

dem::RandomFill SoilBuilder::random_fill() const {
  dem::RandomFill fill;
  fill.region = region();
  refuse_too_deep();
  fill.seed = static_cast<std::uint64_t>(bed().seed);
  if (layered()) {
    fill.layers = layers();
    return fill;
  }
  fill.radius = sizes();
  fill.clumps = parts();
  fill.shares = shares_of(bed().shares);
  fill.of = material();
  if (bed().count) fill.count = static_cast<std::size_t>(*bed().count);
  fill.depth = bed().depth;
  if (!fill.count && !fill.depth) fill.depth = fill.region.high.y - fill.region.low.y;
  return fill;
}

void SoilBuilder::settle(double step) {
  const Settle& s = bed().settle.value_or(Settle{});
  dem::SettlePlan plan;
  plan.step = step;
  plan.duration = s.duration;
  plan.until_speed = s.until_speed;
  plan.at_most = s.at_most;
  plan.staged = s.staged(bed().fill);
  plan.lowered = s.lowered;
  plan.ramp = s.ramp;
  if (options_.progress)
    plan.progress = [this](const dem::SettleProgress& p) { return options_.progress(p.elapsed, p.rms_speed); };
  plan.compaction.density = s.density, plan.compaction.region = measured();
  if (s.density) plan.lowered = 1;
  std::optional<CompactionPlate> plate;
  if (s.pressure) plan.compaction.load = &plate.emplace(*world_.bed, plate_, *s.pressure, step);
  FibreCover cover(world_, loaded_, [this](double height) { raise_walls(height); });
  if (has_fibres()) cover.refuse_without_room(), plan.cover = &cover;
  plan.from = options_.settling;
  plan.keep_due = options_.keep_settling_due;
  if (options_.keep_settling)
    plan.keep = [this](const dem::SettleState& state) { options_.keep_settling(state, *world_.bed); };
  try {
    dem::SettleReport report;
    if (rains()) {
      const dem::RandomFill fill = random_fill();
      // Loose spheres take up to four times the height of the settled bed; walls stand that high while it rains.
      shape_walls(4 * (fill.region.high.y - fill.region.low.y) + 20 * question().largest_radius);
      report = dem::fill_at_random(*world_.bed, world_.laws, fill, plan);
      shape_walls(0);
      for (std::size_t k = 0; k < report.layer_ends.size(); ++k)
        layer_.resize(report.layer_ends[k], static_cast<int>(k));
    } else {
      report = dem::settle(*world_.bed, world_.laws, plan, region());
      if (has_fibres()) shape_walls(0);
    }
    extend_layers();
    world_.soil.settled_for = report.settled_time;
    world_.soil.rms_speed = report.rms_speed;
    world_.soil.stopped = report.stopped;
  } catch (const dem::BedFault&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(loaded_.where("soil.bed.settle") + ": " + error.what());
  }
}

void SoilBuilder::save() const {
  if (bed().save.empty()) return;
  BedTable table;
  for (const dem::Sphere& s : world_.bed->spheres()) {
    table.id.push_back(s.id);
    table.position.push_back(world_.bed->options().periodic.wrapped(s.x));
    table.radius.push_back(s.r);
    table.density.push_back(dem::density(s));
    table.material.push_back(loaded_.scenario.materials[s.material].name);
    table.velocity.push_back(s.v);
    table.spin.push_back(s.w);
  }
  table.surface = datum();
  save_bed(bed().save, table);
}

/// Of the scenario; left out there, that of the run which saved the bed.
std::optional<double> SoilBuilder::datum() const {
  return loaded_.scenario.soil->surface ? loaded_.scenario.soil->surface : datum_of_file_;
}

void SoilBuilder::fix_rough_floor() {
  const double below = loaded_.scenario.soil->container->at.y + *bed().rough_floor;
  const std::size_t fixed = world_.bed->fix_if([&](const dem::Sphere& s) { return s.x.y < below; });
  if (fixed == world_.bed->spheres().size())
    throw ScenarioError(
        fmt::format("{} = {:.4g} m: fixes all {} spheres, so that nothing moves; a radius and more takes the lowest",
                    loaded_.where("soil.bed.rough floor"), *bed().rough_floor, fixed));
  if (fixed == 0)
    throw ScenarioError(
        fmt::format("{} = {:.4g} m: no sphere has its centre so low; a radius and more takes the lowest",
                    loaded_.where("soil.bed.rough floor"), *bed().rough_floor));
}

void SoilBuilder::finish() {
  if (!loaded_.scenario.soil) return;
  dem::Bed& bed = *world_.bed;
  const bool has_spheres = !bed.spheres().empty();
  if (has_spheres && has_bed() && options_.place_soil && this->bed().rough_floor && !world_.soil.stopped)
    fix_rough_floor();
  if (has_spheres) {
    const dem::BedReport r = dem::report(bed, measured(), world_.soil.fibres_from);
    world_.soil.spheres = r.spheres, world_.soil.clumps = bed.clumps().size();
    world_.soil.mass = r.mass;
    world_.soil.bulk_density = r.bulk_density;
    world_.soil.surface_mean = r.surface.mean;
    world_.soil.surface_spread = r.surface.spread;
    world_.soil.coordination = r.coordination;
    if (settles() && !is_loose() && acts_down(loaded_.scenario.gravity))
      world_.soil.by_depth = profile_by_depth(bed, measured(), world_.soil.fibres_from);
    if (!layer_.empty()) {
      const auto layers = dem::report_layers(bed.spheres(), measured(), layer_, this->bed().layers.size());
      for (std::size_t k = 0; k < layers.size(); ++k)
        world_.soil.layers.emplace_back(this->bed().layers[k].material, layers[layers.size() - 1 - k]);
    }
  }
  // Before box and bed move together to the datum, so that a run with this container finds the bed on its floor.
  if (has_bed() && has_spheres && options_.settle && options_.place_soil && !world_.soil.stopped) save();
  if (const std::optional<double> surface = datum(); surface && has_spheres && options_.place_soil) {
    world_.container_shift = *surface - world_.soil.surface_mean;
    bed.shift({0, world_.container_shift, 0});
    shift_walls();
    world_.soil.surface_mean = *surface;
    for (auto& [name, layer] : world_.soil.layers) layer.top += world_.container_shift;
  }
  open_walls();
  bed.set_time(0);
  bed.reset_energy_balance();
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
