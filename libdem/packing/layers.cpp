#include "libdem/packing/layers.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "libdem/particles/fixed.hpp"

namespace subsoil::dem {

std::vector<SphereSpec> layered_lattice(const LatticePlan& plan, std::span<const LatticeLayer> layers,
                                        std::vector<std::size_t>& numbers) {
  std::vector<SphereSpec> out;
  numbers.clear();
  const double floor = plan.region.low.y;
  double highest_row = 0;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const LatticeLayer& layer = layers[k];
    const double radius = largest_radius(layer.radius);
    const bool last = k + 1 == layers.size();
    LatticePlan own = plan;
    own.radius = layer.radius, own.shares = layer.shares, own.pitch = layer.pitch;
    own.seed = plan.seed + k;
    // The first row stands a radius less the floor's overlap above the region's lower face.
    if (k > 0) own.region.low.y = highest_row + layer.rise - radius + plan.floor_overlap;
    own.depth = floor + layer.top + (last ? 0 : 0.5 * layer.pitch) - own.region.low.y;
    own.region.high.y = own.region.low.y + std::max(own.depth, 2 * radius);
    const LatticeCount count = own.depth > 0 ? lattice_count(own) : LatticeCount{0, 0, 0};
    if (count.total() == 0)
      throw std::invalid_argument("bed: layer " + std::to_string(layers.size() - k) + " of " +
                                  std::to_string(layers.size()) +
                                  " is too thin for a row of its spheres; make it thicker, or its spheres smaller");
    const std::vector<SphereSpec> rows = lattice(own, layer.of);
    out.insert(out.end(), rows.begin(), rows.end());
    numbers.push_back(rows.size());
    highest_row = own.region.low.y + radius - plan.floor_overlap + static_cast<double>(count.y - 1) * layer.pitch;
  }
  return out;
}

std::vector<int> layers_by_depth(std::span<const Sphere> spheres, const Bounds& region,
                                 std::span<const BedLayer> layers) {
  const double surface = surface_height(spheres, region).mean, depth = layers.back().top;
  std::vector<int> out;
  for (const Sphere& s : spheres) {
    const double height = depth - (surface - s.x.y);
    const auto above =
        std::find_if(layers.begin(), layers.end() - 1, [&](const BedLayer& l) { return height < l.top; });
    out.push_back(static_cast<int>(above - layers.begin()));
  }
  return out;
}

std::vector<LayerReport> report_layers(std::span<const Sphere> spheres, const Bounds& region,
                                       std::span<const int> layer, std::size_t layers) {
  std::vector<LayerReport> out(layers);
  std::vector<Sphere> up_to;
  double below = region.low.y;
  for (std::size_t k = 0; k < layers; ++k) {
    LayerReport& r = out[k];
    for (const Sphere& s : spheres)
      if (layer[s.id] == static_cast<int>(k)) ++r.spheres, r.mass += s.m, up_to.push_back(s);
    const SurfaceHeight face = surface_height(up_to, region);
    r.top = face.mean, r.spread = face.spread, r.thickness = face.mean - below;
    below = face.mean;
  }
  return out;
}

}  // namespace subsoil::dem
