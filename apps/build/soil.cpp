#include "apps/build/soil.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/build/laws.hpp"
#include "apps/scenario/units.hpp"
#include "libdem/bed/carve.hpp"
#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::app {
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
  for (int f = 0; f < 6; ++f) {
    if (c.open[static_cast<std::size_t>(f)]) continue;
    dem::Boundary wall;
    wall.name = f == 2 ? "floor" : std::string("wall ") + face_names[static_cast<std::size_t>(f)];
    wall.material = material_index(s, c.material);
    const int index = world_.bed->add(std::move(wall));
    wall_[static_cast<std::size_t>(f)] = index;
    world_.surfaces.push_back(
        {.name = world_.bed->boundary(index).name, .owner = SurfaceRecord::Owner::container, .boundary = index});
  }
  shape_walls(0);
}

/// Walls as high as the container, or higher while spheres rain in.
void SoilBuilder::shape_walls(double extra_height) {
  if (!loaded_.scenario.soil || !loaded_.scenario.soil->container) return;
  const Container& c = *loaded_.scenario.soil->container;
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

dem::BedMaterial SoilBuilder::material() const {
  const int index = material_index(loaded_.scenario, bed().material);
  return {loaded_.scenario.materials[static_cast<std::size_t>(index)].density, index};
}

double SoilBuilder::rest_overlap(int a, int b) const {
  const int law = world_.laws.of(a, b);
  if (law < 0) return 0;
  return std::visit([](const auto& l) { return l.rest_overlap(); }, world_.laws.laws[static_cast<std::size_t>(law)]);
}

dem::LatticePlan SoilBuilder::lattice_plan(double pitch) const {
  const dem::BedMaterial of = material();
  dem::LatticePlan plan;
  plan.region = region();
  plan.radius = sizes_of(bed().radius);
  plan.shares = shares_of(bed().shares);
  plan.pitch = pitch;
  if (loaded_.scenario.soil->container)
    plan.floor_overlap =
        rest_overlap(of.material, material_index(loaded_.scenario, loaded_.scenario.soil->container->material));
  plan.depth = bed().depth.value_or(0);
  plan.jitter = bed().jitter;
  plan.seed = static_cast<std::uint64_t>(bed().seed);
  return plan;
}

std::vector<dem::SphereSpec> SoilBuilder::listed() const {
  std::vector<dem::SphereSpec> out;
  for (const Particle& p : bed().particles) {
    const int m = material_index(loaded_.scenario, p.material.empty() ? bed().material : p.material);
    out.push_back({p.position, p.velocity, p.spin, p.radius,
                   p.density.value_or(loaded_.scenario.materials[static_cast<std::size_t>(m)].density), m});
  }
  return out;
}

/// In ascending id of the file: the bed numbers its spheres in this order, so a saved bed keeps its numbers.
std::vector<dem::SphereSpec> SoilBuilder::from_file() const {
  const BedTable table = load_bed(bed().file, [](std::string_view unit, std::string_view si) {
    return unit.empty() || unit == si ? 1.0 : parse_quantity("1 " + std::string(unit), std::string(si));
  });
  if (table.size() == 0) throw std::invalid_argument(bed().file + ": holds no sphere");
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
  return out;
}

int SoilBuilder::material_of(const BedTable& table, std::size_t row) const {
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
  if (!options_.place_soil) world_.bed->add(options_.restored);
  if (!has_bed() || !options_.place_soil) return;
  try {
    const dem::RadiusDistribution sizes = sizes_of(bed().radius);
    const double mean = 0.5 * (dem::least_radius(sizes) + dem::largest_radius(sizes));
    switch (bed().fill) {
      case Fill::lattice:
        world_.bed->add(dem::lattice(lattice_plan(bed().pitch.value_or(2.02 * mean)), material()));
        break;
      case Fill::rest_lattice:
        world_.bed->add(dem::rest_lattice(lattice_plan(bed().pitch.value_or(0)),
                                          rest_overlap(material().material, material().material), material()));
        break;
      case Fill::particles:
        world_.bed->add(listed());
        break;
      case Fill::file:
        world_.bed->add(from_file());
        break;
      case Fill::random:
        if (!options_.settle) {
          // `check` only looks: a lattice of the mean radius at rest distance has about the spheres and contacts.
          dem::LatticePlan plan = lattice_plan(2 * mean - rest_overlap(material().material, material().material));
          plan.radius = dem::EqualRadius{mean};
          std::vector<dem::SphereSpec> stand_in = dem::lattice(plan, material());
          if (bed().count && stand_in.size() > static_cast<std::size_t>(*bed().count))
            stand_in.resize(static_cast<std::size_t>(*bed().count));
          world_.bed->add(stand_in);
        }
        break;
    }
  } catch (const ScenarioError&) {
    throw;
  } catch (const std::exception& error) {
    throw ScenarioError(loaded_.where("soil.bed") + ": " + error.what());
  }
}

bool SoilBuilder::settles() const {
  return has_bed() && options_.place_soil && (bed().settle.has_value() || bed().fill == Fill::random);
}

dem::StepQuestion SoilBuilder::question() const {
  dem::StepQuestion q{.smallest_radius = 1e300, .largest_radius = 0, .density = 1e300, .speed = 0, .neighbours = 0};
  for (const dem::Sphere& s : world_.bed->spheres()) {
    q.largest_radius = std::max(q.largest_radius, s.r);
    q.smallest_radius = std::min(q.smallest_radius, s.r);
    q.density = std::min(q.density, density(s));
  }
  q.neighbours = dem::most_neighbours(world_.bed->spheres().size());
  if (world_.bed->spheres().empty() && rains()) {
    const dem::RadiusDistribution sizes = sizes_of(bed().radius);
    q = {.smallest_radius = dem::least_radius(sizes),
         .largest_radius = dem::largest_radius(sizes),
         .density = material().density,
         .speed = 0,
         .neighbours = 12};
  }
  return q;
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
  try {
    dem::SettleReport report;
    if (rains()) {
      const dem::RadiusDistribution sizes = sizes_of(bed().radius);
      dem::RandomFill fill;
      fill.region = region();
      fill.radius = sizes;
      fill.shares = shares_of(bed().shares);
      fill.of = material();
      fill.seed = static_cast<std::uint64_t>(bed().seed);
      if (bed().count) fill.count = static_cast<std::size_t>(*bed().count);
      fill.depth = bed().depth;
      if (!fill.count && !fill.depth) fill.depth = fill.region.high.y - fill.region.low.y;
      // Loose spheres take up to four times the height of the settled bed; walls stand that high while it rains.
      shape_walls(4 * (fill.region.high.y - fill.region.low.y) + 20 * dem::largest_radius(sizes));
      report = dem::fill_at_random(*world_.bed, world_.laws, fill, plan);
      shape_walls(0);
    } else {
      report = dem::settle(*world_.bed, world_.laws, plan, region());
    }
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
    table.position.push_back(s.x);
    table.radius.push_back(s.r);
    table.density.push_back(density(s));
    table.material.push_back(loaded_.scenario.materials[s.material].name);
    table.velocity.push_back(s.v);
    table.spin.push_back(s.w);
  }
  save_bed(bed().save, table);
}

void SoilBuilder::finish() {
  if (!loaded_.scenario.soil) return;
  const Soil& soil = *loaded_.scenario.soil;
  dem::Bed& bed = *world_.bed;
  const bool has_spheres = !bed.spheres().empty();
  if (has_spheres) {
    const dem::BedReport r = dem::report(bed.spheres(), region());
    world_.soil.spheres = r.spheres;
    world_.soil.mass = r.mass;
    world_.soil.bulk_density = r.bulk_density;
    world_.soil.surface_mean = r.surface.mean;
    world_.soil.surface_spread = r.surface.spread;
    world_.soil.coordination = r.coordination;
  }
  if (soil.surface && has_spheres && options_.place_soil) {
    world_.container_shift = *soil.surface - world_.soil.surface_mean;
    const Vec3 up{0, world_.container_shift, 0};
    bed.shift(up);
    for (const SurfaceRecord& s : world_.surfaces)
      if (s.owner == SurfaceRecord::Owner::container) {
        dem::Boundary& wall = bed.boundary(s.boundary);
        wall.pose.position += up;
        wall.pose_before = wall.pose;  // a change of datum is no motion that does work
      }
    world_.soil.surface_mean = *soil.surface;
  }
  if (has_bed() && has_spheres && options_.settle && options_.place_soil && !world_.soil.stopped) save();
  if (soil.container) {
    for (int f = 0; f < 6; ++f)
      if (soil.container->open_after_settling[static_cast<std::size_t>(f)] && wall_[static_cast<std::size_t>(f)] >= 0)
        bed.boundary(wall_[static_cast<std::size_t>(f)]).active = false;
    bed.set_floor_drop(soil.container->at.y + world_.container_shift - soil.removal_below);
    bed.surfaces_changed();
  }
  bed.set_time(0);
  bed.reset_energy_book();
}

void SoilBuilder::clear_machine() {
  if (!has_bed()) return;
  std::vector<int> tools;
  for (const SurfaceRecord& s : world_.surfaces)
    if (s.owner == SurfaceRecord::Owner::machine) tools.push_back(s.boundary);
  if (tools.empty()) return;
  if (bed().inside_machine == Overlap::carve) {
    world_.soil.carved = dem::carve(*world_.bed, tools);
    return;
  }
  const std::vector<std::uint32_t> in_the_way = dem::spheres_in_the_way(*world_.bed, tools);
  if (!in_the_way.empty())
    throw ScenarioError(
        fmt::format("{}: {} spheres (first: {}) lie inside or overlap the machine's surfaces at the start; start the "
                    "machine outside "
                    "the soil, or say `inside machine: carve`",
                    loaded_.where("soil.bed"), in_the_way.size(), in_the_way.front()));
}

void SoilBuilder::check_wheel_datum() const {
  const Scenario& s = loaded_.scenario;
  if (!s.machine || !has_bed() || world_.bed->spheres().empty()) return;
  for (const NamedForce& f : s.machine->forces)
    if (const auto* wheel = std::get_if<mbd::WheelOnSoil>(&f.element)) {
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

}  // namespace subsoil::app
