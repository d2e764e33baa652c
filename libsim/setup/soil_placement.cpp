#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "libsim/document/quantity.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/setup/fibres.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/shapes.hpp"
#include "libsim/setup/soil.hpp"

/// Where the spheres of a bed begin: lists, files, lattices, clumps, layers.
namespace subsoil::sim {
namespace {

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

/// @param around rows continue beyond periodic sides, which refuses other pitches
dem::LatticePlan SoilBuilder::lattice_plan(double pitch, bool around) const {
  const dem::BedMaterial lowest = material_of(layered() ? bed().layers.back().material : bed().material);
  dem::LatticePlan plan;
  plan.region = region();
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
struct SoilBuilder::SavedGrains {
  std::vector<dem::SphereSpec> spheres;  ///< loose ones
  std::vector<dem::ClumpSpec> clumps;
  std::vector<std::size_t> before;  ///< how many of the loose spheres come before each clump
};

namespace {

/// Rows of a table by rising id.
class RowsById {
 public:
  explicit RowsById(const BedTable& table) : table_(table), order_(table.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::sort(order_.begin(), order_.end(), [&](auto a, auto b) { return table.id[a] < table.id[b]; });
  }
  auto begin() const { return order_.begin(); }
  auto end() const { return order_.end(); }
  std::optional<std::size_t> row_of(std::int64_t id) const {
    const auto at = std::lower_bound(order_.begin(), order_.end(), id,
                                     [&](std::size_t row, std::int64_t i) { return table_.id[row] < i; });
    return at != order_.end() && table_.id[*at] == id ? std::optional(*at) : std::nullopt;
  }

 private:
  const BedTable& table_;
  std::vector<std::size_t> order_;
};

/// The scenario's shape of a saved clump; its spheres must be those of the file.
int shape_of_saved(const BedClump& clump, const BedTable& table, const RowsById& rows,
                   const std::vector<dem::ClumpShape>& shapes) {
  const auto shape = std::find_if(shapes.begin(), shapes.end(), [&](const auto& s) { return s.name == clump.shape; });
  if (shape == shapes.end())
    throw std::invalid_argument(
        fmt::format("holds clumps of the shape `{}`; describe it in `soil.clumps`, as the scenario did that saved it",
                    clump.shape));
  double mass = 0;
  for (std::size_t m = 0; m < shape->members.size(); ++m) {
    const auto row = rows.row_of(clump.first + static_cast<std::int64_t>(m));
    if (!row || std::abs(table.radius[*row] / shape->members[m].radius - 1) > 1e-9)
      throw std::invalid_argument(
          fmt::format("holds clumps of the shape `{}` with other spheres than those of `soil.clumps.{}`; take the "
                      "shape that it was "
                      "saved with",
                      clump.shape, clump.shape));
    mass += table.density[*row] * dem::sphere_volume(table.radius[*row]);
  }
  if (std::abs(mass / shape->mass - 1) > 1e-9)
    throw std::invalid_argument(
        fmt::format("holds clumps of the shape `{}` of {:.6g} kg, and here they have {:.6g} kg; give `soil.clumps.{}` "
                    "the `density` or "
                    "`mass` that it was saved with",
                    clump.shape, mass, shape->mass, clump.shape));
  return static_cast<int>(shape - shapes.begin());
}

}  // namespace

SoilBuilder::SavedGrains SoilBuilder::from_file() {
  const BedTable table = load_bed(bed().file, [](std::string_view unit, std::string_view si) {
    return unit.empty() || unit == si ? 1.0 : parse_quantity("1 " + std::string(unit), std::string(si));
  });
  if (table.size() == 0) throw std::invalid_argument(bed().file + ": holds no sphere");
  const auto& container = loaded_.scenario.soil->container;
  if (container && !container->periodic[1] && acts_down(loaded_.scenario.gravity)) datum_of_file_ = table.surface;
  if (!table.clumps.empty() && layered())
    throw std::invalid_argument(bed().file + ": holds clumps, which `layers` do not take; give the bed one material");
  const RowsById rows(table);
  SavedGrains out;
  std::vector<int> member(table.size(), 0);         // whether the row is of a clump
  std::map<std::int64_t, dem::ClumpSpec> clump_of;  // by its first sphere
  try {
    const std::vector<dem::ClumpShape>& shapes = world_.bed->clump_shapes();
    for (const BedClump& c : table.clumps) {
      const int shape = shape_of_saved(c, table, rows, shapes);
      clump_of[c.first] = {shape,      c.position, c.attitude,
                           c.velocity, c.spin,     material_of(table, *rows.row_of(c.first))};
      for (std::size_t m = 0; m < shapes[static_cast<std::size_t>(shape)].members.size(); ++m)
        member[*rows.row_of(c.first + static_cast<std::int64_t>(m))] = 1;
    }
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(bed().file + ": " + error.what());
  }
  std::vector<std::size_t> order;  // of the loose ones
  for (const std::size_t i : rows) {
    if (const auto clump = clump_of.find(table.id[i]); clump != clump_of.end())
      out.clumps.push_back(clump->second), out.before.push_back(out.spheres.size());
    if (member[i] != 0) continue;
    const int m = material_of(table, i);
    const double density = std::isnan(table.density[i])
                               ? loaded_.scenario.materials[static_cast<std::size_t>(m)].density
                               : table.density[i];
    out.spheres.push_back({table.position[i], table.velocity[i], table.spin[i], table.radius[i], density, m});
    order.push_back(i);
  }
  refuse_idle_material(table);
  if (const auto twice = find_coincident(out.spheres))
    throw std::invalid_argument(fmt::format("{}: spheres {} and {} {}", bed().file, table.id[order[twice->first]],
                                            table.id[order[twice->second]],
                                            coincident_words(out.spheres[twice->first].position)));
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
  refuse_too_deep();
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

void SoilBuilder::place_saved(const SavedGrains& saved) {
  const std::span<const dem::SphereSpec> spheres(saved.spheres);
  std::size_t placed = 0;
  for (std::size_t k = 0; k < saved.clumps.size(); ++k) {
    world_.bed->add(spheres.subspan(placed, saved.before[k] - placed));
    placed = saved.before[k];
    world_.bed->add(std::span(&saved.clumps[k], 1));
  }
  world_.bed->add(spheres.subspan(placed));
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
  } else if (fill == Fill::file) {
    SavedGrains saved = from_file();
    if (layered()) assign_layers(saved.spheres);
    place_saved(saved);
  } else if (fill == Fill::particles) {
    std::vector<dem::SphereSpec> spheres = listed();
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

/// `check` only looks: a lattice at rest distance of spheres of mean volume has about the spheres and contacts of a
/// random bed.
void SoilBuilder::place_stand_in() {
  if (layered() && has_clumps()) {
    for (const dem::BedLayer& l : layers()) {
      dem::LoosePlacer placer(region(), l.radius, l.shares, static_cast<std::uint64_t>(bed().seed), l.of, l.clumps);
      const double top = dem::highest_top(world_.bed->spheres(), region().low.y);
      dem::add(*world_.bed, placer.grains(static_cast<std::size_t>(std::ceil(expected_grains(l))), top));
    }
    return;
  }
  if (layered()) {
    std::vector<dem::BedLayer> alike = layers();
    for (dem::BedLayer& l : alike) l.radius = dem::EqualRadius{dem::radius_of_mean_volume(l.radius, l.shares)};
    std::vector<std::size_t> numbers;
    world_.bed->add(dem::layered_lattice(lattice_plan(0, false), lattice_layers(alike, true), numbers));
    return;
  }
  if (has_clumps()) {
    const auto grains = static_cast<std::size_t>(std::ceil(expected_grains() / spheres_per_grain(parts())));
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

}  // namespace subsoil::sim
