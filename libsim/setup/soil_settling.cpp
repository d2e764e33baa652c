#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "libdem/particles/rigid_rotation.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/setup/bed_profile.hpp"
#include "libsim/setup/compaction_plate.hpp"
#include "libsim/setup/fibres.hpp"
#include "libsim/setup/soil.hpp"

/// How a bed comes to rest, and what is done to it then.
namespace subsoil::sim {

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
  fill.seed = static_cast<std::uint64_t>(bed().seed);
  if (layered()) {
    fill.layers = layers();
    return from_floor(std::move(fill));
  }
  fill.radius = sizes();
  fill.clumps = parts();
  fill.shares = shares_of(bed().shares);
  fill.of = material();
  if (bed().count) fill.count = static_cast<std::size_t>(*bed().count);
  fill.depth = bed().depth;
  if (!fill.count && !fill.depth) fill.depth = fill.region.high.y - fill.region.low.y;
  return from_floor(std::move(fill));
}

/// What is poured to a depth into a region as wide as the container fills that from its floor on: so far below, m.
double SoilBuilder::below_region() const {
  const auto& container = loaded_.scenario.soil->container;
  if (!container || bed().fill != Fill::random || bed().count) return 0;
  const dem::Bounds box = region();
  const auto spans = [&](int d) {
    return box.low[d] <= container->at[d] && box.high[d] >= container->at[d] + container->size[d];
  };
  return spans(0) && spans(2) ? std::max(0.0, box.low.y - container->at.y) : 0;
}

dem::RandomFill SoilBuilder::from_floor(dem::RandomFill fill) const {
  const double below = below_region();
  fill.region.low.y -= below;
  if (fill.depth) *fill.depth += below;
  for (dem::BedLayer& layer : fill.layers) layer.top += below;
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
  for (const dem::Clump& c : world_.bed->clumps()) {
    const dem::ClumpShape& shape = world_.bed->clump_shapes()[c.shape];
    table.clumps.push_back({.shape = shape.name,
                            .first = c.first_sphere,
                            .position = world_.bed->options().periodic.wrapped(c.position),
                            .attitude = c.attitude,
                            .velocity = c.velocity,
                            .spin = dem::angular_velocity_of(c.attitude, shape.inertia, c.angular_momentum)});
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
  if (has_spheres && has_bed() && options_.place_soil && !world_.soil.stopped) {
    // Before box and bed move together to the datum, so that a run with this container finds the bed on its floor; and
    // before its clumps fall apart into a rough floor.
    if (options_.settle) save();
    if (this->bed().rough_floor) fix_rough_floor();
  }
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

}  // namespace subsoil::sim
