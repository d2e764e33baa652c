#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "libdem/packing/settle.hpp"
#include "libdem/packing/settler.hpp"

namespace subsoil::dem {
namespace {

constexpr int kRefills = 8;    ///< of a bed that has sunk below its depth
constexpr double kRoom = 1.1;  ///< from the loosest packing to the densest, 0.58 to 0.64

/// Of each clump, m.
std::vector<double> highest_centres(const Bed& bed) {
  std::vector<double> out(bed.clumps().size(), -std::numeric_limits<double>::infinity());
  if (out.empty()) return out;
  for (const Sphere& s : bed.spheres())
    if (const long clump = bed.clump_of(s); clump >= 0) {
      double& top = out[static_cast<std::size_t>(clump)];
      top = std::max(top, s.x.y);
    }
  return out;
}

/// Height of a cut that takes off all free spheres whose centres lie above it and leaves the mean surface at the
/// target. The surface falls with the cut, by steps as spheres go: bisection ends at the step nearest to the target.
double level_cut(const Bed& bed, const Bounds& region, double target) {
  const std::span<const Sphere> spheres = bed.spheres();
  double low = region.low.y, high = surface_height(spheres, region).highest;
  const std::vector<double> top_of_clump = highest_centres(bed);
  std::vector<Sphere> left;
  for (int k = 0; k < 40; ++k) {
    const double cut = 0.5 * (low + high);
    left.clear();
    for (const Sphere& s : spheres) {
      const long clump = bed.clump_of(s);
      if (is_fixed(s) || (clump < 0 ? s.x.y : top_of_clump[static_cast<std::size_t>(clump)]) <= cut) left.push_back(s);
    }
    (surface_height(left, region).mean > target ? high : low) = cut;
  }
  return low;
}

/// Solid volume per volume of what was added on top of a surface: overlapping spheres count in full.
double solid_fraction(const Bed& bed, const Bounds& region, std::uint32_t first, double below, double area) {
  double volume = 0;
  for (const Sphere& s : bed.spheres())
    if (s.id >= first) volume += bed.volume_of(s);
  return volume / (area * (surface_height(bed.spheres(), region).mean - below));
}

/// Share of the missing height by which the surface rises at least under grains that fill it.
constexpr double kRises = 0.1;

[[noreturn]] void refuse_to_pile_up(std::size_t grains, double risen, double missing) {
  char text[300];
  std::snprintf(
      text, sizeof text,
      "random bed: %zu grains rained into the region and raised the surface there by %.3g mm of %.3g mm: they "
      "roll or fall out of it; make `region` as wide as the container, begin it at the floor, or give `count` in place "
      "of a depth",
      grains, 1e3 * risen, 1e3 * missing);
  throw std::invalid_argument(text);
}

/// Rains spheres until they lie as high as the layer goes, and a diameter more for the shrinking under attraction and
/// the levelling.
void rain_layer(Bed& bed, const LawTable& laws, const Bounds& region, const BedLayer& layer, std::uint64_t seed,
                Settler& settler) {
  LoosePlacer placer(region, layer.radius, layer.shares, seed, layer.of, layer.clumps);
  const Vec3 size = region.high - region.low;
  const double area = size.x * size.z, floor = region.low.y;
  double diameter = least_radius(layer.radius) + largest_radius(layer.radius);
  for (const ClumpPart& part : layer.clumps) diameter = std::max(diameter, 2 * part.reach);
  const int law = laws.of(layer.of.material, layer.of.material);
  const double overlap = law < 0 ? 0 : laws.laws[static_cast<std::size_t>(law)]->rest_overlap();
  // Loose random packing, 0.60 of solid; spheres that rest with an overlap stand as close as smaller ones.
  const double closer = diameter / (diameter - std::clamp(overlap, 0.0, 0.5 * diameter));
  double fraction = 0.60 * closer * closer * closer;
  // Before the first grains only stones may be there, whose width is not that of the columns.
  const auto surface = [&] {
    const std::span<const Sphere> spheres = bed.spheres();
    return (std::all_of(spheres.begin(), spheres.end(), is_fixed) ? surface_height(spheres, region, 2 * diameter)
                                                                  : surface_height(spheres, region))
        .mean;
  };
  const std::uint32_t first = settler.next_id();
  const double below = settler.measured(surface);
  constexpr int attempts = 5;
  for (int k = 0; k < attempts && !settler.stopped(); ++k) {
    const double missing = floor + layer.top + diameter - settler.measured(surface);
    if (missing <= 0.5 * diameter) return;
    const double top = settler.measured([&] { return highest_top(bed.spheres(), floor); });
    const Grains grains = placer.grains_of_volume(fraction * area * missing, top);
    if (!settler.waits()) add(bed, grains);
    settler.rain();
    const double risen = settler.measured(surface) - (floor + layer.top + diameter - missing);
    if (risen < kRises * missing && !settler.stopped()) refuse_to_pile_up(grains.count(), risen, missing);
    fraction = settler.measured([&] { return solid_fraction(bed, region, first, below, area); });
  }
}

std::size_t level(Bed& bed, const Bounds& region, double top, Settler& settler) {
  return static_cast<std::size_t>(settler.measured([&] {
    const double cut = level_cut(bed, region, region.low.y + top);
    return static_cast<double>(bed.remove_if([&](const Sphere& s) { return !is_fixed(s) && s.x.y > cut; }));
  }));
}

/// One layer after the other, each compacted where a load is, onto what lies.
class LayeredRain {
 public:
  LayeredRain(Bed& bed, const LawTable& laws, const RandomFill& fill, const SettlePlan& plan, Settler& settler)
      : bed_(bed), laws_(laws), fill_(fill), plan_(plan), settler_(settler) {}

  /// @param again how often it has been rained and levelled before
  void rain(const std::vector<BedLayer>& layers, std::size_t k, int again = 0) {
    const double below = k == 0 ? 0 : layers[k - 1].top;
    BedLayer room = layers[k];
    if (plan_.compaction.any()) room.top = below + kRoom * (room.top - below);
    for (int n = 0; n < kRefills && !settler_.stopped(); ++n) {
      if (n + again > 0 && plan_.staged) settler_.soften();
      rain_layer(bed_, laws_, fill_.region, room,
                 fill_.seed + k + 1000 * static_cast<std::uint64_t>(n + kRefills * again), settler_);
      const bool last = k + 1 == layers.size();
      if (plan_.staged && (last || plan_.compaction.load != nullptr)) settler_.raise();
      if (last) settler_.finish();
      if (plan_.compaction.load != nullptr || last) settler_.compact(layers.back().top);
      if (!plan_.compaction.any() || reaches(layers[k].top)) break;
    }
    if (plan_.staged && plan_.compaction.load != nullptr && k + 1 < layers.size()) settler_.soften();
  }

 private:
  bool reaches(double top) {
    return settler_.measured([&] {
      return surface_height(bed_.spheres(), fill_.region).mean >= fill_.region.low.y + top ? 1.0 : 0.0;
    }) > 0;
  }
  Bed& bed_;
  const LawTable& laws_;
  const RandomFill& fill_;
  const SettlePlan& plan_;
  Settler& settler_;
};

void check_layers(const std::vector<BedLayer>& layers) {
  double below = 0;
  for (const BedLayer& layer : layers) {
    if (!(layer.top - below >= 2 * largest_reach(layer.radius, layer.clumps)))
      throw std::invalid_argument(layers.size() == 1
                                      ? "random bed: the depth must be at least a grain's diameter"
                                      : "random bed: each layer must be at least a grain's diameter thick");
    below = layer.top;
  }
}

}  // namespace

SettleReport fill_at_random(Bed& bed, const LawTable& laws, const RandomFill& fill, const SettlePlan& plan) {
  if (fill.count.has_value() + fill.depth.has_value() + !fill.layers.empty() != 1)
    throw std::invalid_argument("random bed: give either the number of spheres, the depth to fill, or layers");
  std::vector<BedLayer> layers = fill.layers;
  if (fill.depth)
    layers = {{.top = *fill.depth, .radius = fill.radius, .shares = fill.shares, .of = fill.of, .clumps = fill.clumps}};
  check_layers(layers);
  Settler settler(bed, laws, plan, fill.region);
  plan.staged ? settler.soften() : settler.harden();
  std::size_t levelled = 0;
  std::vector<std::uint32_t> ends;
  if (fill.count) {
    LoosePlacer placer(fill.region, fill.radius, fill.shares, fill.seed, fill.of, fill.clumps);
    if (plan.from == nullptr) add(bed, placer.grains(*fill.count, highest_top(bed.spheres(), fill.region.low.y)));
    if (plan.staged) settler.rain();
  }
  for (std::size_t k = 0; k < layers.size() && !settler.stopped(); ++k) {
    if (k > 0) levelled += level(bed, fill.region, layers[k - 1].top, settler);
    LayeredRain(bed, laws, fill, plan, settler).rain(layers, k);
    ends.push_back(settler.next_id());
  }
  if (fill.count) {
    settler.aim_at_once();
    if (plan.staged) settler.raise();
    settler.finish();
    settler.compact();
  }
  for (int n = 0; n < kRefills && !layers.empty() && !settler.stopped(); ++n) {
    levelled += level(bed, fill.region, layers.back().top, settler);
    settler.finish();
    if (!plan.compaction.density || settler.stopped() || settler.is_dense()) break;
    settler.aim_by_what_is_left();
    LayeredRain(bed, laws, fill, plan, settler).rain(layers, layers.size() - 1, n + 1);
  }
  settler.require_density();
  settler.cover();
  SettleReport out = settler.done();
  out.levelled = levelled;
  if (!fill.layers.empty()) out.layer_ends = ends;
  return out;
}

}  // namespace subsoil::dem
