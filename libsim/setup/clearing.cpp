#include "libsim/setup/clearing.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "libdem/packing/carve.hpp"
#include "libdem/packing/measure.hpp"

namespace subsoil::sim {
namespace {

/// A guess where a solid with spheres inside is far larger than the soil: numbers in mm that were taken as m.
std::string unit_guess(const dem::Boundary& b, std::span<const dem::Sphere> spheres) {
  const dem::Bounds soil = dem::box_of(spheres);
  const dem::Bounds own = dem::bounds(b.shape);
  if (!std::isfinite(own.diagonal()) || own.diagonal() < 10 * soil.diagonal()) return {};
  return fmt::format("; {} is {:.3g} m large and the soil {:.3g} m: is the unit of its numbers right?", b.name,
                     own.diagonal(), soil.diagonal());
}

/// Makes room for tools and given solids in a bed.
class Clearing {
 public:
  Clearing(World& world, const Loaded& loaded, bool loose) : world_(world), loaded_(loaded), loose_(loose) {}
  void clear();

 private:
  Overlap rule() const { return loaded_.scenario.soil->bed->inside_machine; }
  void clear_given();
  void remove_in_the_way();
  [[noreturn]] void refuse_empty(const dem::Bounds& soil) const;

  World& world_;
  const Loaded& loaded_;
  bool loose_;
};

/// Spheres in the way of given surfaces. These join a bed that has settled only then, perhaps in the place of a wall:
/// who overlaps them by more than its contacts at rest do is in the way. What is placed may lie on a floor or a wall of
/// the scenario: there it takes half a radius.
void Clearing::clear_given() {
  const double placed = 0.5;
  const double allowed = loaded_.scenario.soil->bed->settles() ? std::min(placed, world_.bed->max_overlap()) : placed;
  for (const SurfaceRecord& r : world_.surfaces) {
    const dem::Boundary& b = world_.bed->boundary(r.boundary);
    if (r.owner != SurfaceRecord::Owner::given) continue;
    const auto inside = [&](const dem::Sphere& s) { return dem::inside_or_overlapping(s, b, -allowed * s.r); };
    const auto spheres = world_.bed->spheres();
    const auto first = std::find_if(spheres.begin(), spheres.end(), inside);
    if (first == spheres.end()) continue;
    if (rule() == Overlap::refuse) {
      if (loose_) {
        world_.soil.unsettled_inside += world_.bed->remove_if(inside);
        continue;
      }
      const auto count = static_cast<std::size_t>(std::count_if(spheres.begin(), spheres.end(), inside));
      throw ScenarioError(fmt::format(
          "{}: {} spheres (first: {}) lie inside or overlap `{}` at the start; {}{}", loaded_.where("soil.bed"), count,
          first->id, r.name,
          count == spheres.size()
              ? "a chamber around all of them is a mesh whose walls have a thickness, or an open one, both sides of "
                "which act; a tool starts outside the soil"
              : "boundaries join a bed that has settled: start it outside the soil, pour the soil in the run "
                "(`soil.inlets`), or remove these (`soil.bed.inside machine: carve`)",
          unit_guess(b, spheres)));
    }
    const int solid[] = {r.boundary};
    world_.soil.carved += r.moves ? dem::carve(*world_.bed, solid) : world_.bed->remove_if(inside);
  }
}

void Clearing::clear() {
  const dem::Bounds soil = dem::box_of(world_.bed->spheres());
  remove_in_the_way();
  if (world_.soil.carved + world_.soil.unsettled_inside == 0) return;
  if (world_.bed->spheres().empty()) refuse_empty(soil);
  if (world_.soil.carved == 0) return;
  world_.bed->reset_energy_balance();         // what is carved was never of the run
  if (loaded_.scenario.soil->moving) return;  // count_window()
  world_.soil.spheres = 0, world_.soil.mass = 0, world_.soil.clumps = world_.bed->clumps().size();
  for (const dem::Sphere& s : world_.bed->spheres())
    if (s.id < world_.soil.fibres_from) ++world_.soil.spheres, world_.soil.mass += s.m;
}

/// A solid that takes all spheres away leaves nothing to simulate: nearly always a unit that is wrong.
/// @param soil box of what was there
void Clearing::refuse_empty(const dem::Bounds& soil) const {
  std::vector<std::string> solids;
  for (const SurfaceRecord& s : world_.surfaces) {
    if (s.owner == SurfaceRecord::Owner::container) continue;
    const dem::Boundary& b = world_.bed->boundary(s.boundary);
    if (std::holds_alternative<dem::Plane>(b.shape)) continue;
    solids.push_back(fmt::format("`{}` ({:.3g} m large)", s.name, dem::bounds(b.shape).diagonal()));
  }
  throw ScenarioError(
      fmt::format("{}: no sphere is left: all {} lie inside {} at the start, in a soil {:.3g} m large; is the unit of "
                  "its numbers right? make it smaller, or start it outside the soil",
                  loaded_.where("soil.bed.inside machine"), world_.soil.carved + world_.soil.unsettled_inside,
                  fmt::join(solids, " or "), soil.diagonal()));
}

void Clearing::remove_in_the_way() {
  std::vector<int> tools;
  for (const SurfaceRecord& s : world_.surfaces)
    if (s.owner == SurfaceRecord::Owner::machine && s.mesh == 0) tools.push_back(s.boundary);
  clear_given();
  if (tools.empty()) return;
  if (rule() == Overlap::carve) {
    world_.soil.carved += dem::carve(*world_.bed, tools);
    return;
  }
  const std::vector<std::uint32_t> in_the_way = dem::spheres_in_the_way(*world_.bed, tools);
  if (in_the_way.empty()) return;
  if (loose_) {
    world_.soil.unsettled_inside += dem::carve(*world_.bed, tools);
    return;
  }
  std::string guess;
  for (const int tool : tools)
    if (guess.empty()) guess = unit_guess(world_.bed->boundary(tool), world_.bed->spheres());
  throw ScenarioError(
      fmt::format("{}: {} spheres (first: {}) lie inside or overlap the machine's surfaces at the start; start the "
                  "machine outside the soil, or say `inside machine: carve`{}",
                  loaded_.where("soil.bed"), in_the_way.size(), in_the_way.front(), guess));
}

}  // namespace

void clear_machine(World& world, const Loaded& loaded, bool loose) {
  if (loaded.scenario.soil && loaded.scenario.soil->bed) Clearing(world, loaded, loose).clear();
}

}  // namespace subsoil::sim
