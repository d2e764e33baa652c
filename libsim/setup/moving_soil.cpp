#include "libsim/setup/moving_soil.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/setup/soil.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

/// The scenario of one period.
Loaded one_period(const Loaded& loaded) {
  Loaded out = loaded;
  Soil& soil = *out.scenario.soil;
  soil.container->size.x = soil.moving->period.value_or(soil.moving->block);
  soil.container->periodic[0] = true;
  soil.moving.reset();
  return out;
}

/// Of the container, which is the window, with what is held at both ends.
Loaded with_held_ends(const Loaded& loaded, double held) {
  Loaded out = loaded;
  Container& c = *out.scenario.soil->container;
  c.at.x -= held, c.size.x += 2 * held;
  return out;
}

dem::MovingBedPlan plan_of(const Soil& soil) {
  const Container& c = *soil.container;
  const int direction = soil.moving->direction();
  return {.rear = direction > 0 ? c.at.x : c.at.x + c.size.x,
          .step = soil.moving->block,
          .steps = static_cast<int>(std::lround(c.size.x / soil.moving->block)),
          .direction = direction};
}

void add_walls(World& world, const Loaded& loaded, const BuildOptions& options, double held) {
  const Loaded extended = with_held_ends(loaded, held);
  SoilBuilder(world, extended, options).place_walls();
  for (SurfaceRecord& s : world.surfaces) s.moves = true;
}

/// All surfaces that there are so far are walls.
void follow_with(World& world, dem::MovingBed window) {
  world.moving = std::make_shared<MovingSoil>(MovingSoil{.window = std::move(window), .walls = {}});
  for (const SurfaceRecord& s : world.surfaces) world.moving->walls.push_back(s.boundary);
}

/// Made as any bed is, but settled without its window: what it took stands in the report of the window.
World settled_period(const World& world, const Loaded& one, const BuildOptions& options, dem::BedOptions bed) {
  World block;
  block.laws = world.laws;
  bed.periodic = periodic_cell(*one.scenario.soil->container);
  block.bed = std::make_unique<dem::Bed>(world.laws, bed);
  SoilBuilder soil(block, one, options);
  soil.place();
  if (soil.settles() && options.settle) {
    choose_step(block, one, soil.question());
    soil.settle(one.scenario.time.soil_step ? *one.scenario.time.soil_step
                                            : one.scenario.time.safety * block.step.limit.step);
  }
  soil.finish();
  return block;
}

/// Where the block's boundaries, its floor and side walls, stand in the list of the window's.
std::vector<int> same_walls(const World& block, const World& window) {
  std::vector<int> out;
  for (int b = 0; b < block.bed->boundary_count(); ++b)
    for (const SurfaceRecord& s : window.surfaces)
      if (s.name == block.bed->boundary(b).name) out.push_back(s.boundary);
  return out;
}

/// Fibres by their numbers in the period, in which spheres are numbered from 0 in the order that they have there.
void find_fibres(World& world, const World& block) {
  if (block.fibres.empty()) return;
  std::size_t before = 0, of_fibres = 0, expected = 0;
  for (const dem::Sphere& s : block.bed->spheres())
    (is_of_fibres(block, s.id) ? of_fibres : before) += s.id < block.fibres.back().end() ? 1 : 0;
  for (const FibreGroup& group : block.fibres) expected += group.count * group.per_fibre();
  if (of_fibres != expected)
    throw std::invalid_argument(
        fmt::format("{} of {} spheres of fibres left the bed while it settled; a period needs them all",
                    expected - of_fibres, expected));
  world.soil.fibres_from = static_cast<std::uint32_t>(before);
  world.fibres = block.fibres;
  number_fibres(world);
}

/// Spheres and mass are those in the window; what says how dense the bed is and how deep is of the period.
void report_window(World& world, const World& block) {
  world.soil = block.soil;
  find_fibres(world, block);
  count_window(world);
}

}  // namespace

FreeSoil free_soil(const dem::Bed& bed) {
  FreeSoil out;
  for (const dem::Sphere& s : bed.spheres())
    if (!dem::is_fixed(s)) ++out.spheres, out.mass += s.m;
  return out;
}

void count_window(World& world) {
  world.soil.spheres = 0, world.soil.mass = 0, world.soil.clumps = world.bed->clumps().size();
  for (const dem::Sphere& s : world.bed->spheres())
    if (!dem::is_fixed(s) && !is_of_fibres(world, s.id)) ++world.soil.spheres, world.soil.mass += s.m;
}

double MovingSoil::x_of_followed(const coupling::Simulation& simulation) const {
  return boundary >= 0 ? simulation.surface_pose(boundary).position.x : simulation.body(body).r.x;
}

bool MovingSoil::follow(dem::Bed& bed, const coupling::Simulation& simulation) {
  if (boundary < 0 && body == 0) return false;
  const double gone = window.plan().direction * (x_of_followed(simulation) - start);
  // A rounding below a whole block is no step late: it would be one more or less on another machine.
  constexpr double close = 1e-9;
  if (gone < window.way() + window.plan().step * (1 - close)) return false;
  window.advance(bed, walls);
  return true;
}

void build_moving_soil(World& world, const Loaded& loaded, const BuildOptions& options, const dem::BedOptions& bed) {
  const Soil& soil = *loaded.scenario.soil;
  if (!options.place_soil) {
    if (options.moving == nullptr)
      throw ScenarioError(loaded.where("soil.moving") +
                          ": the state holds no moving bed; take one that this scenario wrote");
    add_walls(world, loaded, options, options.moving->held_length());
    follow_with(world, *options.moving);
    for (const dem::ClumpShape& shape : options.moving->block().shapes) world.bed->add_shape(shape);
    world.bed->add(options.restored);
    return;
  }
  World block = settled_period(world, one_period(loaded), options, bed);
  try {
    double largest = 0;
    for (const dem::Sphere& s : block.bed->spheres()) largest = std::max(largest, s.r);
    for (const dem::Clump& c : block.bed->clumps())
      largest = std::max(largest, block.bed->clump_shapes()[c.shape].reach);
    const dem::MovingBedPlan plan = plan_of(soil);
    world.container_shift = block.container_shift;
    add_walls(world, loaded, options, dem::MovingBed::held_length(largest));
    follow_with(world, dem::MovingBed(dem::block_of(*block.bed, same_walls(block, world)), plan));
    for (const dem::ClumpShape& shape : block.bed->clump_shapes()) world.bed->add_shape(shape);
    world.moving->window.fill(*world.bed);
    report_window(world, block);
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(loaded.where("soil.moving") + ": " + error.what());
  }
  world.bed->set_time(0);
  world.bed->reset_energy_balance();
}

void find_followed(World& world, const Loaded& loaded) {
  MovingSoil& moving = *world.moving;
  const std::string& name = loaded.scenario.soil->moving->follows;
  for (const SurfaceRecord& s : world.surfaces)
    if (s.owner == SurfaceRecord::Owner::given && s.name == name) {
      moving.boundary = s.boundary;
      moving.start = world.bed->boundary(s.boundary).pose.position.x;
    }
  if (moving.boundary < 0 && world.machine)
    for (int b = 1; b < world.machine->system().bodies(); ++b)
      if (world.machine->system().body_name(b) == name) {
        moving.body = b;
        moving.start = world.machine->body(b).r.x;
      }
  const dem::MovingBed& window = moving.window;
  const int direction = window.plan().direction;
  const double from_rear = direction * (moving.start - window.plan().rear);
  const double length = window.length();
  if (from_rear < 0 || from_rear > length)
    throw ScenarioError(
        fmt::format("{} = {}: starts at x = {:.6g} m, outside of the window, the container from {:.6g} to {:.6g} m, "
                    "whose ends are held "
                    "in place; start it inside, above the soil or with `inside machine: carve`",
                    loaded.where("soil.moving.follows"), name, moving.start, std::min(window.rear(), window.front()),
                    std::max(window.rear(), window.front())));
}

}  // namespace subsoil::sim
